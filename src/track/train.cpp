// Matrices of a train: each body has its height and, if it is long, its pitch; springs join points
// of bodies. A point at distance d ahead of a body's centre stands at height z + d phi, so a spring
// between two points is one row of four numbers, whose outer product is its share of K and of C.
// Small angles; horizontal motion is given. Static sag of the springs is in the unknowns: heights
// count from where nothing is loaded.
#include "trackbed/track/train.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "trackbed/core/error.hpp"
#include "trackbed/core/types.hpp"

namespace trackbed::track {

namespace {

// A point of a body: unknowns of height and pitch (-1: none), distance ahead of the centre, m.
struct Point {
  std::int32_t height, pitch;
  double ahead;
};

// Collects bodies and springs; both know only unknowns, so a vehicle of any layout can be built.
class Builder {
 public:
  explicit Builder(double share) : share_(share) {}

  // A body with pitch if it has inertia. Returns its first unknown.
  std::int32_t body(double mass, double inertia) {
    const std::int32_t first = next_;
    mass_.emplace_back(next_, next_, mass * share_);
    weight_.push_back(-mass * share_ * gravity);
    ++next_;
    if (inertia <= 0) return first;
    mass_.emplace_back(next_, next_, inertia * share_);
    weight_.push_back(0);
    ++next_;
    return first;
  }

  // Stretch of the spring = row . u; its share of K is stiffness row row^T, of C likewise.
  void join(const Point& upper, const Point& lower, double stiffness, double damping) {
    const std::pair<std::int32_t, double> row[] = {{upper.height, 1},
                                                   {upper.pitch, upper.ahead},
                                                   {lower.height, -1},
                                                   {lower.pitch, -lower.ahead}};
    for (const auto& [i, a] : row)
      for (const auto& [j, b] : row) {
        if (i < 0 || j < 0) continue;
        stiffness_.emplace_back(i, j, a * b * stiffness * share_);
        damping_.emplace_back(i, j, a * b * damping * share_);
      }
  }

  std::int32_t unknowns() const { return next_; }
  LinearSystem system() const {
    const auto matrix = [this](const std::vector<Eigen::Triplet<double>>& entries) {
      Sparse m(next_, next_);
      m.setFromTriplets(entries.begin(), entries.end());
      return m;
    };
    return {matrix(mass_), matrix(damping_), matrix(stiffness_)};
  }
  Vector weight() const {
    return Eigen::Map<const Vector>(weight_.data(), static_cast<Eigen::Index>(weight_.size()));
  }

