// Static condensation onto the contacts: wheels on the rail, and stops (hanging sleepers, bilinear
// pads and pads with uplift). Track and train are linear, so that the approach d of each contact at
// the end of a step depends linearly on the contact forces F:
//   d = d0 - A F(d),   A_ij = track_i per F_j + wheel_i per F_j   (m/N)
// with d0 from a step without contact forces. Newton's method solves these few equations; A is
// symmetric and positive definite and F increases with d, so that the solution is unique. For a pad
// with uplift F decreases with d, but not faster than its spring and damper in the matrices
// increase: their sum increases.
// Cost per step: two band solves of the track, one without contacts and one for their forces, and
// A, whose part of the wheels needs four unknowns of each rail node (influence.cpp). Stops do not
// move along the track: their columns are computed once, and A is symmetric. Contacts without force
// and slope (bilinear pads below bilinear_at, compressed pads with uplift, open gaps) are left out
// of Newton's equations, whose cost is n^3.
//
// The deflection of the rail is that of its shape functions plus the local flexibility of its
// element (beam.hpp), without inertia; of two wheels in one element each has only its own local
// deflection.
// Rejected: iterating between track and train with the force of the last step, which needs very
// small steps for a stiff contact; contact stiffness in the matrix, factorised in each iteration.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "track/passage/passage_impl.hpp"
#include "trackbed/core/decompositions.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

namespace {

constexpr int full_steps = 10;           // iterations of Newton's method without line search
constexpr double least_fraction = 1e-3;  // of a step, in the line search

}  // namespace

// Data that are constant over the steps: rolling wheels, columns of the train and of the stops.
Passage::Impl::Impl(const Line& l, const Train& t, const WheelRail& w,
                    const std::array<Irregularity, 2>& i, const TrainParameters& m,
                    const PassageParameters& p, const std::optional<SeatLoad>& s)
    : line(l),
      train(t),
      law(w),
      irregularity(i),
      motion(m),
      parameters(p),
      seat_load(s),
      track(l.system(), p.step),
      vehicles(t.system(), p.step),
      influence(effective_stiffness(l.system(), p.step), l.rail_nodes()) {
  for (std::size_t k = 0; k < train.wheels().size(); ++k)
    if (train.wheels()[k].unknown >= 0) rolling.push_back(k);
  seats.resize(line.seats());
  const auto stops = static_cast<Eigen::Index>(line.stops().size());
  const Eigen::Index n = wheels_rolling() + stops;
  approach = Vector::Zero(n);
  stop_before = stop_rate = Vector::Zero(stops);
  wheel_columns = Columns::Zero(train.weight().size(), wheels_rolling());
  for (std::size_t k = 0; k < rolling.size(); ++k) {
    const Train::Wheel& wheel = train.wheels()[rolling[k]];
    wheel_columns(wheel.unknown, static_cast<Eigen::Index>(k)) = 1;
    if (wheel.roll >= 0) wheel_columns(wheel.roll, static_cast<Eigen::Index>(k)) = wheel.aside;
  }
  wheel_change = vehicles.flexibility(wheel_columns);
  touching.resize(rolling.size());
  for (const Stop& stop : line.stops()) touching.push_back(stop.point);
  flexibility = Matrix::Zero(n, n);
  if (stops == 0) return;
  stop_change = track.flexibility(columns_of(rolling.size(), line.stops().size()));
  flexibility.bottomRightCorner(stops, stops) = rail_matrix(rolling.size(), stop_change);
}

// Present positions of the wheels, and all prescribed forces at the present time.
void Passage::Impl::place_wheels() {
  point.clear();
  constant_load = Vector::Zero(line.system().mass.rows());
  for (std::size_t k = 0; k < train.wheels().size(); ++k) {
    point.push_back(line.at(x(k), train.wheels()[k].side));
    if (train.wheels()[k].unknown < 0) point.back().add(-train.wheels()[k].force, constant_load);
  }
  line.add_seats(seats, constant_load);
  for (const RailForce& one : parameters.forces)
    line.at(one.at, one.number()).add(-one.force(time()), constant_load);
  load_seats();
  for (std::size_t k = 0; k < rolling.size(); ++k) touching[k] = point[rolling[k]];
}

