// Contacts condensed onto themselves: wheels on the rail, and stops (hanging sleepers, pads with a
// knee or that lift off). Track and train are linear, so what contact forces F do to the approach d
// of each contact by the end of a step is linear too:
//   d = d0 - A F(d),   A_ij = track_i per F_j + wheel_i per F_j   (m/N)
// with d0 from a step without contact forces. Newton's method solves these few equations; A is
// symmetric and positive, F rises with d, so there is one solution. Of a pad that lifts off F falls
// with d, but no faster than its spring and damper in the matrices rise: their sum rises.
// Cost per step: two band solves of the track, one without and one with what contacts add, and A,
// whose share of the wheels takes four unknowns of each rail node (influence.cpp). Stops stand
// still: their columns are solved once, and what wheels do to them is what they do to wheels. Those
// that give no force and are not about to (pads short of their knee or pressed, sleepers that hang
// free) stay out of Newton's equations, whose cost is n^3.
//
// The rail moves as its shape functions say plus the local flexibility of its element (beam.hpp),
// whose inertia is left out; of two wheels in one element each feels its own alone.
// Rejected: iterating between track and train with the force of the last step, which needs tiny
// steps for a stiff contact; contact stiffness in the matrix, factorised anew in each iteration.
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "passage_room.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

namespace {

constexpr int most_iterations = 100;
constexpr int plain_rounds = 10;      // of Newton's method, with whole steps
constexpr double least_share = 1e-3;  // of a step

}  // namespace

