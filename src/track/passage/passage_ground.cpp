// Implicit coupling of track and ground: the height g of the ground and the ballast forces p at the
// end of the step are solved for together with the contacts. With g_0 the height under forces p_0,
// B the compliance of the ground in the step and S the derivative of p with respect to g,
//   g = g_0 - B (p - p_0),   p = p_g + S (g - g_0) + R F,
// p_g the forces for a ground at g_0, F the contact forces and R their effect on p. Hence
//   g - g_0 = -G (p_g - p_0 + R F),   G = B (1 + S B)^-1.
// R' gives the contacts' approaches per height, since ground and track both use average
// acceleration. In the equations of the contacts (passage.cpp) the ground is thus a term R' G R of
// their flexibility, and no iteration between track and ground is needed.
//
// S, R and Z, the displacements of the track due to heights of the ground, follow from solves of
// the track with a unit height of each seat. The stops of hanging sleepers act directly on the
// ground.

#include "track/passage/passage_impl.hpp"
#include "trackbed/core/decompositions.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

// N, force of the ballast on each seat, without stops.
Vector Passage::Impl::ballast_forces(const Vector& u, const Vector& v,
                                     const std::vector<Seat>& on) const {
  Vector force(static_cast<Eigen::Index>(on.size()));
  for (std::size_t k = 0; k < on.size(); ++k)
    force[static_cast<Eigen::Index>(k)] =
        line.ground_force(line.first_moved() + k / line.sides(), u, v, on[k], k % line.sides());
  return force;
}

// A height increment changes the rate at the end of a step by 2/h times as much, on track and
// ground.
void Passage::Impl::set_ground_compliance(const Matrix& compliance) {
  const auto count = static_cast<Eigen::Index>(seats.size());
  require(!ground && line.moves() == MovedPart::ground && compliance.rows() == count &&
              compliance.cols() == count,
          "the compliance of the ground has a row and a column for each seat on it");
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
  // A checkpoint was read without the ground.
  for (Eigen::Index k = 0; k < stop_before.size(); ++k) stop_before[k] = own_approach(k);
  ground->columns = track.flexibility(loads);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Vector displacement = ground->columns.col(k);
    slope.col(k) = ballast_forces(displacement, rate * displacement, raised(k));
  }
  const Matrix whole = Matrix::Identity(count, count) + slope * compliance;
  ground->compliance = solutions(whole.transpose(), compliance.transpose()).transpose();
  ground->contact_rows = Matrix::Zero(contacts(), count);
  const auto wheels = static_cast<std::size_t>(wheels_rolling());
  project_ground(wheels, touching.size());
  for (std::size_t k = 0; k < line.stops().size(); ++k)
    if (const std::int32_t seat = line.stops()[k].seat; seat >= 0)
      ground->contact_rows(static_cast<Eigen::Index>(wheels + k), seat) += 1;
  const Matrix stops = ground->contact_rows.bottomRows(stop_rate.size());
  flexibility.bottomRightCorner(stops.rows(), stops.rows()) +=
      stops * ground->compliance * stops.transpose();
}

// Approaches of these contacts per height of the seats, through the track.
void Passage::Impl::project_ground(std::size_t from, std::size_t to) {
  for (std::size_t i = from; i < to; ++i) {
    auto row = ground->contact_rows.row(static_cast<Eigen::Index>(i));
    row.setZero();
    const RailPoint& p = touching[i];
    for (std::size_t k = 0; k < 4; ++k)
      if (p.unknown[k] >= 0) row += p.value[k] * ground->columns.row(p.unknown[k]);
  }
}

// Adds the ground to the contacts' flexibility for the present positions of the wheels.
void Passage::Impl::add_ground_to_flexibility() {
  const Eigen::Index wheels = wheels_rolling(), stops = contacts() - wheels;
  project_ground(0, static_cast<std::size_t>(wheels));
  const Matrix of_wheels = ground->contact_rows.topRows(wheels) * ground->compliance;
  const Matrix added = of_wheels * ground->contact_rows.transpose();
  flexibility.topRows(wheels) += added;
  flexibility.bottomLeftCorner(stops, wheels) += added.rightCols(stops).transpose();
}

// Moves the seats by these height increments, and the track accordingly.
void Passage::Impl::move_seats(const Vector& increment, Vector& of_track) {
  const double rate = 2 / parameters.step;
  for (std::size_t k = 0; k < seats.size(); ++k) {
    seats[k].height += increment[static_cast<Eigen::Index>(k)];
    seats[k].rate += rate * increment[static_cast<Eigen::Index>(k)];
  }
  of_track += ground->columns * increment;
}

// From the prescribed motion of the ground to that under the ballast forces without contacts.
void Passage::Impl::move_seats_without_contacts(Vector& of_track) {
  const Vector rates = 2 / parameters.step * of_track - track.velocity;
  const Vector forces = ballast_forces(track.displacement + of_track, rates, seats);
  move_seats(-(ground->compliance * (forces - ground->forces)), of_track);
}

// The increment due to the contact forces.
void Passage::Impl::move_seats_by_contacts(const Vector& contact_forces, Vector& of_track) {
  move_seats(-(ground->compliance * (ground->contact_rows.transpose() * contact_forces)), of_track);
}

void Passage::set_ground_compliance(const Matrix& compliance) {
  impl_->set_ground_compliance(compliance);
}

void Passage::place_seats(const std::vector<Seat>& seats, const Vector& forces) {
  place_seats(seats);
  require(impl_->ground.has_value() && forces.size() == impl_->ground->forces.size(),
          "one force for each seat on an implicitly coupled ground");
  impl_->ground->forces = forces;
}

}  // namespace trackbed::track