// The same load below both rails.
void Passage::Impl::load_seats() {
  for (std::size_t i = 0; seat_load && i < line.sleepers(); ++i)
    for (std::size_t side = 0; side < line.sides(); ++side)
      constant_load[line.sleeper_unknown(i, side)] -= seat_load->at(line.sleeper_x(i), time(), i);
}

// Unit forces upwards at `count` contacts.
Columns Passage::Impl::columns_of(std::size_t first, std::size_t count) const {
  Columns columns = Columns::Zero(line.system().mass.rows(), static_cast<Eigen::Index>(count));
  for (std::size_t k = 0; k < count; ++k) {
    const RailPoint& p = touching[first + k];
    for (std::size_t n = 0; n < 4; ++n)
      if (p.unknown[n] >= 0) columns(p.unknown[n], static_cast<Eigen::Index>(k)) = p.value[n];
  }
  return columns;
}

// m/N, deflections at all contacts from `first` on due to unit forces at contacts from `first` on,
// which displace the track by `columns`; the diagonal includes the local flexibility.
Matrix Passage::Impl::rail_matrix(std::size_t first, const Columns& columns) const {
  const Eigen::Index count = contacts() - static_cast<Eigen::Index>(first);
  Matrix matrix = Matrix::Zero(count, columns.cols());
  for (Eigen::Index i = 0; i < count; ++i) {
    const RailPoint& p = touching[first + static_cast<std::size_t>(i)];
    for (std::size_t k = 0; k < 4; ++k)
      if (p.unknown[k] >= 0) matrix.row(i) += p.value[k] * columns.row(p.unknown[k]);
    if (i < columns.cols()) matrix(i, i) += p.local;
  }
  return matrix;
}

// Columns and, by symmetry, rows of the wheels at their present positions.
void Passage::Impl::renew_flexibility() {
  const Eigen::Index wheels = wheels_rolling(), stops = contacts() - wheels;
  const std::vector<RailPoint> below(touching.begin(), touching.begin() + wheels);
  flexibility.topLeftCorner(wheels, wheels) =
      influence.between(below) + wheel_columns.transpose() * wheel_change;
  for (Eigen::Index i = 0; i < wheels; ++i) {
    const RailPoint& p = below[static_cast<std::size_t>(i)];
    flexibility(i, i) += p.local;
    auto of_stops = flexibility.col(i).tail(stops);
    of_stops.setZero();
    for (std::size_t k = 0; stops > 0 && k < 4; ++k)
      if (p.unknown[k] >= 0) of_stops += p.value[k] * stop_change.row(p.unknown[k]).transpose();
  }
  flexibility.topRightCorner(wheels, stops) =
      flexibility.bottomLeftCorner(stops, wheels).transpose();
  if (ground) add_ground_to_flexibility();
}

// Prescribed motion of a stop's seat; zero if the seat is fixed or solved for with the contacts.
Seat Passage::Impl::prescribed(Eigen::Index stop) const {
  const std::int32_t seat = line.stops()[static_cast<std::size_t>(stop)].seat;
  return seat < 0 || ground ? Seat{} : seats[static_cast<std::size_t>(seat)];
}

// m, approach of a stop without the prescribed height of its seat.
double Passage::Impl::own_approach(Eigen::Index stop) const {
  return approach[wheels_rolling() + stop] - prescribed(stop).height;
}

// m/s, its rate at the end of the step by Newmark's formula. It must not include a seat with
// another time integration, for which this formula would give an undamped oscillation.
double Passage::Impl::own_rate(Eigen::Index stop) const {
  return rate_slope * (own_approach(stop) - stop_before[stop]) - stop_rate[stop];
}

double Passage::Impl::rate(Eigen::Index stop) const {
  return own_rate(stop) + prescribed(stop).rate;
}

