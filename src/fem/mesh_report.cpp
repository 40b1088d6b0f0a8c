// What tetrahedra are as a ground, and what in a mesh file may not be meant.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <limits>

#include "solid_mesh.hpp"
#include "tetrahedron.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

// Bounds for warnings: no ground of a track is so large or so thin; the steps in time of elements
// with this mean ratio (some 60 times as wide as high) are those of their height.
constexpr double large = 1000, small = 0.1;  // m
constexpr double poor_mean_ratio = 0.05;

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

// m^2 by the corners; of a face with curved edges nearly so.
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

// Bits of the components that a border holds at rest, as Terms has it: a quiet base by its springs,
// which are the same in all directions, or as if fixed.
int held_at_rest(BorderKind kind, const SolidMesh::Face& face) {
  const bool base = kind == BorderKind::quiet && face.axis == 2 && face.low;
  if (kind == BorderKind::free) return 0;
  return kind == BorderKind::fixed || base ? 7 : 1 << face.axis;
}

// Rigid motions t + w x r that the borders leave, as columns (t, w), of lengths over the size. A
// held component c at r sees t_c + w . (r x e_c).
Eigen::MatrixXd free_motions(const SolidMesh& mesh, const Box& all) {
  constexpr double rounding = 1e-10;  // of squares
  const Vec3 centre = (all.low + all.high) / 2;
  const double size = (all.high - all.low).norm();
  Eigen::Matrix<double, 6, 6> seen = Eigen::Matrix<double, 6, 6>::Zero();
  for (const SolidMesh::Face& face : mesh.borders) {
    const int bits = held_at_rest(face.holds, face);
    for (const std::int32_t n : mesh.nodes_of(face))
      for (int c = 0; c < 3; ++c) {
        if ((bits >> c & 1) == 0) continue;
        Eigen::Matrix<double, 6, 1> row;
        row << Vec3::Unit(c), ((place(mesh, n) - centre) / size).cross(Vec3::Unit(c));
        seen += row * row.transpose();
      }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> of(seen);
  Eigen::Index free = 0;  // ascending
  while (free < 6 && of.eigenvalues()[free] <= rounding * of.eigenvalues()[5]) ++free;
  return of.eigenvectors().leftCols(free);
}

// In words: along and about which axes a free motion goes, if only together with others.
void require_held(const SolidMesh& mesh, const GroundParameters& parameters, const Box& all) {
  const Eigen::MatrixXd free = free_motions(mesh, all);
  if (free.cols() == 0) return;
  std::vector<std::string> ways;
  for (int k = 0; k < 6; ++k)
    if (free.row(k).norm() > 0.1)
      ways.push_back(fmt::format("{} {}", k < 3 ? "move along" : "turn about",
                                 axes[static_cast<std::size_t>(k % 3)]));
  throw InputError({fmt::format(
      "{}: its borders do not hold the ground at rest: it can {}; let a border be fixed, quiet and "
      "below, or a roller across that",
      parameters.mesh, fmt::join(ways, ", "))});
}

// A wave comes in through dashpots below. Dashpots at the sides hold it back, for there are no
// columns of a free field beside a mesh.
void look_at_wave(const SolidMesh& mesh, const GroundParameters& parameters,
                  std::vector<std::string>& warnings) {
  if (parameters.base_motion.empty()) return;
  bool below = false, beside = false;
  for (const SolidMesh::Face& face : mesh.borders) {
    if (face.holds != BorderKind::quiet) continue;
    const bool base = face.axis == 2 && face.low;
    below = below || base;
    beside = beside || !base;
  }
  if (!below)
    throw InputError({fmt::format(
        "{}: no quiet border looks down: the wave of ground.base_motion comes in through the "
        "dashpots of one",
        parameters.mesh)});
  if (beside)
    warnings.push_back(fmt::format(
        "{}: quiet sides hold back the wave of ground.base_motion; a roller is a plane of symmetry "
        "of the wave, free-field sides are for layers",
        parameters.mesh));
}

void warn_of_size(const GroundParameters& parameters, const Box& all,
                  std::vector<std::string>& warnings) {
  const Vec3 size = all.high - all.low;
  if (parameters.mesh.empty()) return;
  if (size.maxCoeff() > large || size.minCoeff() < small)
    warnings.push_back(
        fmt::format("{}: the mesh measures {:g} x {:g} x {:g} m: is the file in metres?",
                    parameters.mesh, size.x(), size.y(), size.z()));
}

void warn_of_open_faces(const SolidMesh& mesh, const GroundParameters& parameters,
                        std::vector<std::string>& warnings) {
  if (mesh.open.empty()) return;
  const double open = area_of(mesh, mesh.open);
  const double outer = open + area_of(mesh, mesh.borders) + area_of(mesh, mesh.top);
  warnings.push_back(
      fmt::format("{}: {} outer faces are in no physical surface and free: {:.3g} m^2, {:.2g} % of "
                  "the outside, "
                  "at {}",
                  parameters.mesh, mesh.open.size(), open, 100 * open / outer,
                  box_of(mesh, mesh.open).words()));
}

void warn_of_shapes(const GroundParameters& parameters, const std::vector<double>& ratios,
                    std::vector<std::string>& warnings) {
  const auto worst = std::min_element(ratios.begin(), ratios.end());
  const auto poor = std::count_if(ratios.begin(), ratios.end(),
                                  [](double ratio) { return ratio < poor_mean_ratio; });
  if (poor > 0)
    warnings.push_back(fmt::format(
        "{}: {} of {} tetrahedra are nearly flat (mean ratio below {:g}; {:.2g} of tetrahedron {}"
        "{}): steps are short and stresses poor there",
        parameters.mesh.empty() ? "ground.section" : parameters.mesh, poor, ratios.size(),
        poor_mean_ratio, *worst, worst - ratios.begin() + 1,
        parameters.mesh.empty() ? "" : " of the file"));
}

}  // namespace

MeshReport look_at_mesh(const GroundParameters& parameters) {
  const SolidMesh mesh = make_solid_mesh(parameters);
  const Box top = box_of(mesh, mesh.top);
  Box all;
  for (const Vec3& at : mesh.position) all.take(at);
  require_held(mesh, parameters, all);
  MeshReport report{all.low, all.high, top.low, top.high, 0, {}};
  std::vector<double> ratios;
  for (const auto& element : mesh.element) {
    TenNodes nodes;
    for (std::size_t k = 0; k < 10; ++k) nodes[k] = place(mesh, element[k]);
    report.volume += tetrahedron_volume(nodes);
    ratios.push_back(tetrahedron_mean_ratio(nodes));
  }
  look_at_wave(mesh, parameters, report.warnings);
  warn_of_size(parameters, all, report.warnings);
  warn_of_open_faces(mesh, parameters, report.warnings);
  warn_of_shapes(parameters, ratios, report.warnings);
  return report;
}

}  // namespace trackbed::fem
