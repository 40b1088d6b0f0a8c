// Templates are added and never removed: particles refer to them by number. The template of a
// single stone that wears is replaced.
#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "dem/state/state.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::dem {

namespace {

double least_radius_of(const Template& shape) {
  return std::min_element(shape.pieces.begin(), shape.pieces.end(),
                          [](const Piece& a, const Piece& b) { return a.radius < b.radius; })
      ->radius;
}

}  // namespace

// A core is kept as a checkpoint would return it, so that volumes, sections and points within a
// stone are the same, to the last bit, after a resume.
//
// A shape is checked as a whole before anything is stored: after an InputError nothing has changed.
// Whether the kernels may skip attitudes and corners is decided by all templates together: one
// stone among spheres requires attitudes of all particles.
int Shapes::add(const Template& shape, std::vector<std::int64_t> labels) {
  std::vector<std::string> problems;
  const auto number = templates_.size();
  if (shape.pieces.empty() || shape.pieces.size() >= (1u << piece_bits))
    problems.push_back(fmt::format("shape {} has {} pieces, but needs 1 to {}", number,
                                   shape.pieces.size(), (1 << piece_bits) - 1));
  if (!(shape.volume > 0) || !(shape.gyration.minCoeff() > 0))
    problems.push_back(fmt::format("shape {} has no volume or inertia", number));
  std::vector<Core> cores;
  for (const Piece& piece : shape.pieces) try {
      cores.push_back(core_of(piece));
    } catch (const std::invalid_argument& problem) {
      problems.push_back(fmt::format("shape {} has {}", number, problem.what()));
    }
  if (!problems.empty()) throw InputError(problems);
  for (auto k = static_cast<std::int64_t>(labels.size()); labels.size() < shape.pieces.size(); ++k)
    labels.push_back(k);
  for (Core& core : cores) {
    any_stones_ = any_stones_ || core.corners.size() > 1;
    pieces_.push_back(ball_around(core));
    first_corner_.push_back(static_cast<std::uint32_t>(corners_.size()));
    corners_.insert(corners_.end(), core.corners.begin(), core.corners.end());
    cores_.push_back(std::move(core));
  }
  labels_.insert(labels_.end(), labels.begin(), labels.end());
  // Centred: only then nothing depends on the attitude.
  only_spheres_ = only_spheres_ && shape.pieces.size() == 1 &&
                  shape.pieces[0].core.vertices.size() == 1 &&
                  shape.pieces[0].core.vertices[0].isZero();
  bound_.push_back(geom::bounding_radius(shape));
  least_radius_.push_back(least_radius_of(shape));
  begin_.push_back(pieces_.size());
  templates_.push_back(shape);
  for (Piece& piece : templates_.back().pieces) piece.core = geom::derived_again(piece.core);
  return static_cast<int>(number);
}

void Shapes::replace(std::int64_t number, const Template& shape) {
  Template& known = templates_[static_cast<std::size_t>(number)];
  require(shape.pieces.size() == known.pieces.size(), "a worn stone has the pieces it had");
  for (std::size_t k = 0; k < shape.pieces.size(); ++k) {
    const std::size_t piece = begin(number) + k;
    Core core = core_of(shape.pieces[k]);
    require(core.corners.size() == cores_[piece].corners.size(),
            "a worn stone has the corners it had");
    pieces_[piece] = ball_around(core);
    std::copy(core.corners.begin(), core.corners.end(), corners_.begin() + first_corner_[piece]);
    cores_[piece] = std::move(core);
  }
  bound_[static_cast<std::size_t>(number)] = geom::bounding_radius(shape);
  least_radius_[static_cast<std::size_t>(number)] = least_radius_of(shape);
  known = shape;
  for (Piece& piece : known.pieces) piece.core = geom::derived_again(piece.core);
}

// Volume grows with scale^3; in a plane model the template has an area, which grows with scale^2.
double mass_of(const Template& shape, double scale, double density, const Domain& domain) {
  const double size = domain.dimension == Dimension::plane ? scale * scale * domain.thickness
                                                           : scale * scale * scale;
  return density * shape.volume * size;
}

}  // namespace trackbed::dem