// N, force of each contact at its present approach.
Vector Passage::Impl::forces() const {
  Vector force(contacts());
  for (Eigen::Index i = 0; i < wheels_rolling(); ++i) force[i] = law.force(approach[i]);
  for (Eigen::Index i = wheels_rolling(), k = 0; i < contacts(); ++i, ++k)
    force[i] = line.stops()[static_cast<std::size_t>(k)].force(approach[i], rate(k));
  return force;
}

// N/m, derivatives of the forces above.
Vector Passage::Impl::slopes() const {
  Vector slope(contacts());
  for (Eigen::Index i = 0; i < wheels_rolling(); ++i) slope[i] = law.slope(approach[i]);
  for (Eigen::Index i = wheels_rolling(), k = 0; i < contacts(); ++i, ++k)
    slope[i] = line.stops()[static_cast<std::size_t>(k)].slope(approach[i], rate(k), rate_slope);
  return slope;
}

// m, height of the wheel, including the roll of its wheelset.
double Passage::Impl::wheel_height(const Train::Wheel& wheel, const Vector& of_train) const {
  const double middle = of_train[wheel.unknown];
  return wheel.roll < 0 ? middle : middle + wheel.aside * of_train[wheel.roll];
}

// m, approach of each contact for these displacements of track and train.
Vector Passage::Impl::approaches(const Vector& of_track, const Vector& of_train) const {
  Vector result(contacts());
  for (Eigen::Index i = 0; i < contacts(); ++i)
    result[i] = touching[static_cast<std::size_t>(i)].deflection(of_track);
  for (Eigen::Index i = 0; i < wheels_rolling(); ++i) {
    const std::size_t number = rolling[static_cast<std::size_t>(i)];
    const Train::Wheel& wheel = train.wheels()[number];
    result[i] += irregularity[wheel.side].at(x(number)) - law.flat(wheel.axle, x(number)) -
                 wheel_height(wheel, of_train);
  }
  for (Eigen::Index i = wheels_rolling(), k = 0; i < contacts(); ++i, ++k) {
    const Stop& stop = line.stops()[static_cast<std::size_t>(k)];
    result[i] -= stop.gap;
    if (stop.seat >= 0) result[i] += seats[static_cast<std::size_t>(stop.seat)].height;
  }
  return result;
}

// Solution of (1 + A S) x = w with the residual w = d + A F - d0 and the slopes S. Columns of
// contacts without force and slope are those of the identity: the others (a) are solved separately,
//   (1 + A_aa S_a) x_a = w_a,   then x = w - A_.a S_a x_a for the rest.
Vector Passage::Impl::newton_step(const Vector& without) const {
  const Vector force = forces(), slope = slopes();
  std::vector<Eigen::Index> acting;
  for (Eigen::Index i = 0; i < contacts(); ++i)
    if (force[i] != 0 || slope[i] != 0) acting.push_back(i);
  Vector residual = approach - without;
  if (acting.empty()) return residual;
  for (const Eigen::Index i : acting) residual += force[i] * flexibility.col(i);
  const auto n = static_cast<Eigen::Index>(acting.size());
  const Matrix jacobian = Matrix::Identity(n, n) +
                          Matrix(flexibility(acting, acting)) * Vector(slope(acting)).asDiagonal();
  const Vector solved = solution(jacobian, residual(acting));
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index i = acting[static_cast<std::size_t>(k)];
    residual -= slope[i] * solved[k] * flexibility.col(i);
  }
  residual(acting) = solved;
  return residual;
}

