// Output for the inspection of shapes: measures for publications, the accuracy with which a scan is
// approximated, and a picture of the contact surfaces, rounding included.
#include "app/command/shapes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "trackbed/core/error.hpp"
#include "trackbed/geom/mesh.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/io/replace.hpp"
#include "trackbed/model/checks.hpp"
#include "trackbed/model/parameters.hpp"

namespace trackbed::app {

namespace {

namespace fs = std::filesystem;
using bed::NamedShape;

// Each placed stone of the deck at its size, with its name.
std::vector<NamedShape> shapes_of_placed(const par::Comm& comm, const model::Model& model) {
  std::vector<NamedShape> shapes;
  const std::vector<bed::PlacedShape> made = model::placed_shapes(comm, model);
  for (std::size_t i = 0; i < made.size(); ++i) {
    dem::Template shape = made[i].shape;
    const double scale = made[i].scale;
    for (dem::Piece& piece : shape.pieces) {
      piece.core = geom::scaled(std::move(piece.core), scale);
      piece.radius *= scale;
    }
    const bool plane = model.dimension == Dimension::plane;
    shape.volume *= plane ? scale * scale : scale * scale * scale;
    shape.gyration *= scale * scale, shape.sieve *= scale;
    shapes.push_back({model.placed.stones[i].name, std::move(shape), {}});
  }
  return shapes;
}

// The templates of a bed of this deck, drawn with the same seed, then those of its other layers
// with their names. The dimension of the last deck determines the units of the table.
std::vector<NamedShape> shapes_of_deck(const par::Comm& comm, const std::string& file,
                                       Dimension& dimension) {
  const input::Deck deck = input::Deck::read(comm, file, {});
  model::Model model;
  deck.fill([&](input::Section& section) { model.declare(section); });
  dimension = model.dimension;
  if (model.is_placed()) return shapes_of_placed(comm, model);
  std::vector<NamedShape> shapes;
  const auto add = [&](const std::string& name, const bed::BedParameters& layer) {
    std::size_t number = 0;
    for (const dem::Template& shape : bed::templates(comm, layer, model.dimension))
      shapes.push_back({fmt::format("{}_{}", name, number++), shape, {}});
  };
  const std::string name = fs::path(file).stem().string();
  add(name, model.bed);
  for (const bed::NamedLayer& layer : model.bed.layers)
    add(name + "_" + layer.name, model.bed.of_layer(layer.name));
  return shapes;
}

void append(std::vector<NamedShape>& shapes, std::vector<NamedShape> more) {
  for (NamedShape& shape : more) shapes.push_back(std::move(shape));
}

// Surface area of the union of the pieces, its bounding box in principal axes, and calliper
// measures. Corners and faces are those of the cores. The area of overlapping pieces is estimated
// by counting intersections with lines, to about one per cent.
struct Measures {
  double area = 0;
  Vec3 extents = Vec3::Zero();
  geom::Callipers callipers;
  double greatest = 0;  // m
  std::size_t vertices = 0, faces = 0;
};

Measures measures_of(const dem::Template& shape) {
  Measures m;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const dem::Piece& piece : shape.pieces) {
    m.vertices += piece.core.vertices.size();
    m.faces += piece.core.faces.size();
    for (const Vec3& corner : piece.core.vertices) {
      low = low.cwiseMin(corner - Vec3::Constant(piece.radius));
      high = high.cwiseMax(corner + Vec3::Constant(piece.radius));
    }
  }
  m.extents = high - low;
  m.callipers = geom::callipers_of(shape.pieces);
  m.greatest = geom::greatest_extent(shape.pieces);
  m.area = shape.pieces.size() == 1 ? geom::surface_area(shape.pieces[0])
                                    : geom::union_area(shape.pieces);
  return m;
}

// In cm^3 (cm^2 for a plane stone) and mm.
std::string row(const NamedShape& named, Dimension dimension) {
  const dem::Template& shape = named.shape;
  const Measures m = measures_of(shape);
  const Vec3 gyration = 1e3 * shape.gyration.cwiseSqrt();
  const bool plane = dimension == Dimension::plane;
  return fmt::format(
      "{:<20} {:>6} {:>8} {:>5} {:>10.4g} {:>7.1f} {:>7.1f} {:>7.1f} {:>10} {:>7.2f} "
      "{:>6.2f} {:>6.2f} {:>6.2f} {:>8.3f} {:>8.3f} {:>8.3f} {:>9.2f}\n",
      named.name, shape.pieces.size(), m.vertices, m.faces, shape.volume * (plane ? 1e4 : 1e6),
      1e3 * m.extents.x(), 1e3 * m.extents.y(), 1e3 * m.extents.z(),
      plane ? "-" : fmt::format("{:.3f}", geom::sphericity(shape.volume, m.area)),
      1e3 * shape.sieve, gyration.x(), gyration.y(), gyration.z(), 1e3 * m.callipers.thickness,
      1e3 * m.callipers.width, 1e3 * m.callipers.length, 1e3 * m.greatest);
}

// Thickness S, width I and length L by callipers; the greatest extent; the box in principal axes;
// radii of gyration (root of principal inertia over mass) about these. New columns are added at the
// end, so that columns keep their positions.
std::string table(const std::vector<NamedShape>& shapes, Dimension dimension) {
  std::string text = fmt::format(
      "{:<20} {:>6} {:>8} {:>5} {:>10} {:>7} {:>7} {:>7} {:>10} {:>7} "
      "{:>6} {:>6} {:>6} {:>8} {:>8} {:>8} {:>9}\n",
      "name", "pieces", "vertices", "faces",
      dimension == Dimension::plane ? "area cm2" : "volume cm3", "x mm", "y mm", "z mm",
      "sphericity", "sieve mm", "i_x mm", "i_y mm", "i_z mm", "S mm", "I mm", "L mm", "L_max mm");
  for (const NamedShape& named : shapes) {
    text += row(named, dimension);
    for (const std::string& note : named.notes) text += "  " + note + "\n";
  }
  return text;
}

// First line of pictures written by trackbed; files without it are other meshes.
constexpr std::string_view picture_head = "# shapes of trackbed, rounding included, m";

// Scans and pictures have the same file extension: only a picture of trackbed is replaced.
// Collective.
void require_picture(const par::Comm& comm, const std::string& file) {
  std::string problem;
  if (!file.ends_with(".obj")) problem = "pictures are OBJ files: the name must end in .obj";
  std::error_code ignored;
  if (problem.empty() && comm.root() && fs::exists(file, ignored)) {
    std::string line;
    std::ifstream old(file);
    std::getline(old, line);
    if (line != picture_head)
      problem = "exists, but is not a picture made by this command; move it or choose another name";
  }
  problem = comm.broadcast(problem);
  if (!problem.empty()) throw InputError({file + ": " + problem});
}

// Shapes side by side along x, in rows along y; an object per shape, a group per piece (OBJ).
// Vertices are numbered through the whole file from 1, as the format requires. The pitch is that of
// the largest shape. Returns an error message, or empty; on rank 0.
std::string write_picture(const std::string& file, const std::vector<NamedShape>& shapes) {
  errno = 0;
  std::ofstream picture(file);
  double pitch = 0;
  for (const NamedShape& named : shapes)
    pitch = std::max(pitch, 2.1 * geom::bounding_radius(named.shape));
  const auto columns = static_cast<std::size_t>(std::ceil(std::sqrt(shapes.size())));
  std::size_t first = 1;
  picture << picture_head << "\n";
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    const Vec3 at =
        pitch * Vec3(static_cast<double>(k % columns), static_cast<double>(k / columns), 0);
    const geom::Callipers c = geom::callipers_of(shapes[k].shape.pieces);
    picture << fmt::format("o {}\n# S {:.9g} I {:.9g} L {:.9g} m by callipers\n", shapes[k].name,
                           c.thickness, c.width, c.length);
    for (std::size_t p = 0; p < shapes[k].shape.pieces.size(); ++p) {
      const geom::Mesh mesh = geom::surface_of(shapes[k].shape.pieces[p]);
      picture << fmt::format("g {}_{}\n", shapes[k].name, p);
      for (const Vec3& x : mesh.vertices)
        picture << fmt::format("v {:.9g} {:.9g} {:.9g}\n", x.x() + at.x(), x.y() + at.y(),
                               x.z() + at.z());
      for (const auto& [a, b, c] : mesh.triangles)
        picture << fmt::format("f {} {} {}\n", a + first, b + first, c + first);
      first += mesh.vertices.size();
    }
  }
  picture.close();
  if (picture) return "";
  return fmt::format("{}: cannot be written ({})", file,
                     errno != 0 ? std::strerror(errno) : "no reason given");
}

