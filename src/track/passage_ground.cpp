// Sleepers on a ground that gives way to the forces of the very step: its height g and the
// ballast's forces p at the end of the step are found together with the contacts. With g_0 the
// ground's under forces p_0, B what it gives way in the step and S what p changes with it,
//   g = g_0 - B (p - p_0),   p = p_g + S (g - g_0) + R F,
// p_g the forces if the ground stood at g_0, F those of the contacts and R what they do to p. So
//   g - g_0 = -G (p_g - p_0 + R F),   G = B (1 + S B)^-1.
// R' is what heights do to the contacts' approaches, as ground and track both take average
// acceleration. So in the equations of the contacts (passage.cpp) the ground is a term R' G R of
// their flexibility, and nothing is iterated between track and ground.
//
// S, R and Z, what the track goes with the ground's heights, follow from solves of the track with a
// seat's unit height. Springs of hanging sleepers, which are stops, press the ground themselves.
#include <Eigen/LU>

#include "passage_room.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

// N, of the ballast on each seat, without stops.
Vector Passage::Room::ballast_forces(const Vector& u, const Vector& v,
                                     const std::vector<Seat>& on) const {
  Vector force(static_cast<Eigen::Index>(on.size()));
  for (std::size_t k = 0; k < on.size(); ++k)
    force[static_cast<Eigen::Index>(k)] =
        line.ground_force(line.first_moved() + k / line.sides(), u, v, on[k], k % line.sides());
  return force;
}

// Rates at the end of a step change by 2/h of what heights do, on the track and on the ground.
void Passage::Room::found_on(const Matrix& give) {
  const auto count = static_cast<Eigen::Index>(seats.size());
  require(
      !ground && line.moves() == MovedPart::ground && give.rows() == count && give.cols() == count,
      "the ground gives way below each seat on it");
  const double rate = 2 / parameters.step;
  Columns loads = Columns::Zero(line.system().mass.rows(), count);
  Matrix slope(count, count);
  const auto raised = [&](Eigen::Index k) {
    std::vector<Seat> all(seats.size());
    all[static_cast<std::size_t>(k)] = {1, rate};
    return all;
  };
  for (Eigen::Index k = 0; k < count; ++k) {
    Vector load = Vector::Zero(loads.rows());
    line.add_seats(raised(k), load);
    loads.col(k) = load;
  }
  ground.emplace();
  ground->forces = Vector::Zero(count);
  // What was read from a checkpoint knew of no ground yet.
  for (Eigen::Index k = 0; k < stop_before.size(); ++k) stop_before[k] = own_approach(k);
  ground->columns = track.flexibility(loads);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Vector way = ground->columns.col(k);
    slope.col(k) = ballast_forces(way, rate * way, raised(k));
  }
  const Matrix whole = Matrix::Identity(count, count) + slope * give;
  ground->give = whole.transpose().partialPivLu().solve(give.transpose()).transpose();
  ground->seen = Matrix::Zero(contacts(), count);
  const auto wheels = static_cast<std::size_t>(wheels_rolling());
  see_ground(wheels, touching.size());
  for (std::size_t k = 0; k < line.stops().size(); ++k)
    if (const std::int32_t seat = line.stops()[k].seat; seat >= 0)
      ground->seen(static_cast<Eigen::Index>(wheels + k), seat) += 1;
  const Matrix stops = ground->seen.bottomRows(stop_rate.size());
  flexibility.bottomRightCorner(stops.rows(), stops.rows()) +=
      stops * ground->give * stops.transpose();
}

// What heights of the seats do to these contacts through the track.
void Passage::Room::see_ground(std::size_t from, std::size_t to) {
  for (std::size_t i = from; i < to; ++i) {
    auto row = ground->seen.row(static_cast<Eigen::Index>(i));
    row.setZero();
    const RailPoint& p = touching[i];
    for (std::size_t k = 0; k < 4; ++k)
      if (p.unknown[k] >= 0) row += p.value[k] * ground->columns.row(p.unknown[k]);
  }
}

// What the ground adds to the contacts' flexibility where the wheels stand now.
void Passage::Room::add_ground_to_flexibility() {
  const Eigen::Index wheels = wheels_rolling(), stops = contacts() - wheels;
  see_ground(0, static_cast<std::size_t>(wheels));
  const Matrix of_wheels = ground->seen.topRows(wheels) * ground->give;
  const Matrix added = of_wheels * ground->seen.transpose();
  flexibility.topRows(wheels) += added;
  flexibility.bottomLeftCorner(stops, wheels) += added.rightCols(stops).transpose();
}

// The seats go by these heights, and the track with them.
void Passage::Room::move_seats(const Vector& way, Vector& of_track) {
  const double rate = 2 / parameters.step;
  for (std::size_t k = 0; k < seats.size(); ++k) {
    seats[k].height += way[static_cast<Eigen::Index>(k)];
    seats[k].rate += rate * way[static_cast<Eigen::Index>(k)];
  }
  of_track += ground->columns * way;
}

// From where the ground stands under the forces that were told to where it does without contacts.
void Passage::Room::settle_seats(Vector& of_track) {
  const Vector rates = 2 / parameters.step * of_track - track.velocity;
  const Vector forces = ballast_forces(track.displacement + of_track, rates, seats);
  move_seats(-(ground->give * (forces - ground->forces)), of_track);
}

// And what the contacts add.
void Passage::Room::press_seats(const Vector& contact_forces, Vector& of_track) {
  move_seats(-(ground->give * (ground->seen.transpose() * contact_forces)), of_track);
}

void Passage::found_on(const Matrix& give) { room_->found_on(give); }

void Passage::place_seats(const std::vector<Seat>& seats, const Vector& forces) {
  place_seats(seats);
  require(room_->ground.has_value() && forces.size() == room_->ground->forces.size(),
          "one force for each seat on a ground that gives way");
  room_->ground->forces = forces;
}

}  // namespace trackbed::track
