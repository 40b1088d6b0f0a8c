// Wheel-rail contact condensed onto the wheels. Track and train are linear, so what contact forces
// F do to the approach d of each wheel by the end of a step is linear too:
//   d = d0 - A F(d),   A_ij = rail_i per F_j + wheel_i per F_j   (m/N)
// with d0 from a step without contact forces. Newton's method solves these few equations; A is
// symmetric and positive, F rises with d, so there is one solution and it is found from anywhere.
// Cost per step: one band solve of the track with a right side for each wheel on it, which is
// nearly all of it; linear in length of track and number of wheels.
//
// The rail moves as its shape functions say plus the local flexibility of its element (beam.hpp),
// whose inertia is left out; of two wheels in one element each feels its own alone.
// Rejected: iterating between track and train with the force of the last step, which needs tiny
// steps for a stiff contact; contact stiffness in the matrix, factorised anew in each iteration.
#include "trackbed/track/passage.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "trackbed/core/error.hpp"

namespace trackbed::track {

namespace {

using Matrix = Eigen::MatrixXd;
constexpr int most_iterations = 100;

}  // namespace

struct Passage::Room {
  Room(const Line& line, const Train& train, const WheelRail& law, const Irregularity& irregularity,
       const TrainParameters& motion, const PassageParameters& parameters);

  double x(std::size_t wheel) const {
    return motion.start + motion.speed * time() - train.wheels()[wheel].behind;
  }
  double time() const { return static_cast<double>(steps) * parameters.step; }
  void place_wheels();
  Columns rail_columns() const;
  Matrix rail_matrix(const Columns& columns) const;
  void start();
  void step();
  void solve_contacts(const Vector& without, const Matrix& flexibility);
  Vector forces() const;
  Vector slopes() const;

  const Line& line;
  const Train& train;
  WheelRail law;
  Irregularity irregularity;
  TrainParameters motion;
  PassageParameters parameters;
  Newmark track, vehicles;
  std::vector<std::size_t> rolling;  // wheels of vehicles; the others are constant forces
  Columns wheel_columns;             // forces on the train's unknowns by unit forces on `rolling`
  Columns wheel_change;              // their changes of displacement in a step
  std::vector<RailPoint> point;      // below each wheel, at the end of the step
  Vector approach;                   // m, of `rolling`
  Vector constant_load;              // N on the track's unknowns
  std::int64_t steps = 0, iterations = 0, lost = 0;
};

Passage::Room::Room(const Line& l, const Train& t, const WheelRail& w, const Irregularity& i,
                    const TrainParameters& m, const PassageParameters& p)
    : line(l),
      train(t),
      law(w),
      irregularity(i),
      motion(m),
      parameters(p),
      track(l.system(), p.step),
      vehicles(t.system(), p.step) {
  for (std::size_t k = 0; k < train.wheels().size(); ++k)
    if (train.wheels()[k].unknown >= 0) rolling.push_back(k);
  wheel_columns = Columns::Zero(train.weight().size(), static_cast<Eigen::Index>(rolling.size()));
  for (std::size_t k = 0; k < rolling.size(); ++k)
    wheel_columns(train.wheels()[rolling[k]].unknown, static_cast<Eigen::Index>(k)) = 1;
  wheel_change = vehicles.flexibility(wheel_columns);
  approach = Vector::Zero(static_cast<Eigen::Index>(rolling.size()));
}

// Where the wheels are now, and what constant forces do there.
void Passage::Room::place_wheels() {
  point.clear();
  constant_load = Vector::Zero(line.system().mass.rows());
  for (std::size_t k = 0; k < train.wheels().size(); ++k) {
    point.push_back(line.at(x(k)));
    if (train.wheels()[k].unknown < 0) point.back().add(-train.wheels()[k].force, constant_load);
  }
}

// Unit forces upwards at the rolling wheels.
Columns Passage::Room::rail_columns() const {
  Columns columns =
      Columns::Zero(line.system().mass.rows(), static_cast<Eigen::Index>(rolling.size()));
  for (std::size_t k = 0; k < rolling.size(); ++k) {
    const RailPoint& p = point[rolling[k]];
    for (std::size_t n = 0; n < 4; ++n)
      if (p.unknown[n] >= 0) columns(p.unknown[n], static_cast<Eigen::Index>(k)) = p.value[n];
  }
  return columns;
}

// m/N, deflection below wheel i per force at wheel j, from the displacements `columns` of the
// track.
Matrix Passage::Room::rail_matrix(const Columns& columns) const {
  const auto n = static_cast<Eigen::Index>(rolling.size());
  Matrix matrix = Matrix::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const RailPoint& p = point[rolling[static_cast<std::size_t>(i)]];
    for (std::size_t k = 0; k < 4; ++k)
      if (p.unknown[k] >= 0) matrix.row(i) += p.value[k] * columns.row(p.unknown[k]);
    matrix(i, i) += p.local;
  }
  return matrix;
}

Vector Passage::Room::forces() const {
  return approach.unaryExpr([this](double d) { return law.force(d); });
}

Vector Passage::Room::slopes() const {
  return approach.unaryExpr([this](double d) { return law.slope(d); });
}