// Newton's method from the approaches of the last step; without contact the slope is zero and the
// equation is linear. Converged if no approach changes by more than the tolerance. The force of a
// stop is piecewise linear with three slopes, the middle one the largest: Newton's method may
// alternate between the others without end. After some iterations steps are therefore halved until
// the residual decreases.
void Passage::Impl::solve_contacts(const Vector& without) {
  const auto residual = [&] { return (approach + flexibility * forces() - without).norm(); };
  double largest = 0;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const Vector change = newton_step(without), from = approach;
    const double before = iteration < full_steps ? 0 : residual();
    approach -= change;
    for (double fraction = 0.5;
         iteration >= full_steps && residual() >= before && fraction > least_fraction;
         fraction /= 2)
      approach = from - fraction * change;
    ++iterations;
    largest = change.cwiseAbs().maxCoeff();
    if (!change.allFinite()) break;
    if (largest <= parameters.tolerance) return;
  }
  throw RunError(
      fmt::format("the wheel-rail contacts did not converge to passage.tolerance = {:g} m within "
                  "{} iterations of Newton's method; the last iteration changed the compression "
                  "of a contact by {:.2g} m; reduce the time step (passage.step), or increase "
                  "passage.tolerance",
                  parameters.tolerance, most_iterations, largest));
}

// N, on the track's unknowns, due to these contact forces.
Vector Passage::Impl::contact_load(const Vector& force) const {
  Vector load = Vector::Zero(line.system().mass.rows());
  for (Eigen::Index i = 0; i < contacts(); ++i)
    if (force[i] != 0) touching[static_cast<std::size_t>(i)].add(-force[i], load);
  return load;
}

// Increments of track and train without contact forces, then the contact forces and their effect.
void Passage::Impl::step() {
  ++steps;
  place_wheels();
  Vector of_track = track.free_change(constant_load);
  if (ground) move_seats_without_contacts(of_track);
  if (contacts() == 0) return track.accept(of_track);
  const Eigen::Index wheels = wheels_rolling();
  const Vector of_train = vehicles.free_change(train.weight());
  renew_flexibility();
  solve_contacts(approaches(track.displacement + of_track, vehicles.displacement + of_train));
  const Vector force = forces();
  for (Eigen::Index k = 0; k < stop_rate.size(); ++k) {
    stop_rate[k] = own_rate(k);
    stop_before[k] = own_approach(k);
  }
  if (ground) move_seats_by_contacts(force, of_track);
  track.accept(of_track + track.flexibility(contact_load(force)));
  vehicles.accept(of_train + wheel_change * force.head(wheels));
  for (std::size_t k = 0; k < rolling.size(); ++k)
    if (const double at = x(rolling[k]); at >= 0 && at <= line.length())
      lost += approach[static_cast<Eigen::Index>(k)] <= 0;
}

Passage::Passage(const Line& line, const Train& train, const WheelRail& law,
                 const Irregularity& irregularity, const TrainParameters& motion,
                 const PassageParameters& parameters, const std::optional<Irregularity>& right,
                 const std::optional<SeatLoad>& seats)
    : impl_(std::make_unique<Impl>(line, train, law,
                                   std::array{irregularity, right ? *right : irregularity}, motion,
                                   parameters, seats)) {
  impl_->start();
}

Passage::~Passage() = default;
Passage::Passage(Passage&&) noexcept = default;

void Passage::advance() { impl_->step(); }
void Passage::restart_train() { impl_->reset_train(); }

void Passage::place_seats(const std::vector<Seat>& seats) {
  require(seats.size() == impl_->seats.size(), "one seat for each rail on moved parts");
  impl_->seats = seats;
}

double Passage::seat_force(std::size_t i, std::size_t side) const {
  const Impl& impl = *impl_;
  std::array<Seat, 2> seats{};
  for (std::size_t s = 0; s < impl.line.sides(); ++s) seats[s] = seat(i, s);
  return impl.line.seat_force(impl.line.first_moved() + i, impl.track.displacement,
                              impl.track.velocity, seats, side);
}

const Seat& Passage::seat(std::size_t i, std::size_t side) const {
  return impl_->seats.at(i * impl_->line.sides() + side);
}

double Passage::on_sleeper(std::size_t i, std::size_t side) const {
  const Impl& impl = *impl_;
  if (impl.seat_load) return impl.seat_load->at(impl.line.sleeper_x(i), time(), i);
  return impl.line.seat_force(i, impl.track.displacement, impl.track.velocity, {}, side);
}

