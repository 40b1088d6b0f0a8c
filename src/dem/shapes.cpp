#include <fmt/format.h>

#include "state.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::dem {

int Shapes::add(const Template& shape) {
  std::vector<std::string> problems;
  const auto number = templates_.size();
  if (shape.pieces.empty() || shape.pieces.size() >= (1u << piece_bits))
    problems.push_back(fmt::format("shape {} needs 1 to {} pieces", number, (1 << piece_bits) - 1));
  if (!(shape.volume > 0) || !(shape.gyration.minCoeff() > 0))
    problems.push_back(fmt::format("shape {} has no volume or inertia", number));
  double bound = 0;
  for (const Piece& piece : shape.pieces) {
    if (piece.core.size() != 1)
      problems.push_back(
          fmt::format("shape {} has a piece with {} core vertices: only spheres and "
                      "disks (1 vertex) can move yet",
                      number, piece.core.size()));
    else if (!(piece.radius > 0))
      problems.push_back(fmt::format("shape {} has a piece without a radius", number));
    else
      bound = std::max(bound, piece.core[0].norm() + piece.radius);
  }
  if (!problems.empty()) throw InputError(problems);
  for (const Piece& piece : shape.pieces)
    pieces_.push_back({piece.core[0].x(), piece.core[0].y(), piece.core[0].z(), piece.radius});
  only_spheres_ = only_spheres_ && shape.pieces.size() == 1 && shape.pieces[0].core[0].isZero();
  bound_.push_back(bound);
  begin_.push_back(pieces_.size());
  templates_.push_back(shape);
  return static_cast<int>(number);
}

double mass_of(const Template& shape, double scale, double density, const Domain& domain) {
  const double size = domain.dimension == Dimension::plane ? scale * scale * domain.thickness
                                                           : scale * scale * scale;
  return density * shape.volume * size;
}

}  // namespace trackbed::dem
