// Geometry of a ground of tetrahedra, and warnings about what may be unintended in a mesh file.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "fem/mesh/lattice.hpp"
#include "fem/mesh/solid_mesh.hpp"
#include "fem/shape/tetrahedron.hpp"
#include "fem/time/base_motion.hpp"
#include "trackbed/core/decompositions.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

// Limits for warnings: no ground of a track is so large or so thin; elements with this mean ratio
// (some 60 times as wide as high) have time steps that depend on their height.
constexpr double large = 1000, small = 0.1;  // m
constexpr double poor_mean_ratio = 0.05;
// Relative to the length of an edge: more than the deviation of straight edges in files with six
// digits.
constexpr double bent = 1e-3;

constexpr std::array<const char*, 3> axes = {"x", "y", "z"};

struct Box {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  void take(const Vec3& at) { low = low.cwiseMin(at), high = high.cwiseMax(at); }
  std::string words() const {
    return fmt::format("x = {:g} to {:g}, y = {:g} to {:g}, z = {:g} to {:g} m", low.x(), high.x(),
                       low.y(), high.y(), low.z(), high.z());
  }
};

const Vec3& place(const SolidMesh& mesh, std::int32_t node) {
  return mesh.position[static_cast<std::size_t>(node)];
}

// m^2 from the corners; approximate for faces with curved edges.
double area_of(const SolidMesh& mesh, const SolidMesh::Face& face) {
  const auto nodes = mesh.nodes_of(face);
  const Vec3& home = place(mesh, nodes[0]);
  return 0.5 * (place(mesh, nodes[1]) - home).cross(place(mesh, nodes[2]) - home).norm();
}

double area_of(const SolidMesh& mesh, const std::vector<SolidMesh::Face>& faces) {
  double sum = 0;
  for (const SolidMesh::Face& face : faces) sum += area_of(mesh, face);
  return sum;
}

Box box_of(const SolidMesh& mesh, const std::vector<SolidMesh::Face>& faces) {
  Box box;
  for (const SolidMesh::Face& face : faces)
    for (const std::int32_t n : mesh.nodes_of(face)) box.take(place(mesh, n));
  return box;
}

// Bits of the components that a border holds in static equilibrium, as in Terms: a viscous base by
// its springs, which are the same in all directions, or as if fixed.
int held_static(BorderKind kind, const SolidMesh::Face& face) {
  const bool base = kind == BorderKind::viscous && face.axis == 2 && face.low;
  if (kind == BorderKind::free) return 0;
  return kind == BorderKind::fixed || base ? 7 : 1 << face.axis;
}

// Rigid motions t + w x r that the borders permit, as columns (t, w), with lengths over the size. A
// held component c at r constrains t_c + w . (r x e_c).
Eigen::MatrixXd free_motions(const SolidMesh& mesh, const Box& all) {
  constexpr double rounding = 1e-10;  // of squares
  const Vec3 centre = (all.low + all.high) / 2;
  const double size = (all.high - all.low).norm();
  Eigen::Matrix<double, 6, 6> gram = Eigen::Matrix<double, 6, 6>::Zero();
  for (const SolidMesh::Face& face : mesh.borders) {
    const int bits = held_static(face.holds, face);
    for (const std::int32_t n : mesh.nodes_of(face))
      for (int c = 0; c < 3; ++c) {
        if ((bits >> c & 1) == 0) continue;
        Eigen::Matrix<double, 6, 1> row;
        row << Vec3::Unit(c), ((place(mesh, n) - centre) / size).cross(Vec3::Unit(c));
        gram += row * row.transpose();
      }
  }
  const auto [values, vectors] = symmetric_modes(gram);
  Eigen::Index free = 0;
  while (free < 6 && values[free] <= rounding * values[5]) ++free;
  return vectors.leftCols(free);
}

// Describes along and about which axes a rigid motion is free, possibly only combined with others.
void require_held(const SolidMesh& mesh, const GroundParameters& parameters, const Box& all) {
  const Eigen::MatrixXd free = free_motions(mesh, all);
  if (free.cols() == 0) return;
  std::vector<std::string> motions;
  for (int k = 0; k < 6; ++k)
    if (free.row(k).norm() > 0.1)
      motions.push_back(fmt::format("{} {}", k < 3 ? "move along" : "rotate about",
                                    axes[static_cast<std::size_t>(k % 3)]));
  throw InputError({fmt::format(
      "{}: the borders do not hold the ground in static equilibrium: it can {}; add a "
      "fixed border, a viscous border at the base, or a roller (it fixes the displacement "
      "along its normal and rotations about axes in its plane)",
      parameters.mesh, fmt::join(motions, " and "))});
}

