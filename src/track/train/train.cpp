// Matrices of a train: each body has a height and, if it has pitch inertia, a pitch, and on two
// rails a roll; springs connect points of bodies. A point d ahead of a body's centre and y to its
// left has the height z + d theta + y phi, so that a spring between two points is one row vector,
// whose outer product is its contribution to K and C. Small angles; the motion along the track is
// prescribed, and there is none across it: a body's height above its springs does not matter. The
// unknowns include the static deflection of the springs: heights are relative to unloaded springs.
#include "trackbed/track/train.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "trackbed/core/decompositions.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/types.hpp"
#include "trackbed/track/vehicle_layout.hpp"

namespace trackbed::track {

namespace {

// N/m, N s/m.
struct Kelvin {
  double stiffness, damping;
};

// Indices, -1: none.
struct BodyUnknowns {
  std::int32_t height, pitch = -1, roll = -1;
};

// Where springs are attached: a body, m ahead of its centre.
struct Attachment {
  BodyUnknowns body;
  double ahead = 0;
};

struct Inertia {
  double mass, pitch = 0, roll = 0;  // kg, kg m^2
  double offset = 0;                 // m, lateral offset of the centre of mass to the left
};

// Collects bodies and springs by their unknowns, for vehicles of any layout.
class Builder {
 public:
  // `fraction`: of the vehicle that one rail carries.
  Builder(double fraction, bool rolls) : fraction_(fraction), rolls_(rolls) {}

  // Pitch if it has inertia for it, roll on two rails. With a lateral offset e of the centre of
  // mass its velocity is z' + e phi', which couples both.
  BodyUnknowns body(const Inertia& of) {
    const double mass = of.mass * fraction_, aside = of.offset;
    BodyUnknowns made{.height = add(mass, -mass * gravity)};
    if (of.pitch > 0) made.pitch = add(of.pitch * fraction_, 0);
    if (!rolls_) return made;
    made.roll = add(of.roll * fraction_ + mass * aside * aside, -mass * gravity * aside);
    mass_.emplace_back(made.height, made.roll, mass * aside);
    mass_.emplace_back(made.roll, made.height, mass * aside);
    return made;
  }

