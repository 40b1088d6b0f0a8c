// Connects the run, which uses sleepers and seat loads, to the bodies of the module fem.
#include "model/coupling/solid_sleepers.hpp"

#include "trackbed/core/error.hpp"
#include "trackbed/model/parameters.hpp"

namespace trackbed::model {

SolidSleepers::SolidSleepers(const Model& model) : model_(model), bodies_(solid_bodies(model)) {
  below_.resize(count() * pads());
  for (std::size_t i = 0; i < count(); ++i)
    for (std::size_t s = 0; s < seats(); ++s) {
      const fem::Patch patch = seat_patch(model, i, s);
      seat_.push_back(bodies_.over(i, fem::Side::upper, patch));
      const bool right = pads() == 2 && model.solid.seats[s] < 0;
      for (const fem::NodeWeight& one : seat_.back())
        below_[i * pads() + (right ? 1 : 0)].push_back(
            {one.node, one.weight * static_cast<double>(pads()) / static_cast<double>(seats())});
      if (model.solid.rails) rail_.push_back(bodies_.over(count() + s, fem::Side::upper, patch));
    }
  loaded_ = model.solid.rails ? rail_ : seat_;
  const std::vector<fem::Body> built = solid_bodies(model).bodies;
  rails_.assign(built.begin() + static_cast<std::ptrdiff_t>(count()), built.end());
  reaction_.assign(count(), Vec3::Zero());
  given_.assign(count(), 0);
  for (Surface& surface : bodies_.surfaces())
    surface.material = model.material(model.sleepers.material);
}

std::size_t SolidSleepers::count() const { return static_cast<std::size_t>(model_.sleepers.count); }

std::size_t SolidSleepers::seats() const { return model_.solid.seats.size(); }

std::size_t SolidSleepers::pads() const {
  return model_.track.line.track.dimension == Dimension::space ? 2 : 1;
}

double SolidSleepers::x(std::size_t i) const { return bodies_.centre(i).x(); }

void SolidSleepers::place(double z) {
  bodies_.place({0, 0, z});
  reaction_.assign(count(), Vec3::Zero());
  given_.assign(count(), 0);
  axles_.clear();
  placed_ = true;
}

// Uses the undeformed box at the centre of mass: called when sleepers have just been placed.
bool SolidSleepers::overlaps(const Vec3& centre, double radius) const {
  const track::SleeperParameters& s = model_.sleepers;
  const Vec3 half(s.width / 2, s.length / 2, s.height / 2);
  for (std::size_t i = 0; i < count(); ++i) {
    const Vec3 local =
        centre - bodies_.origin() - bodies_.centre(i) - bodies_.motion(i).displacement;
    if ((local - local.cwiseMax(-half).cwiseMin(half)).norm() < radius) return true;
  }
  return false;
}

// A wheel's force is distributed with 25, 50 and 25 % to points one element apart (as in "A DEM-FEM
// coupling framework applied to railroad infrastructure simulations" to three nodes), and linearly
// between nodes: it does not jump as the wheel rolls. At the ends of the rail only the points on
// the rail count; the others belong to the mirror image.
void SolidSleepers::add_wheels(std::vector<fem::Bodies::PatchLoad>& pushes) const {
  for (std::size_t r = 0; r < rails_.size(); ++r) {
    const fem::Body& rail = rails_[r];
    const double element = (rail.high.x() - rail.low.x()) / static_cast<double>(rail.elements[0]);
    const double y = (rail.low.y() + rail.high.y()) / 2;
    for (const track::AxleLoad& axle : axles_)
      for (const int k : {-1, 0, 1}) {
        const double at = axle.x + k * element;
        if (at < rail.low.x() || at > rail.high.x()) continue;
        const double fraction = k == 0 ? 0.5 : 0.25;
        pushes.push_back({bodies_.over(count() + r, fem::Side::upper, {.x = {at, at}, .y = {y, y}}),
                          {0, 0, -fraction * axle.force / static_cast<double>(seats())}});
      }
  }
}

void SolidSleepers::advance(double dt, std::span<const double> seat_force,
                            const std::vector<std::span<const Vec3>>& node_force, double gravity) {
  require(seat_force.size() == count(), "one seat force per sleeper");
  given_.assign(seat_force.begin(), seat_force.end());
  std::vector<fem::Bodies::PatchLoad> pushes;
  for (std::size_t k = 0; k < loaded_.size(); ++k)
    pushes.push_back({loaded_[k], {0, 0, -seat_force[k / seats()] / static_cast<double>(seats())}});
  add_wheels(pushes);
  for (std::size_t i = 0; i < count(); ++i) {
    reaction_[i].setZero();
    if (!node_force.empty())
      for (const Vec3& force : node_force[i]) reaction_[i] += force;
  }
  bodies_.advance(dt, gravity, pushes, node_force);
}

void SolidSleepers::carry(double, double, const std::vector<std::span<const Vec3>>&) {
  require(false, "solid sleepers cannot have a given motion");
}

track::SleeperState SolidSleepers::state(std::size_t i) const {
  const fem::BodyMotion now = bodies_.motion(i);
  return {now.displacement, now.velocity, now.acceleration, now.rotation, now.spin};
}

std::vector<double> SolidSleepers::seat_forces() const {
  if (!model_.solid.rails) return given_;
  std::vector<double> forces(count(), 0);
  for (std::size_t k = 0; k < seat_.size(); ++k) forces[k / seats()] += bodies_.pad_force(k).z();
  return forces;
}

std::vector<double> SolidSleepers::seat_levels(double dt) const {
  std::vector<double> levels;
  for (const fem::NodeWeights& pad : below_) levels.push_back(bodies_.trapezoidal(dt, pad).z());
  return levels;
}

std::vector<double> SolidSleepers::seat_rates() const {
  std::vector<double> rates;
  for (const fem::NodeWeights& pad : below_) rates.push_back(bodies_.velocity(pad).z());
  return rates;
}

std::vector<track::Matrix2> SolidSleepers::seat_mobility(double dt) {
  std::vector<track::Matrix2> all(count(), track::Matrix2::Zero());
  for (std::size_t i = 0; i < count(); ++i) {
    const fem::NodeWeights* const pad = &below_[i * pads()];
    all[i](0, 0) = bodies_.mobility(dt, pad[0]);
    if (pads() == 1) continue;
    all[i](1, 1) = bodies_.mobility(dt, pad[1]);
    all[i](0, 1) = all[i](1, 0) = bodies_.mobility(dt, pad[0], pad[1]);
  }
  return all;
}

void SolidSleepers::add_pad_forces(std::span<const double> force) {
  require(force.size() == below_.size(), "one force per pad");
  std::vector<fem::Bodies::PatchLoad> pushes;
  for (std::size_t k = 0; k < force.size(); ++k) {
    given_[k / pads()] += force[k];
    pushes.push_back({below_[k], {0, 0, -force[k]}});
  }
  bodies_.add_loads(pushes);
}

// Bending stress: along the sleeper, at its lower face below each seat and in its middle (the end
// of a half sleeper).
observe::SolidState SolidSleepers::observed() const {
  observe::SolidState now;
  for (const fem::NodeWeights& seat : seat_)
    now.seat_displacement.push_back(bodies_.displacement(seat).z());
  for (const fem::NodeWeights& rail : rail_)
    now.rail_displacement.push_back(bodies_.displacement(rail).z());
  constexpr std::size_t yy = 1;
  for (std::size_t i = 0; i < count(); ++i) {
    const Vec3 middle = bodies_.centre(i);
    const double to_middle = model_.solid.half ? -model_.sleepers.length / 2 : 0;
    for (const double y : model_.solid.seats)
      now.bending_stress.push_back(bodies_.stress(i, {middle.x(), middle.y() + y, 0})[yy]);
    now.bending_stress.push_back(bodies_.stress(i, {middle.x(), middle.y() + to_middle, 0})[yy]);
  }
  return now;
}

void SolidSleepers::archive(io::Archive& a) {
  if (a.reads()) place(0);
  a.part("solid", bodies_);
  a.rows("reaction", reaction_, {"N", "from stones in the last window"});
  a.rows("solid/seat_force", given_,
         {"N", "applied to each sleeper in the last window, downwards"});
}

}  // namespace trackbed::model