// Effect of a border face on a wave along these axes. A free face at an end of the mesh is where
// the ground continues; other free faces are slopes.
enum class WaveEffect { nothing, base, dashpots, holder, gap };
WaveEffect wave_effect(const SolidMesh& mesh, const SolidMesh::Face& face, const BaseMotion& wave,
                       const Box& all) {
  constexpr double rounding = 1e-9;  // of the size
  const bool side = face.axis == 0 || face.axis == 1;
  switch (face.holds) {
    case BorderKind::viscous:
      return face.axis == 2 && face.low ? WaveEffect::base : WaveEffect::dashpots;
    case BorderKind::fixed:
      return face.axis == 0 && wave.moves(0) ? WaveEffect::holder : WaveEffect::dashpots;
    case BorderKind::roller:
      return face.axis != 1 && wave.moves(face.axis) ? WaveEffect::holder : WaveEffect::nothing;
    case BorderKind::free:
      break;
  }
  if (!side || (face.axis == 1 && !wave.moves(2))) return WaveEffect::nothing;
  const double at = place(mesh, mesh.nodes_of(face)[0])[face.axis],
               end = (face.low ? all.low : all.high)[face.axis];
  return std::abs(at - end) <= rounding * (all.high - all.low).norm() ? WaveEffect::gap
                                                                      : WaveEffect::nothing;
}

// For a mesh file. A wave enters through dashpots at the base. Dashpots at the sides impede it,
// because a mesh has no free-field columns beside it; constraints along its motion change the wave.
void check_wave(const SolidMesh& mesh, const GroundParameters& parameters, const Box& all,
                std::vector<std::string>& warnings) {
  if (parameters.mesh.empty() || parameters.base_motion.empty()) return;
  const BaseMotion wave(parameters.base_motion);
  bool below = false;
  std::map<std::pair<std::int32_t, WaveEffect>, int> effects;  // by border: an axis of its faces
  for (const SolidMesh::Face& face : mesh.borders) {
    const WaveEffect what = wave_effect(mesh, face, wave, all);
    below = below || what == WaveEffect::base;
    effects[{face.border, what}] = face.axis;
  }
  std::vector<std::string> problems;
  if (!below)
    problems.push_back(fmt::format(
        "{}: no viscous border faces down, but the wave of ground.base_motion enters through the "
        "dashpots of such a border; set holds = \"viscous\" for the border at the base",
        parameters.mesh));
  for (const auto& [at, axis] : effects) {
    const auto report = [&, border = at.first](std::vector<std::string>& to,
                                               const std::string& what) {
      const MeshBorder& named = parameters.borders[static_cast<std::size_t>(border)];
      to.push_back(fmt::format("{}: the border \"{}\" {}", parameters.mesh, named.name, what));
    };
    if (at.second == WaveEffect::dashpots)
      report(warnings,
             "impedes the wave of ground.base_motion, since a mesh has no free-field sides; if the "
             "wave moves the ground parallel to this face, use a roller; otherwise place the face "
             "far from the track");
    if (at.second == WaveEffect::gap)
      report(
          warnings,
          "is free and at an end of the mesh: there is no ground beside it that moves with the "
          "wave of ground.base_motion; if the wave moves the ground parallel to this face, use a "
          "roller; otherwise place the face far from the track");
    if (at.second == WaveEffect::holder)
      report(
          problems,
          fmt::format("holds the ground along {0}, but the wave of ground.base_motion moves "
                      "the ground along {0} (v{0}_m_s is not 0); use \"viscous\" or \"free\" and "
                      "place the face far from the track",
                      axes[static_cast<std::size_t>(axis)]));
  }
  if (!problems.empty()) throw InputError(problems);
}

void warn_of_size(const GroundParameters& parameters, const Box& all,
                  std::vector<std::string>& warnings) {
  const Vec3 size = all.high - all.low;
  if (parameters.mesh.empty()) return;
  if (size.maxCoeff() > large || size.minCoeff() < small)
    warnings.push_back(
        fmt::format("{}: the mesh measures {:g} x {:g} x {:g} m (usual: {:g} to {:g} m): is the "
                    "file in metres?",
                    parameters.mesh, size.x(), size.y(), size.z(), small, large));
}

void warn_of_open_faces(const SolidMesh& mesh, const GroundParameters& parameters,
                        std::vector<std::string>& warnings) {
  if (mesh.open.empty()) return;
  const double open = area_of(mesh, mesh.open);
  const double outer = open + area_of(mesh, mesh.borders) + area_of(mesh, mesh.top);
  warnings.push_back(
      fmt::format("{}: {} outer faces are in no physical surface and therefore free ({:.3g} m^2, "
                  "{:.2g} % of the boundary, within {})",
                  parameters.mesh, mesh.open.size(), open, 100 * open / outer,
                  box_of(mesh, mesh.open).words()));
}

void warn_of_shapes(const GroundParameters& parameters, const std::vector<double>& ratios,
                    std::vector<std::string>& warnings) {
  const auto worst = std::min_element(ratios.begin(), ratios.end());
  const auto poor = std::count_if(ratios.begin(), ratios.end(),
                                  [](double ratio) { return ratio < poor_mean_ratio; });
  if (poor > 0)
    warnings.push_back(
        fmt::format("{}: {} of {} tetrahedra are nearly flat: their shape quality (mean ratio, 1: "
                    "equilateral) is below {:g}, the lowest is "
                    "{:.2g} (tetrahedron number {}{}); stresses are inaccurate there, and the "
                    "stable explicit step of "
                    "the whole ground is short; improve the mesh at this place",
                    parameters.mesh.empty() ? "ground.section" : parameters.mesh, poor,
                    ratios.size(), poor_mean_ratio, *worst, worst - ratios.begin() + 1,
                    parameters.mesh.empty() ? "" : " in the file, counting only tetrahedra"));
}