// What does not change from step to step: which wheels roll, columns of the train and of the stops.
Passage::Room::Room(const Line& l, const Train& t, const WheelRail& w,
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

// Where the wheels are now, and what constant forces do there; other forces as they are now.
void Passage::Room::place_wheels() {
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

// The same below both rails.
void Passage::Room::load_seats() {
  for (std::size_t i = 0; seat_load && i < line.sleepers(); ++i)
    for (std::size_t side = 0; side < line.sides(); ++side)
      constant_load[line.sleeper_unknown(i, side)] -= seat_load->at(line.sleeper_x(i), time(), i);
}

// Unit forces upwards at so many contacts.
Columns Passage::Room::columns_of(std::size_t first, std::size_t count) const {
  Columns columns = Columns::Zero(line.system().mass.rows(), static_cast<Eigen::Index>(count));
  for (std::size_t k = 0; k < count; ++k) {
    const RailPoint& p = touching[first + k];
    for (std::size_t n = 0; n < 4; ++n)
      if (p.unknown[n] >= 0) columns(p.unknown[n], static_cast<Eigen::Index>(k)) = p.value[n];
  }
  return columns;
}

// m/N, deflections at all contacts from `first` on under forces that displace the track by
// `columns`; a force at a contact, from that number on too, also moves its own point.
Matrix Passage::Room::rail_matrix(std::size_t first, const Columns& columns) const {
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

// Columns and, as it is symmetric, rows of the wheels, where they stand now.
void Passage::Room::renew_flexibility() {
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

// Where a stop's seat is placed from outside, which tells its rate; else it stands still or is
// found together with the stop.
Seat Passage::Room::placed(Eigen::Index stop) const {
  const std::int32_t seat = line.stops()[static_cast<std::size_t>(stop)].seat;
  return seat < 0 || ground ? Seat{} : seats[static_cast<std::size_t>(seat)];
}

// m, of a stop's approach what is the track's own.
double Passage::Room::own_approach(Eigen::Index stop) const {
  return approach[wheels_rolling() + stop] - placed(stop).height;
}

// m/s, the same of its rate at the end of the step, as Newmark's formula has velocities. A seat of
// other steps in time would swing to and fro in this formula for ever.
double Passage::Room::own_rate(Eigen::Index stop) const {
  return rate_slope * (own_approach(stop) - stop_before[stop]) - stop_rate[stop];
}

double Passage::Room::rate(Eigen::Index stop) const { return own_rate(stop) + placed(stop).rate; }

// N, of each contact at its present approach.
Vector Passage::Room::forces() const {
  Vector force(contacts());
  for (Eigen::Index i = 0; i < wheels_rolling(); ++i) force[i] = law.force(approach[i]);
  for (Eigen::Index i = wheels_rolling(), k = 0; i < contacts(); ++i, ++k)
    force[i] = line.stops()[static_cast<std::size_t>(k)].force(approach[i], rate(k));
  return force;
}

// N/m, derivatives of the forces above.
Vector Passage::Room::slopes() const {
  Vector slope(contacts());
  for (Eigen::Index i = 0; i < wheels_rolling(); ++i) slope[i] = law.slope(approach[i]);
  for (Eigen::Index i = wheels_rolling(), k = 0; i < contacts(); ++i, ++k)
    slope[i] = line.stops()[static_cast<std::size_t>(k)].slope(approach[i], rate(k), rate_slope);
  return slope;
}

// m, of the wheel itself, beside the middle of a wheelset that rolls.
double Passage::Room::wheel_height(const Train::Wheel& wheel, const Vector& of_train) const {
  const double middle = of_train[wheel.unknown];
  return wheel.roll < 0 ? middle : middle + wheel.aside * of_train[wheel.roll];
}

// m, the approach of each contact if track and train stood like this.
Vector Passage::Room::approaches(const Vector& of_track, const Vector& of_train) const {
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

// Of (1 + A S) x = approach + A F - without, S the slopes. Columns of contacts without force and
// slope are those of the identity: the others (a) are solved by themselves,
//   (1 + A_aa S_a) x_a = w_a,   then x = w - A_.a S_a x_a of the rest.
Vector Passage::Room::newton_step(const Vector& without) const {
  const Vector force = forces(), slope = slopes();
  std::vector<Eigen::Index> acting;
  for (Eigen::Index i = 0; i < contacts(); ++i)
    if (force[i] != 0 || slope[i] != 0) acting.push_back(i);
  Vector wrong = approach - without;
  if (acting.empty()) return wrong;
  for (const Eigen::Index i : acting) wrong += force[i] * flexibility.col(i);
  const auto n = static_cast<Eigen::Index>(acting.size());
  const Matrix jacobian = Matrix::Identity(n, n) +
                          Matrix(flexibility(acting, acting)) * Vector(slope(acting)).asDiagonal();
  const Vector solved = jacobian.partialPivLu().solve(Vector(wrong(acting)));
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index i = acting[static_cast<std::size_t>(k)];
    wrong -= slope[i] * solved[k] * flexibility.col(i);
  }
  wrong(acting) = solved;
  return wrong;
}

// Newton's method from the approaches of the last step; where they part the slope is zero and the
// equation is linear. Ends when no approach changes by more than the tolerance. Forces are of three
// slopes, the middle one the steepest: Newton's method may go to and fro between the others for
// ever. After some rounds steps are halved until the equations are better met than before.
void Passage::Room::solve_contacts(const Vector& without) {
  const auto wrong = [&] { return (approach + flexibility * forces() - without).norm(); };
  for (int round = 0; round < most_iterations; ++round) {
    const Vector change = newton_step(without), from = approach;
    const double before = round < plain_rounds ? 0 : wrong();
    approach -= change;
    for (double share = 0.5; round >= plain_rounds && wrong() >= before && share > least_share;
         share /= 2)
      approach = from - share * change;
    ++iterations;
    const double largest = change.cwiseAbs().maxCoeff();
    if (!change.allFinite()) break;
    if (largest <= parameters.tolerance) return;
  }
  throw RunError(fmt::format(
      "the contact of wheels and rail is not solved to {:g} m: is the step short enough?",
      parameters.tolerance));
}

// N, on the track's unknowns, of contacts that press it with these forces.
Vector Passage::Room::pushed(const Vector& force) const {
  Vector load = Vector::Zero(line.system().mass.rows());
  for (Eigen::Index i = 0; i < contacts(); ++i)
    if (force[i] != 0) touching[static_cast<std::size_t>(i)].add(-force[i], load);
  return load;
}

// Free motion of track and train, contact forces, and what these add.
void Passage::Room::step() {
  ++steps;
  place_wheels();
  Vector of_track = track.free_change(constant_load);
  if (ground) settle_seats(of_track);
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
  if (ground) press_seats(force, of_track);
  track.accept(of_track + track.flexibility(pushed(force)));
  vehicles.accept(of_train + wheel_change * force.head(wheels));
  for (std::size_t k = 0; k < rolling.size(); ++k)
    if (const double at = x(rolling[k]); at >= 0 && at <= line.length())
      lost += approach[static_cast<Eigen::Index>(k)] <= 0;
}

Passage::Passage(const Line& line, const Train& train, const WheelRail& law,
                 const Irregularity& irregularity, const TrainParameters& motion,
                 const PassageParameters& parameters, const std::optional<Irregularity>& right,
                 const std::optional<SeatLoad>& seats)
    : room_(std::make_unique<Room>(line, train, law,
                                   std::array{irregularity, right ? *right : irregularity}, motion,
                                   parameters, seats)) {
  room_->start();
}

Passage::~Passage() = default;
Passage::Passage(Passage&&) noexcept = default;

void Passage::advance() { room_->step(); }
void Passage::send_again() { room_->rest_train(); }

void Passage::place_seats(const std::vector<Seat>& seats) {
  require(seats.size() == room_->seats.size(), "one seat for each rail on what is moved");
  room_->seats = seats;
}

double Passage::seat_force(std::size_t i, std::size_t side) const {
  const Room& room = *room_;
  std::array<Seat, 2> seats{};
  for (std::size_t s = 0; s < room.line.sides(); ++s) seats[s] = seat(i, s);
  return room.line.seat_force(room.line.first_moved() + i, room.track.displacement,
                              room.track.velocity, seats, side);
}

const Seat& Passage::seat(std::size_t i, std::size_t side) const {
  return room_->seats.at(i * room_->line.sides() + side);
}

double Passage::on_sleeper(std::size_t i, std::size_t side) const {
  const Room& room = *room_;
  if (room.seat_load) return room.seat_load->at(room.line.sleeper_x(i), time(), i);
  return room.line.seat_force(i, room.track.displacement, room.track.velocity, {}, side);
}

Seat Passage::ground_below(std::size_t i, std::size_t side) const {
  const Line& line = room_->line;
  const bool moved = line.moves() == MovedPart::ground && i >= line.first_moved() &&
                     i - line.first_moved() < line.moved();
  return moved ? seat(i - line.first_moved(), side) : Seat{};
}

double Passage::ground_force(std::size_t i, std::size_t side) const {
  const Room& room = *room_;
  const double ballast = room.line.ground_force(i, room.track.displacement, room.track.velocity,
                                                ground_below(i, side), side);
  const std::int32_t stop = room.line.ground_stop(i, side);
  if (stop < 0) return ballast;
  return ballast + room.line.stops()[static_cast<std::size_t>(stop)].force(
                       room.approach[room.wheels_rolling() + stop],
                       room.stop_rate[stop] + room.placed(stop).rate);
}

// Nodes do not show what the rail gives way between them: of a force there force^2 local/2.
double Passage::track_energy() const {
  const Room& room = *room_;
  double energy = room.track.energy();
  const auto give_way = [&](double x, std::size_t side, double force) {
    energy += force * force * room.line.at(x, side).local / 2;
  };
  for (Eigen::Index i = 0; i < room.wheels_rolling(); ++i) {
    const std::size_t wheel = room.rolling[static_cast<std::size_t>(i)];
    give_way(room.x(wheel), room.train.wheels()[wheel].side, room.law.force(room.approach[i]));
  }
  for (std::size_t k = 0; k < room.train.wheels().size(); ++k)
    if (const auto& wheel = room.train.wheels()[k]; wheel.unknown < 0)
      give_way(room.x(k), wheel.side, wheel.force);
  for (const RailForce& one : room.parameters.forces)
    give_way(one.at, one.number(), one.force(room.time()));
  for (std::size_t k = 0; k < room.line.stops().size(); ++k)
    energy += room.line.stops()[k].energy(
        room.approach[room.wheels_rolling() + static_cast<Eigen::Index>(k)]);
  return energy;
}

double Passage::time() const { return room_->time(); }
double Passage::wheel_x(std::size_t i) const { return room_->x(i); }
const Line& Passage::line() const { return room_->line; }
const Newmark& Passage::line_motion() const { return room_->track; }
const Newmark& Passage::train_motion() const { return room_->vehicles; }
std::int64_t Passage::iterations() const { return room_->iterations; }
std::int64_t Passage::steps() const { return room_->steps; }
std::int64_t Passage::lost() const { return room_->lost; }

// Until the last axle is beyond the track, which it may never have been on.
double Passage::duration() const {
  const Room& room = *room_;
  if (room.parameters.duration > 0) return room.parameters.duration;
  if (room.seat_load) return room.seat_load->duration(room.line.length());
  return room.motion.time_at(room.line.length() + room.train.axle_distance());
}

// `rolling` is sorted, so a wheel's contact is found by its number.
double Passage::wheel_force(std::size_t i) const {
  const Room& room = *room_;
  const auto& wheel = room.train.wheels().at(i);
  if (wheel.unknown < 0) return wheel.force;
  const auto at = std::lower_bound(room.rolling.begin(), room.rolling.end(), i);
  return room.law.force(room.approach[at - room.rolling.begin()]);
}

double Passage::wheel_height(std::size_t i) const {
  const Train::Wheel& wheel = room_->train.wheels().at(i);
  return wheel.unknown < 0 ? 0 : room_->wheel_height(wheel, room_->vehicles.displacement);
}

double Passage::rail_force(std::size_t i) const {
  return room_->parameters.forces.at(i).force(room_->time());
}

double Passage::rail_displacement(double x, std::size_t side) const {
  return room_->line.at(x, side).deflection(room_->track.displacement);
}

}  // namespace trackbed::track