enum class Source { deck, library, mesh };

Source source_of(const std::string& file) {
  const std::string ending = fs::path(file).extension().string();
  return ending == ".toml" ? Source::deck : ending == ".h5" ? Source::library : Source::mesh;
}

// Options without effect are refused, all of them at once.
std::vector<std::string> idle_options(const ShapeArguments& arguments) {
  const bool meshes = std::any_of(arguments.files.begin(), arguments.files.end(),
                                  [](auto& file) { return source_of(file) == Source::mesh; });
  const bool stones = arguments.stones > 0, pieces = meshes && arguments.mesh.spheres == 0;
  struct Rule {
    std::string_view option;
    bool acts;
    std::string_view words;
  };
  constexpr std::string_view of_stones = "is for parametric stones; give their number (--stones N)",
                             of_meshes = "is for meshes; name one (.stl, .ply or .obj)",
                             of_pieces =
                                 "is for parametric stones (--stones N) and for meshes that are "
                                 "divided into convex pieces";
  const Rule rules[] = {{"--elongation", stones, of_stones},
                        {"--flatness", stones, of_stones},
                        {"--spread", stones, of_stones},
                        {"--angularity", stones, of_stones},
                        {"--seed", stones, of_stones},
                        {"--unit", meshes, of_meshes},
                        {"--spheres", meshes, of_meshes},
                        {"--parts", pieces,
                         meshes ? "represents a mesh by convex pieces, and --spheres by spheres: "
                                  "give only one of these options"
                                : of_meshes},
                        {"--vertices", stones || pieces, of_pieces},
                        {"--rounding", stones || pieces, of_pieces}};
  std::vector<std::string> problems;
  for (const auto& [option, acts, words] : rules)
    if (!acts &&
        std::find(arguments.given.begin(), arguments.given.end(), option) != arguments.given.end())
      problems.push_back(fmt::format("{} {}", option, words));
  return problems;
}