// Stones and pressures act on two straight pieces for a curved edge of the top, so that a uniform
// pressure does not cause a uniform stress in the elements (flat_top.hpp).
void warn_of_curved_edges(const SolidMesh& mesh, const GroundParameters& parameters,
                          std::vector<std::string>& warnings) {
  std::map<std::int32_t, double> off;  // by middle node, over the length of its edge
  for (const SolidMesh::Face& face : mesh.top) {
    const auto nodes = mesh.nodes_of(face);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& begin = place(mesh, nodes[k]);
      const Vec3 along = place(mesh, nodes[(k + 1) % 3]) - begin;
      const Vec3 middle = place(mesh, nodes[3 + k]) - begin;
      if (const double fraction = middle.cross(along).norm() / along.squaredNorm(); fraction > bent)
        off[nodes[3 + k]] = fraction;
    }
  }
  if (off.empty()) return;
  const auto worst = std::max_element(
      off.begin(), off.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  const Vec3& at = place(mesh, worst->first);
  warnings.push_back(
      fmt::format("{}: {} edges of the top are curved: a mid-edge node is off the straight line "
                  "between the corners by up to {:.2g} % of the length of the edge, at ({:g}, "
                  "{:g}, {:g}) m; for stones and pressures, each of these edges is replaced by two "
                  "straight lines through its mid-edge node",
                  parameters.mesh, off.size(), 100 * worst->second, at.x(), at.y(), at.z()));
}

// A block without any element would be ignored without notice.
void require_blocks(const SolidMesh& mesh, const GroundParameters& parameters) {
  if (parameters.sections.empty()) return;
  const Solids solids(parameters, make_lattice(parameters, Dimension::space, 1));
  std::vector<bool> found(parameters.layers.size() + parameters.blocks.size(), false);
  for (const std::int32_t solid : mesh.solid)
    found[static_cast<std::size_t>(solids.region[static_cast<std::size_t>(solid)])] = true;
  std::vector<std::string> problems;
  for (std::size_t b = 0; b < parameters.blocks.size(); ++b)
    if (parameters.blocks[b].present && !found[parameters.layers.size() + b])
      problems.push_back(fmt::format(
          "ground.block[{}] (\"{}\"): its outline contains the centre of no cell of the "
          "embankment, or later blocks overrule it everywhere; move or enlarge it, use smaller "
          "elements, or set present = false",
          b, parameters.blocks[b].name));
  if (!problems.empty()) throw InputError(problems);
}

}  // namespace

MeshReport look_at_mesh(const GroundParameters& parameters) {
  const SolidMesh mesh = make_solid_mesh(parameters);
  const Box top = box_of(mesh, mesh.top);
  Box all;
  for (const Vec3& at : mesh.position) all.take(at);
  require_held(mesh, parameters, all);
  require_blocks(mesh, parameters);
  MeshReport report{all.low, all.high, top.low, top.high};
  for (const SolidMesh::Face& face : mesh.top) {
    const auto nodes = mesh.nodes_of(face);
    report.top_faces.push_back(
        {place(mesh, nodes[0]), place(mesh, nodes[1]), place(mesh, nodes[2])});
  }
  std::vector<double> ratios;
  for (const auto& element : mesh.element) {
    TenNodes nodes;
    for (std::size_t k = 0; k < 10; ++k) nodes[k] = place(mesh, element[k]);
    report.volume += tetrahedron_volume(nodes);
    ratios.push_back(tetrahedron_mean_ratio(nodes));
  }
  check_wave(mesh, parameters, all, report.warnings);
  warn_of_size(parameters, all, report.warnings);
  warn_of_open_faces(mesh, parameters, report.warnings);
  warn_of_shapes(parameters, ratios, report.warnings);
  warn_of_curved_edges(mesh, parameters, report.warnings);
  return report;
}

std::vector<std::size_t> covered_blocks(const GroundParameters& parameters, Dimension dimension) {
  const Lattice lattice = make_lattice(parameters, dimension, 1);
  const auto count = parameters.blocks.size();
  std::vector<bool> holds(count, false), left(count, false);
  for (Id element = 0; element < lattice.element_count(); ++element) {
    const Vec3 centre = lattice.centre(element);
    const int region = block_at(parameters, centre);
    if (region < 0) continue;
    left[static_cast<std::size_t>(region) - parameters.layers.size()] = true;
    for (std::size_t b = 0; b < count; ++b)
      holds[b] = holds[b] || left[b] || contains(parameters.blocks[b], centre);
    if (std::find(left.begin(), left.end(), false) == left.end()) break;
  }
  std::vector<std::size_t> covered;
  for (std::size_t b = 0; b < count; ++b)
    if (holds[b] && !left[b]) covered.push_back(b);
  return covered;
}

}  // namespace trackbed::fem
