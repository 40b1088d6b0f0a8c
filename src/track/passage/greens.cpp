// Mass, damping and stiffness of the track are symmetric, so that the response of the sleeper to a
// force at x is that of the rail at x to a force at the sleeper, in discrete time as well: one time
// integration gives the responses to forces at all positions. The force below a moving wheel has no
// such point in common; its response is superposed from those to unit forces on each unknown of the
// rail within the range, which shape functions distribute to the positions.
// Rejected: receptances and their inverse Fourier transform (the thesis), which need a response
// that has decayed, and would not be that of the steps of a passage.
#include "trackbed/track/greens.hpp"

#include <algorithm>
#include <cmath>

#include "trackbed/core/error.hpp"
#include "trackbed/core/whole_steps.hpp"

namespace trackbed::track {

namespace {

// Integrates the response to the pulse of `unit` and calls `sample(n)` at each sample.
template <class Sample>
void respond(Newmark& motion, const Vector& unit, std::int64_t substeps, std::size_t samples,
             const Sample& sample) {
  const Vector none = Vector::Zero(unit.size());
  motion.displacement = motion.velocity = motion.acceleration = none;
  const auto last = static_cast<std::int64_t>(samples - 1) * substeps;
  for (std::int64_t k = 1 - substeps; k <= last; ++k) {
    const double size = 1 - static_cast<double>(std::abs(k)) / static_cast<double>(substeps);
    motion.accept(motion.free_change(size > 0 ? Vector(size * unit) : none));
    if (k >= 0 && k % substeps == 0) sample(k / substeps);
  }
}

}  // namespace

GreensFunctions::GreensFunctions(const Line& line, const GreensParameters& parameters)
    : line_(line),
      parameters_(parameters),
      substeps_(steps_covering(1 / parameters.rate, parameters.step)),
      samples_(
          static_cast<std::size_t>(steps_covering(parameters.duration, 1 / parameters.rate) + 1)) {
  require(line.stops().empty() && line.moved() == 0,
          "Green's functions are those of linear tracks");
}

double GreensFunctions::step() const {
  return 1 / (parameters_.rate * static_cast<double>(substeps_));
}

GreensFunctions::Fixed GreensFunctions::fixed(const std::vector<double>& x,
                                              std::size_t side) const {
  Newmark motion(line_.system(), step());
  Vector unit = Vector::Zero(motion.displacement.size());
  unit[line_.sleeper_unknown(line_.nearest_sleeper(parameters_.sensor), parameters_.side)] = 1;
  std::vector<RailPoint> points;
  for (const double at : x) points.push_back(line_.at(at, side));
  const auto rows = static_cast<Eigen::Index>(x.size());
  Fixed found{Columns(rows, samples_), Columns(rows, samples_)};
  respond(motion, unit, substeps_, samples_, [&](std::int64_t n) {
    for (Eigen::Index i = 0; i < rows; ++i) {
      const RailPoint& point = points[static_cast<std::size_t>(i)];
      found.displacement(i, n) = point.deflection(motion.displacement);
      found.acceleration(i, n) = point.deflection(motion.acceleration);
    }
  });
  return found;
}

Columns GreensFunctions::moving(const std::vector<double>& x, std::size_t axle,
                                std::size_t side) const {
  Newmark motion(line_.system(), step());
  const double ahead = parameters_.axles.at(axle);
  const auto wheel_at = [&](double force, std::int64_t n) {
    return force + ahead + parameters_.speed * static_cast<double>(n) / parameters_.rate;
  };
  Columns found = Columns::Zero(static_cast<Eigen::Index>(x.size()), samples_);
  // Positions on the elements beside each unknown, with its value of the shape function there.
  std::vector<std::vector<std::pair<Eigen::Index, double>>> at(
      static_cast<std::size_t>(motion.displacement.size()));
  for (std::size_t i = 0; i < x.size(); ++i) {
    const RailPoint point = line_.at(x[i], side);
    for (std::size_t k = 0; k < 4; ++k)
      if (point.unknown[k] >= 0)
        at[static_cast<std::size_t>(point.unknown[k])].emplace_back(i, point.value[k]);
    if (ahead == 0 && side == parameters_.side)
      found(static_cast<Eigen::Index>(i), 0) = point.local;
  }
  for (std::size_t unknown = 0; unknown < at.size(); ++unknown) {
    if (at[unknown].empty()) continue;
    const Vector unit = Vector::Unit(motion.displacement.size(), unknown);
    respond(motion, unit, substeps_, samples_, [&](std::int64_t n) {
      for (const auto& [i, value] : at[unknown])
        found(i, n) +=
            value * line_.at(wheel_at(x[static_cast<std::size_t>(i)], n), parameters_.side)
                        .deflection(motion.displacement);
    });
  }
  return found;
}

}  // namespace trackbed::track