// Checked before anything is read or written. Collective.
void require_sound(const par::Comm& comm, const ShapeArguments& arguments) {
  std::vector<std::string> problems = idle_options(arguments);
  if (const double unit = arguments.mesh.unit; !(unit > 0) || !std::isfinite(unit))
    problems.push_back(fmt::format("--unit = {:g} must be above 0", unit));
  if (arguments.files.empty() && arguments.stones == 0)
    problems.emplace_back("no shapes: name a deck, a library or a mesh, or give --stones N");
  if (!arguments.library.empty() && !arguments.library.ends_with(".h5"))
    problems.push_back(fmt::format(
        "--library {}: libraries are HDF5 files: the name must end in .h5", arguments.library));
  const bool rounds = arguments.stones > 0 || arguments.mesh.spheres == 0;
  if (!arguments.library.empty() && arguments.mesh.rounding == 0 && rounds)
    problems.emplace_back(
        "--rounding 0 makes stones without rounding, which cannot be used in a bed: give a "
        "rounding above 0, or leave out --library");
  if (!problems.empty()) throw InputError(problems);
  if (!arguments.picture.empty()) require_picture(comm, arguments.picture);
  if (!arguments.library.empty()) bed::require_replaceable(comm, arguments.library);
}

}  // namespace

// Collective. Input is checked before anything is written; what cannot be written is a RunError on
// all ranks.
int shapes(const par::Comm& comm, const ShapeArguments& arguments) {
  require_sound(comm, arguments);
  std::vector<NamedShape> all;
  Dimension dimension = Dimension::space;
  for (const std::string& file : arguments.files) {
    const Source source = source_of(file);
    if (source == Source::deck)
      append(all, shapes_of_deck(comm, file, dimension));
    else if (source == Source::library)
      append(all, bed::load_library(comm, file));
    else
      all.push_back(bed::shape_of_mesh(comm, file, arguments.mesh));
  }
  for (std::int64_t k = 0; k < arguments.stones; ++k)
    all.push_back(bed::parametric_shape(arguments.stone, arguments.mesh.rounding,
                                        static_cast<std::uint64_t>(arguments.seed + k)));
  // Only libraries without shapes were named.
  if (all.empty()) throw InputError({arguments.files.front() + ": contains no shapes"});
  if (comm.root()) std::fputs(table(all, dimension).c_str(), stdout);
  if (!arguments.library.empty()) bed::save_library(comm, arguments.library, all);
  if (!arguments.picture.empty())
    io::replace_file(comm, arguments.picture, [&](const std::string& part) {
      comm.agree(comm.root() ? write_picture(part, all) : "");
    });
  return static_cast<int>(ExitCode::success);
}

}  // namespace trackbed::app