// Equilibrium of train and track with the wheels where they are, Newton's method on the train's
// unknowns u (m) and the approaches d (m):
//   K u - E F(d) = weight,   E' u + d + G F(d) = rail under constant forces + irregularity
// E puts wheel forces on unknowns, G is the track's static flexibility, m/N. The train alone is not
// held, but together with the contacts it is.
void Passage::Room::start() {
  place_wheels();
  const Statics statics(line.system());
  const Columns columns = statics.flexibility(rail_columns());
  const Vector under_constant = statics.flexibility(constant_load);
  track.displacement = under_constant;
  const auto n = static_cast<Eigen::Index>(rolling.size());
  const Eigen::Index m = train.weight().size();
  if (n == 0) return;
  const Matrix g = rail_matrix(columns), e = wheel_columns, k = train.system().stiffness;
  Vector rail(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::size_t wheel = rolling[static_cast<std::size_t>(i)];
    rail[i] = point[wheel].deflection(under_constant) + irregularity.at(x(wheel));
    approach[i] = law.approach(train.wheels()[wheel].share);
  }
  Vector u = Vector::Zero(m);
  for (int round = 0; round < most_iterations; ++round) {
    Matrix jacobian(m + n, m + n);
    const Matrix slope = slopes().asDiagonal();
    jacobian << k, -e * slope, e.transpose(), Matrix::Identity(n, n) + g * slope;
    Vector wrong(m + n);
    wrong << k * u - e * forces() - train.weight(),
        e.transpose() * u + approach + g * forces() - rail;
    const Vector change = jacobian.partialPivLu().solve(wrong);
    u -= change.head(m);
    // Never out of contact on the way: the train would be held by nothing.
    approach = (approach - change.tail(n)).cwiseMax(approach / 10);
    if (!(change.tail(n).cwiseAbs().maxCoeff() > parameters.tolerance)) {
      if (!u.allFinite()) break;
      vehicles.displacement = u;
      track.displacement -= columns * forces();
      return;
    }
  }
  throw RunError("the train finds no static equilibrium on the track: is every wheel loaded?");
}

// Newton's method from the approaches of the last step; where they part the slope is zero and the
// equation is linear. Ends when no approach changes by more than the tolerance.
void Passage::Room::solve_contacts(const Vector& without, const Matrix& flexibility) {
  const auto n = static_cast<Eigen::Index>(rolling.size());
  for (int round = 0; round < most_iterations; ++round) {
    const Vector wrong = approach + flexibility * forces() - without;
    const Matrix jacobian = Matrix::Identity(n, n) + flexibility * Matrix(slopes().asDiagonal());
    const Vector change = jacobian.partialPivLu().solve(wrong);
    approach -= change;
    ++iterations;
    const double largest = change.cwiseAbs().maxCoeff();
    if (!std::isfinite(largest)) break;
    if (largest <= parameters.tolerance) return;
  }
  throw RunError(
      fmt::format("the contact of wheels and rail is not solved to {:g} m at {:.6g} s: "
                  "is the step short enough?",
                  parameters.tolerance, time()));
}

// Free motion of track and train, contact forces, and what these add.
void Passage::Room::step() {
  ++steps;
  place_wheels();
  Vector track_change = track.free_change(constant_load);
  const auto n = static_cast<Eigen::Index>(rolling.size());
  if (n == 0) return track.accept(track_change);
  Vector train_change = vehicles.free_change(train.weight());
  const Columns rail_change = track.flexibility(rail_columns());
  const Vector track_free = track.displacement + track_change;
  const Vector train_free = vehicles.displacement + train_change;
  Vector without(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::size_t wheel = rolling[static_cast<std::size_t>(i)];
    without[i] = point[wheel].deflection(track_free) + irregularity.at(x(wheel)) -
                 train_free[train.wheels()[wheel].unknown];
  }
  solve_contacts(without, rail_matrix(rail_change) + wheel_columns.transpose() * wheel_change);
  const Vector force = forces();
  track.accept(track_change - rail_change * force);
  vehicles.accept(train_change + wheel_change * force);
  lost += (approach.array() <= 0).count();
}

Passage::Passage(const Line& line, const Train& train, const WheelRail& law,
                 const Irregularity& irregularity, const TrainParameters& motion,
                 const PassageParameters& parameters)
    : room_(std::make_unique<Room>(line, train, law, irregularity, motion, parameters)) {
  room_->start();
}

Passage::~Passage() = default;
Passage::Passage(Passage&&) noexcept = default;

void Passage::advance() { room_->step(); }
double Passage::time() const { return room_->time(); }
double Passage::wheel_x(std::size_t i) const { return room_->x(i); }
const Newmark& Passage::line_motion() const { return room_->track; }
const Newmark& Passage::train_motion() const { return room_->vehicles; }
std::int64_t Passage::iterations() const { return room_->iterations; }
std::int64_t Passage::steps() const { return room_->steps; }
std::int64_t Passage::lost() const { return room_->lost; }

double Passage::duration() const {
  const Room& room = *room_;
  if (room.parameters.duration > 0) return room.parameters.duration;
  const double way = room.line.length() + room.train.axle_distance() - room.motion.start;
  return std::max(way, 0.0) / room.motion.speed;
}

double Passage::wheel_force(std::size_t i) const {
  const Room& room = *room_;
  const auto& wheel = room.train.wheels().at(i);
  if (wheel.unknown < 0) return wheel.force;
  const auto at = std::lower_bound(room.rolling.begin(), room.rolling.end(), i);
  return room.law.force(room.approach[at - room.rolling.begin()]);
}

double Passage::wheel_height(std::size_t i) const {
  const std::int32_t unknown = room_->train.wheels().at(i).unknown;
  return unknown < 0 ? 0 : room_->vehicles.displacement[unknown];
}

double Passage::rail_displacement(double x) const {
  return room_->line.at(x).deflection(room_->track.displacement);
}

}  // namespace trackbed::track