 private:
  double share_;  // of the vehicle that one rail carries
  std::int32_t next_ = 0;
  std::vector<Eigen::Triplet<double>> mass_, damping_, stiffness_;
  std::vector<double> weight_;
};

// Unknown of each wheelset, front first.
std::vector<std::int32_t> add_coach(Builder& to, const VehicleParameters& v) {
  std::vector<std::int32_t> wheelsets;
  const std::int32_t body = to.body(v.body_mass, v.body_inertia);
  for (const double side : {1.0, -1.0}) {
    const std::int32_t bogie = to.body(v.bogie_mass, v.bogie_inertia);
    to.join({body, body + 1, side * v.bogie_distance / 2}, {bogie, -1, 0}, v.secondary_stiffness,
            v.secondary_damping);
    for (const double end : {1.0, -1.0}) {
      wheelsets.push_back(to.body(v.wheelset_mass, 0));
      to.join({bogie, bogie + 1, end * v.wheelbase / 2}, {wheelsets.back(), -1, 0},
              v.primary_stiffness, v.primary_damping);
    }
  }
  return wheelsets;
}

// A wheelset stands for both its wheels: roll is not modelled.
std::vector<std::int32_t> add_bodies(Builder& to, const VehicleParameters& v) {
  if (v.kind == VehicleKind::coach) return add_coach(to, v);
  if (v.kind == VehicleKind::wheel) return {to.body(v.wheelset_mass, 0)};
  const std::int32_t body = to.body(v.body_mass, 0), wheelset = to.body(v.wheelset_mass, 0);
  to.join({body, -1, 0}, {wheelset, -1, 0}, v.primary_stiffness, v.primary_damping);
  return {wheelset};
}

// m behind the vehicle's front.
std::vector<double> axles_of(const VehicleParameters& v) {
  if (v.kind == VehicleKind::forces) return v.axles;
  if (v.kind != VehicleKind::coach) return {v.length / 2};
  const double front = v.length / 2 - v.bogie_distance / 2 - v.wheelbase / 2;
  return {front, front + v.wheelbase, front + v.bogie_distance,
          front + v.bogie_distance + v.wheelbase};
}

// One of the deck's own, or of the library.
VehicleParameters found(const std::string& name, const std::vector<VehicleParameters>& known) {
  for (const auto* list : {&known, &vehicle_library()})
    for (const VehicleParameters& vehicle : *list)
      if (vehicle.name == name) return complete(vehicle);
  throw InputError({"train.vehicles: " + why_no_vehicle(name, known)});
}

// kg, of the whole vehicle.
double mass_of(const VehicleParameters& v) {
  switch (v.kind) {
    case VehicleKind::coach:
      return v.body_mass + 2 * v.bogie_mass + 4 * v.wheelset_mass;
    case VehicleKind::sprung:
      return v.body_mass + v.wheelset_mass;
    default:
      return v.wheelset_mass;
  }
}

}  // namespace

// Vehicles stand coupling to coupling. Distances count from the first axle, which is what a train
// is placed by; the front of the first vehicle is out of the model.
Train::Train(const TrainParameters& parameters, const std::vector<VehicleParameters>& known,
             std::int64_t rails) {
  const double share = 1 / static_cast<double>(rails);
  Builder builder(share);
  double front = 0;  // m, of the vehicle, behind the train's
  for (const std::string& name : parameters.vehicles) {
    const VehicleParameters v = found(name, known);
    if (const auto missing = lacking(v); !missing.empty())
      throw InputError({fmt::format("vehicle \"{}\" lacks {}", name, fmt::join(missing, ", "))});
    const std::vector<double> axles = axles_of(v);
    first_.push_back(builder.unknowns());
    std::vector<std::int32_t> wheelsets(axles.size(), -1);
    if (v.kind != VehicleKind::forces) wheelsets = add_bodies(builder, v);
    for (std::size_t i = 0; i < axles.size(); ++i) {
      const bool constant = v.kind == VehicleKind::forces;
      const double each = mass_of(v) * gravity * share / static_cast<double>(axles.size());
      wheels_.push_back({front + axles[i], wheelsets[i], constant ? v.loads[i] * share : 0, each});
    }
    vehicles_.push_back(v);
    front += v.length;
  }
  const double first = wheels_.empty() ? 0 : wheels_.front().behind;
  for (Wheel& wheel : wheels_) wheel.behind -= first;
  system_ = builder.system();
  weight_ = builder.weight();
}

// The last axle need not be the last wheel of the list: patterns of forces come in any order.
double Train::axle_distance() const {
  double last = 0;
  for (const Wheel& wheel : wheels_) last = std::max(last, wheel.behind);
  return last;
}

// Rows and columns of the wheelsets are left out: that is to hold them.
//   K x = w^2 M x,   f = w/(2 pi)
std::vector<double> natural_frequencies(const VehicleParameters& vehicle) {
  const VehicleParameters v = complete(vehicle);
  if (v.kind == VehicleKind::forces || v.kind == VehicleKind::wheel) return {};
  Builder builder(1);
  const std::vector<std::int32_t> held = add_bodies(builder, v);
  std::vector<Eigen::Index> kept;
  for (std::int32_t i = 0; i < builder.unknowns(); ++i)
    if (std::find(held.begin(), held.end(), i) == held.end()) kept.push_back(i);
  const LinearSystem system = builder.system();
  const Eigen::MatrixXd k = Eigen::MatrixXd(system.stiffness)(kept, kept);
  const Eigen::MatrixXd m = Eigen::MatrixXd(system.mass)(kept, kept);
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(k, m);
  std::vector<double> frequencies;
  for (const double square : modes.eigenvalues())
    frequencies.push_back(std::sqrt(std::max(square, 0.0)) / (2 * std::numbers::pi));
  return frequencies;
}

}  // namespace trackbed::track