Seat Passage::ground_below(std::size_t i, std::size_t side) const {
  const Line& line = impl_->line;
  const bool moved = line.moves() == MovedPart::ground && i >= line.first_moved() &&
                     i - line.first_moved() < line.moved();
  return moved ? seat(i - line.first_moved(), side) : Seat{};
}

double Passage::ground_force(std::size_t i, std::size_t side) const {
  const Impl& impl = *impl_;
  const double ballast = impl.line.ground_force(i, impl.track.displacement, impl.track.velocity,
                                                ground_below(i, side), side);
  const std::int32_t stop = impl.line.ground_stop(i, side);
  if (stop < 0) return ballast;
  return ballast + impl.line.stops()[static_cast<std::size_t>(stop)].force(
                       impl.approach[impl.wheels_rolling() + stop],
                       impl.stop_rate[stop] + impl.prescribed(stop).rate);
}

// A force between nodes also stores force^2 local/2, which the nodal displacements do not contain.
double Passage::track_energy() const {
  const Impl& impl = *impl_;
  double energy = impl.track.energy();
  const auto add_local = [&](double x, std::size_t side, double force) {
    energy += force * force * impl.line.at(x, side).local / 2;
  };
  for (Eigen::Index i = 0; i < impl.wheels_rolling(); ++i) {
    const std::size_t wheel = impl.rolling[static_cast<std::size_t>(i)];
    add_local(impl.x(wheel), impl.train.wheels()[wheel].side, impl.law.force(impl.approach[i]));
  }
  for (std::size_t k = 0; k < impl.train.wheels().size(); ++k)
    if (const auto& wheel = impl.train.wheels()[k]; wheel.unknown < 0)
      add_local(impl.x(k), wheel.side, wheel.force);
  for (const RailForce& one : impl.parameters.forces)
    add_local(one.at, one.number(), one.force(impl.time()));
  for (std::size_t k = 0; k < impl.line.stops().size(); ++k)
    energy += impl.line.stops()[k].energy(
        impl.approach[impl.wheels_rolling() + static_cast<Eigen::Index>(k)]);
  return energy;
}

double Passage::time() const { return impl_->time(); }
double Passage::wheel_x(std::size_t i) const { return impl_->x(i); }
const Line& Passage::line() const { return impl_->line; }
const Newmark& Passage::line_motion() const { return impl_->track; }
const Newmark& Passage::train_motion() const { return impl_->vehicles; }
std::int64_t Passage::iterations() const { return impl_->iterations; }
std::int64_t Passage::steps() const { return impl_->steps; }
std::int64_t Passage::lost() const { return impl_->lost; }

// Until the last axle is beyond the end of the track, also if the train starts there.
double Passage::duration() const {
  const Impl& impl = *impl_;
  if (impl.parameters.duration > 0) return impl.parameters.duration;
  if (impl.seat_load) return impl.seat_load->duration(impl.line.length());
  return impl.motion.time_at(impl.line.length() + impl.train.axle_distance());
}

// `rolling` is sorted, so that a wheel's contact follows from its number.
double Passage::wheel_force(std::size_t i) const {
  const Impl& impl = *impl_;
  const auto& wheel = impl.train.wheels().at(i);
  if (wheel.unknown < 0) return wheel.force;
  const auto at = std::lower_bound(impl.rolling.begin(), impl.rolling.end(), i);
  return impl.law.force(impl.approach[at - impl.rolling.begin()]);
}

double Passage::wheel_height(std::size_t i) const {
  const Train::Wheel& wheel = impl_->train.wheels().at(i);
  return wheel.unknown < 0 ? 0 : impl_->wheel_height(wheel, impl_->vehicles.displacement);
}

double Passage::rail_force(std::size_t i) const {
  return impl_->parameters.forces.at(i).force(impl_->time());
}

double Passage::rail_displacement(double x, std::size_t side) const {
  return impl_->line.at(x, side).deflection(impl_->track.displacement);
}

}  // namespace trackbed::track