  // Springs of both sides together, `base` m apart, which matters for roll only.
  void join(const Attachment& upper, const Attachment& lower, const Kelvin& both, double base) {
    if (!rolls_) return join(upper, lower, 0, both);
    const Kelvin one{both.stiffness / 2, both.damping / 2};
    for (const double side : {1.0, -1.0}) join(upper, lower, side * base / 2, one);
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
  std::int32_t add(double inertia, double weight) {
    mass_.emplace_back(next_, next_, inertia);
    weight_.push_back(weight);
    return next_++;
  }

  // Elongation of the spring = row . u; it adds stiffness row row^T to K, and likewise to C.
  void join(const Attachment& upper, const Attachment& lower, double aside, const Kelvin& spring) {
    const std::pair<std::int32_t, double> row[] = {
        {upper.body.height, 1},  {upper.body.pitch, upper.ahead},  {upper.body.roll, aside},
        {lower.body.height, -1}, {lower.body.pitch, -lower.ahead}, {lower.body.roll, -aside}};
    for (const auto& [i, a] : row)
      for (const auto& [j, b] : row) {
        if (i < 0 || j < 0) continue;
        stiffness_.emplace_back(i, j, a * b * spring.stiffness * fraction_);
        damping_.emplace_back(i, j, a * b * spring.damping * fraction_);
      }
  }

  double fraction_;
  bool rolls_;
  std::int32_t next_ = 0;
  std::vector<Eigen::Triplet<double>> mass_, damping_, stiffness_;
  std::vector<double> weight_;
};

// A bogie below a point of a body; its wheelsets are appended to the list, front first.
void add_bogie(Builder& to, const VehicleParameters& v, const Attachment& above,
               std::vector<BodyUnknowns>& wheelsets) {
  const BodyUnknowns bogie = to.body({v.bogie_mass, v.bogie_inertia, v.bogie_roll});
  to.join(above, {bogie}, {v.secondary_stiffness, v.secondary_damping}, v.secondary_base);
  for (const double end : {1.0, -1.0}) {
    wheelsets.push_back(to.body({v.wheelset_mass, 0, v.wheelset_roll}));
    to.join({bogie, end * v.wheelbase / 2}, {wheelsets.back()},
            {v.primary_stiffness, v.primary_damping}, v.primary_base);
  }
}

// On one rail a wheelset represents both its wheels.
std::vector<BodyUnknowns> add_bodies(Builder& to, const VehicleParameters& v) {
  const VehicleLayout layout = layout_of(v.kind);
  if (!layout.body) return {to.body({v.wheelset_mass, 0, v.wheelset_roll})};
  const double inertia = layout.pitches ? v.body_inertia : 0;
  const BodyUnknowns body = to.body({v.body_mass, inertia, v.body_roll, v.body_offset});
  std::vector<BodyUnknowns> wheelsets;
  for (int bogie = 0; bogie < layout.bogies; ++bogie)
    add_bogie(to, v, {body, ((layout.bogies - 1) / 2.0 - bogie) * v.bogie_distance}, wheelsets);
  if (layout.bogies > 0) return wheelsets;
  const BodyUnknowns wheelset = to.body({v.wheelset_mass, 0, v.wheelset_roll});
  to.join({body}, {wheelset}, {v.primary_stiffness, v.primary_damping}, v.primary_base);
  return {wheelset};
}

// A vehicle of the deck or of the library.
VehicleParameters find_vehicle(const std::string& name,
                               const std::vector<VehicleParameters>& known) {
  for (const auto* list : {&known, &vehicle_library()})
    for (const VehicleParameters& vehicle : *list)
      if (vehicle.name == name) return complete(vehicle);
  throw InputError({"train.vehicles: " + why_no_vehicle(name, known)});
}

}  // namespace

// Vehicles are arranged coupling to coupling. Distances are relative to the first axle, by which a
// train is placed; the front of the first vehicle is not part of the model.
Train::Train(const TrainParameters& parameters, const std::vector<VehicleParameters>& known,
             std::int64_t rails, double gauge) {
  const bool rolls = gauge > 0;
  const double fraction = rolls ? 1 : 1 / static_cast<double>(rails);
  Builder builder(fraction, rolls);
  double front = 0;  // m, of the vehicle, behind the train's
  std::size_t number = 0;
  for (const std::string& name : parameters.vehicles) {
    const VehicleParameters v = find_vehicle(name, known);
    if (const auto missing = lacking(v); !missing.empty())
      throw InputError(
          {fmt::format("vehicle \"{}\" also needs {}", name, fmt::join(missing, ", "))});
    const VehicleLayout layout = layout_of(v.kind);
    const bool constant = layout.constant;
    const std::vector<double> axles = axles_of(v);
    first_.push_back(builder.unknowns());
    std::vector<BodyUnknowns> wheelsets(axles.size(), BodyUnknowns{-1});
    if (!constant) wheelsets = add_bodies(builder, v);
    const std::size_t each = rolls ? 2 : 1;  // wheels of an axle
    const double part = fraction / static_cast<double>(each);
    for (std::size_t i = 0; i < axles.size(); ++i, ++number)
      for (std::size_t side = 0; side < each; ++side)
        wheels_.push_back(
            {.behind = front + axles[i],
             .unknown = wheelsets[i].height,
             .force = constant ? v.loads[i] * part : 0,
             .mean_load = mass_of(v) * gravity * part / static_cast<double>(axles.size()),
             .axle = number,
             .side = side,
             .roll = wheelsets[i].roll,
             .aside = side == 0 ? gauge / 2 : -gauge / 2});
    const std::int32_t behind = layout.pitches ? 2 : 1;  // height, then pitch
    roll_.push_back(rolls && !constant ? first_.back() + behind : -1);
    vehicles_.push_back(v);
    front += v.length;
  }
  const double first = wheels_.empty() ? 0 : wheels_.front().behind;
  for (Wheel& wheel : wheels_) wheel.behind -= first;
  system_ = builder.system();
  weight_ = builder.weight();
}

double Train::largest_static_load() const {
  double largest = 0;
  for (const Wheel& wheel : wheels_)
    largest = std::max(largest, wheel.unknown < 0 ? wheel.force : wheel.mean_load);
  return largest;
}

// The last axle need not be the last wheel of the list: axle forces may be in any order.
double Train::axle_distance() const {
  double last = 0;
  for (const Wheel& wheel : wheels_) last = std::max(last, wheel.behind);
  return last;
}

// Rows and columns of the wheelsets are omitted, which fixes them.
//   K x = w^2 M x,   f = w/(2 pi)
std::vector<double> natural_frequencies(const VehicleParameters& vehicle, bool rolls) {
  const VehicleParameters v = complete(vehicle);
  if (!layout_of(v.kind).body) return {};
  Builder builder(1, rolls);
  std::vector<std::int32_t> held;
  for (const BodyUnknowns& wheelset : add_bodies(builder, v))
    held.insert(held.end(), {wheelset.height, wheelset.roll});
  std::vector<Eigen::Index> kept;
  for (std::int32_t i = 0; i < builder.unknowns(); ++i)
    if (std::find(held.begin(), held.end(), i) == held.end()) kept.push_back(i);
  const LinearSystem system = builder.system();
  const Eigen::MatrixXd k = Eigen::MatrixXd(system.stiffness)(kept, kept);
  const Eigen::MatrixXd m = Eigen::MatrixXd(system.mass)(kept, kept);
  std::vector<double> frequencies;
  for (const double square : generalised_eigenvalues(k, m))
    frequencies.push_back(std::sqrt(std::max(square, 0.0)) / (2 * std::numbers::pi));
  return frequencies;
}

}  // namespace trackbed::track
