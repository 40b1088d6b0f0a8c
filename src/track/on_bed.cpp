// The explicit side of the track is the bed's sleepers, the implicit side rail, vehicles and all
// sleepers on springs. Forces are exchanged at the times of both (docs/decisions/train_on_bed.md):
//   F_n = k (w_n - u_n) + c (w'_n - u'_n)        N, on rail and sleeper alike, at t_n
//   the caller moves the sleepers under F_n to t_n+1, then `advance` the rail with w, w' at t_n+1.
// w, w' stand for height (m) and velocity (m/s) of a sleeper since the rail was laid, u, u' for
// those of the rail above it. Second order in the step, as Newmark and leapfrog are, and stable as
// long as the sleepers' step is (Belytschko, Mullen 1978, doi:10.1002/nme.1620121008). Rejected: to
// let the rail's solve move these sleepers too; they have six degrees of freedom, and the stones'
// answer is late by half a window in any case.
//
// Sleepers that take an implicit step want the force of its end. They are linear: with w*, w'* of
// seats without that force, Y = `mobility` (m/s per N, of a seat) and h the step (s),
//   w' = w'* - Y r F,  w = w* - h/2 Y r F,   F = f [k (w* - u) + c (w'* - u')],
//   f = 1/(1 + r Y (c + k h/2)),   r rails of a seat,
// which is a softer pad on w*, w'*. Rail, pads and sleepers thus take one implicit step together,
// in which no force is late.
//
// Two rails have a seat each on every sleeper; w is then that of the seat, and what a sleeper's
// roll does to it is the caller's. Seats of one sleeper also give way to each other's forces: F, w
// are then pairs, Y and f symmetric 2 x 2 matrices, and what stands off f's diagonal joins the
// pads.
#include "trackbed/track/on_bed.hpp"

#include <Eigen/LU>

#include "trackbed/core/error.hpp"

namespace trackbed::track {

namespace {

double rails_of_seat(const TrainOnBedParameters& p) {
  return p.line.track.dimension == Dimension::space ? p.seat.rails / 2 : p.seat.rails;
}

LineParameters on_moved_sleepers(const TrainOnBedParameters& p) {
  LineParameters line = p.line;
  line.first_moved = static_cast<std::size_t>(p.seat.before);
  line.moved = p.sleepers;
  const PadParameters& pad = p.line.pad;
  const double follows = rails_of_seat(p) * (pad.damping + pad.stiffness * p.step / 2);
  for (const Matrix2& mobility : p.mobility)
    line.moved_pads.emplace_back((Matrix2::Identity() + follows * mobility).inverse());
  return line;
}

}  // namespace

// Members stand in the order they need each other: the passage keeps references to line and train.
struct TrainOnBed::Room {
  Room(const TrainOnBedParameters& p, const std::vector<double>& at)
      : begin(p.first - static_cast<double>(p.seat.before) * p.line.track.spacing),
        levels(at),
        line(on_moved_sleepers(p)),
        rails(rails_of_seat(p)),
        step(p.step),
        mobility(p.mobility),
        train(p.train, p.vehicles, p.line.track.rails, p.line.track.wheel_gauge()),
        passage(line, train, WheelRail(p.wheel_rail),
                Irregularity(p.irregularity, p.line.track.length), p.train,
                {.step = p.step, .duration = 0, .tolerance = p.tolerance}, right_of(p)) {
    require(at.size() == line.seats() && (p.mobility.empty() || p.mobility.size() == p.sleepers),
            "one level for each seat of the bed");
  }

  static std::optional<Irregularity> right_of(const TrainOnBedParameters& p) {
    if (!p.irregularity_right) return {};
    return Irregularity(*p.irregularity_right, p.line.track.length);
  }

  double begin;                // m, x of the bed where the track begins
  std::vector<double> levels;  // m, of the seats when the rail was laid: state
  Line line;
  double rails;  // whose load a seat carries
  double step;   // s
  std::vector<Matrix2> mobility;
  Train train;
  Passage passage;
};

// Bounds: a slice may be as thin as a stone, whole sleepers carry two rails.
void SeatParameters::declare(input::Section& s) {
  s.integer("before", before, {.at_least = 0, .at_most = 10000},
            "Sleepers of the track, on springs ([ballast]), before the first one of the bed; what "
            "track.length leaves is behind the last one.");
  s.number("rails", rails, {.above = 0, .at_most = 2},
           "Rails whose load the sleepers of the model carry: 1 for half a track, 2 for a whole "
           "one, for a slice of a bed the share of a rail that its width carries; 2 on two rails "
           "(track.dimension = \"space\").");
}

TrainOnBed::TrainOnBed(const TrainOnBedParameters& parameters, const std::vector<double>& levels)
    : room_(std::make_unique<Room>(parameters, levels)) {}
TrainOnBed::~TrainOnBed() = default;
TrainOnBed::TrainOnBed(TrainOnBed&&) noexcept = default;

const Train& TrainOnBed::train() const { return room_->train; }
const Line& TrainOnBed::line() const { return room_->line; }
const Passage& TrainOnBed::passage() const { return room_->passage; }
void TrainOnBed::send_again() { room_->passage.send_again(); }

double TrainOnBed::seat_force(std::size_t i) const {
  double sum = 0;
  for (std::size_t side = 0; side < room_->line.sides(); ++side) sum += seat_force(i, side);
  return sum;
}

double TrainOnBed::seat_force(std::size_t i, std::size_t side) const {
  return room_->rails * room_->passage.seat_force(i, side);
}

double TrainOnBed::seat_displacement(std::size_t i, std::size_t side) const {
  const Room& room = *room_;
  double height = room.passage.seat(i, side).height;
  for (std::size_t by = 0; !room.mobility.empty() && by < room.line.sides(); ++by)
    height -= room.step / 2 * seat_force(i, by) *
              room.mobility[i](static_cast<Eigen::Index>(side), static_cast<Eigen::Index>(by));
  return height;
}

void TrainOnBed::advance(const std::vector<double>& levels, const std::vector<double>& rates) {
  Room& room = *room_;
  require(levels.size() == room.levels.size() && rates.size() == levels.size(),
          "level and rate of each seat of the bed");
  std::vector<Seat> seats(levels.size());
  for (std::size_t i = 0; i < seats.size(); ++i)
    seats[i] = {.height = levels[i] - room.levels[i], .rate = rates[i]};
  room.passage.place_seats(seats);
  room.passage.advance();
}

double TrainOnBed::wheel_x(std::size_t i) const { return room_->begin + room_->passage.wheel_x(i); }

double TrainOnBed::rail_displacement(std::size_t i, std::size_t side) const {
  return room_->passage.rail_displacement(room_->line.sleeper_x(room_->line.first_moved() + i),
                                          side);
}

void TrainOnBed::save(io::File& file, const std::string& group, const par::Comm& comm) const {
  room_->passage.save(file, group, comm);
  const std::vector<double>& levels = room_->levels;
  file.write<double>(
      group + "/levels", std::span(levels).first(comm.root() ? levels.size() : 0), 1,
      {"m", "of the sleepers' seats since they were placed, when the rail was laid"});
}

void TrainOnBed::load(const io::File& file, const std::string& group) {
  room_->passage.load(file, group);
  room_->levels = file.read_all<double>(group + "/levels");
  if (room_->levels.size() != room_->line.seats())
    throw RunError(group + "/levels belongs to another number of sleepers");
}

}  // namespace trackbed::track
