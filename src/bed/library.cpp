// Shapes come from three sources (meshes, parameters, files) and become templates with a name. All
// their errors are errors of the input: geometry throws std::invalid_argument without a name, which
// is added here.
#include "trackbed/bed/library.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "mix.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/dem/templates.hpp"
#include "trackbed/geom/mesh.hpp"
#include "trackbed/io/replace.hpp"

namespace trackbed::bed {

namespace {

namespace fs = std::filesystem;

constexpr std::int64_t library_format = 1;
constexpr double smallest_stone = 1e-3, largest_stone = 1;  // m, for ballast

// By the file name extension, in any case; the content is checked when it is parsed.
geom::MeshFormat format_of(const std::string& file) {
  std::string ending = fs::path(file).extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (ending == ".stl") return geom::MeshFormat::stl;
  if (ending == ".ply") return geom::MeshFormat::ply;
  if (ending == ".obj") return geom::MeshFormat::obj;
  throw InputError({file + ": a mesh file must end in .stl, .ply or .obj"});
}

// Reads the bytes of a file; returns why it cannot be read, or nothing. On one rank.
std::string why_no_bytes(const std::string& file, std::ostringstream& bytes) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return "does not exist";
  if (fs::is_directory(file, ignored)) return "is a folder";
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return fmt::format("cannot be read ({})", std::strerror(errno));
  return bytes << stream.rdbuf() ? "" : "is empty";
}

// Rank 0 reads and broadcasts. Collective. Every rank generates the same shape from the same bytes,
// without further communication.
std::string bytes_of(const par::Comm& comm, const std::string& file) {
  std::ostringstream bytes;
  const std::string problem = comm.broadcast(comm.root() ? why_no_bytes(file, bytes) : "");
  if (!problem.empty()) throw InputError({file + ": " + problem});
  return comm.broadcast(bytes.str());
}

// m, of the sphere of this volume, the reference length of the rounding.
double diameter(double volume) { return std::cbrt(6 * volume / std::numbers::pi); }

// All pieces have the same radius, so that the rounded stone has no steps between them.
std::vector<geom::Piece> rounded_pieces(const geom::Mesh& mesh, const MeshShape& wanted,
                                        double radius, std::vector<std::string>& notes) {
  std::vector<geom::Piece> pieces;
  const auto made = geom::decompose(mesh, wanted.pieces, wanted.vertices);
  for (const geom::Convex& hull : made.pieces) pieces.push_back(geom::rounded(hull, radius));
  notes.push_back(fmt::format("the volume of {} hull{} differs from that of the mesh by {:+.2f} %",
                              pieces.size(), pieces.size() > 1 ? "s" : "",
                              100 * made.volume_error));
  return pieces;
}

std::vector<geom::Piece> spheres_in(const geom::Mesh& mesh, int spheres,
                                    std::vector<std::string>& notes) {
  std::vector<geom::Piece> pieces;
  const geom::Clump made = geom::clump(mesh, spheres);
  for (const geom::Sphere& s : made.spheres) pieces.push_back(geom::ball(s.centre, s.radius));
  notes.push_back(
      fmt::format("the volume of {} spheres differs from that of the mesh by {:+.2f} %, their "
                  "surface by {:.3g} mm in the mean and {:.3g} mm at most",
                  pieces.size(), 100 * made.volume_error, 1e3 * made.surface_error,
                  1e3 * made.surface_furthest));
  return pieces;
}

}  // namespace

std::vector<dem::Template> templates(const par::Comm& comm, const BedParameters& parameters,
                                     Dimension dimension) {
  return Mix(parameters, dimension, library_of(comm, parameters)).templates();
}

std::vector<dem::Template> library_of(const par::Comm& comm, const BedParameters& parameters) {
  if (parameters.stone != StoneKind::library) return {};
  std::vector<dem::Template> shapes;
  for (NamedShape& named : load_library(comm, parameters.library)) {
    // Contacts require rounded stones; libraries of other programs may contain others.
    for (const geom::Piece& piece : named.shape.pieces)
      if (!(piece.radius > 0))
        throw InputError(
            {fmt::format("{}: shape {} has edges without rounding, but contacts need rounded "
                         "edges; create the library with --rounding above 0",
                         parameters.library, named.name)});
    shapes.push_back(std::move(named.shape));
  }
  if (shapes.empty()) throw InputError({parameters.library + ": contains no shapes"});
  return shapes;
}

// Mass properties are those of the mesh, not of the pieces, which only represent its surface. The
// sieve size is that of the pieces, on which contacts act.
NamedShape shape_of_mesh(const par::Comm& comm, const std::string& file, const MeshShape& wanted) {
  const geom::MeshFormat format = format_of(file);
  const geom::Import import = geom::import_mesh(bytes_of(comm, file), format, wanted.unit, file);
  NamedShape named{fs::path(file).stem().string(), {}, import.repairs};
  const geom::Solid solid = geom::mesh_solid(import.mesh);
  // Most scans are in millimetres, which the file does not state.
  if (const double size = diameter(solid.volume); size > largest_stone || size < smallest_stone)
    named.notes.push_back(
        fmt::format("warning: the equivalent diameter is {:.3g} m (usual: {:g} to {:g} m); is "
                    "--unit right (0.001 for a file in mm)?",
                    size, smallest_stone, largest_stone));
  try {
    const double radius = wanted.rounding * diameter(solid.volume);
    const auto pieces = wanted.spheres > 0
                            ? spheres_in(import.mesh, wanted.spheres, named.notes)
                            : rounded_pieces(import.mesh, wanted, radius, named.notes);
    named.shape = geom::template_of(pieces, solid, geom::smallest_hole(pieces));
    named.axes = solid.axes;
  } catch (const std::invalid_argument& problem) {
    throw InputError({file + ": " + problem.what()});
  }
  return named;
}

// Local: depends on the seed alone.
NamedShape parametric_shape(const geom::StoneShape& stone, double rounding, std::uint64_t seed) {
  try {
    return {fmt::format("stone_{}", seed),
            geom::template_of({geom::rounded_stone(stone, rounding, seed)}),
            {}};
  } catch (const std::invalid_argument& problem) {
    throw InputError({fmt::format("stone with seed {}: {}", seed, problem.what())});
  }
}

// Names are stored in a dataset, since HDF5 attributes are limited to 64 kB. Rank 0 writes them.
void save_library(const par::Comm& comm, const std::string& file,
                  const std::vector<NamedShape>& shapes) {
  std::vector<dem::Template> templates;
  std::string names;
  for (const NamedShape& named : shapes) {
    templates.push_back(named.shape);
    names += named.name + "\n";
  }
  io::replace_file(comm, file, [&](const std::string& part) {
    io::File library(comm, part, io::Mode::create);
    library.attribute("/", "kind", "shapes");
    library.attribute("/", "version", library_format);
    const std::vector<std::uint8_t> letters(names.begin(),
                                            comm.root() ? names.end() : names.begin());
    library.write<std::uint8_t>("shapes/names", letters, 1,
                                {"-", "name of each shape, UTF-8, each with a line feed"});
    dem::save_templates(library, "shapes", templates, comm);
    library.close();
  });
}

namespace {

// Rejects values that no body can have, before they cause errors in a run. Mass properties are
// those of the scan, not of its pieces, and may slightly exceed those of the bounding sphere.
void require_possible(const NamedShape& named) {
  constexpr double beyond = 1.5;  // of the radius
  const dem::Template& shape = named.shape;
  const auto possible = [](double value, double most) { return value > 0 && value <= most; };
  bool finite = true;
  for (const geom::Piece& piece : shape.pieces) {
    finite = finite && piece.radius >= 0 && std::isfinite(piece.radius);
    for (const Vec3& corner : piece.core.vertices) finite = finite && corner.allFinite();
  }
  const double ball = finite ? beyond * geom::bounding_radius(shape) : 0;
  const double volume = 4 * std::numbers::pi / 3 * ball * ball * ball;
  if (!finite || !possible(shape.volume, volume) || !possible(shape.sieve, 2 * ball) ||
      !possible(shape.gyration.minCoeff(), ball * ball) ||
      !possible(shape.gyration.maxCoeff(), ball * ball))
    throw RunError(fmt::format("shape {} has an impossible size, volume or inertia", named.name));
}

std::vector<NamedShape> shapes_in(const io::File& library) {
  std::vector<NamedShape> shapes;
  const auto letters = library.read_all<std::uint8_t>("shapes/names");
  std::istringstream names(std::string(letters.begin(), letters.end()));
  for (dem::Template& shape : dem::load_templates(library, "shapes")) {
    NamedShape named{"", std::move(shape), {}};
    std::getline(names, named.name);
    require_possible(named);
    shapes.push_back(std::move(named));
  }
  return shapes;
}

}  // namespace

// Any failure but another version means that the file is not a library. Messages of the file's
// reader begin with rank and file, which are removed here because the sentence names the file
// already.
std::vector<NamedShape> load_library(const par::Comm& comm, const std::string& file) {
  std::int64_t version = library_format;
  try {
    const io::File library(comm, file, io::Mode::read);
    if (const std::string kind = library.text_attribute("/", "kind"); kind != "shapes")
      throw RunError(fmt::format("its kind is \"{}\"", kind));
    version = library.integer_attribute("/", "version");
    if (version == library_format) return shapes_in(library);
  } catch (const std::exception& problem) {  // the same on all ranks
    const std::string words = problem.what(), start = file + ": ";
    const std::size_t at = words.find(start);
    const std::string why = at == std::string::npos ? words : words.substr(at + start.size());
    throw InputError({fmt::format(
        "{}: is not a library of shapes ({}); create one with `trackbed shapes ... --library FILE`",
        file, why)});
  }
  throw InputError(
      {fmt::format("{}: is a library of version {}, but this program reads version {}; create it "
                   "again with `trackbed shapes ... --library FILE`",
                   file, version, library_format)});
}

// Only a library may be replaced by a library, so that a mistyped name does not overwrite another
// file.
void require_replaceable(const par::Comm& comm, const std::string& file) {
  std::error_code ignored;
  const bool there = comm.root() && fs::exists(file, ignored);
  if (comm.broadcast(there ? "there" : "").empty()) return;
  try {
    load_library(comm, file);
  } catch (const InputError&) {  // the same on all ranks
    throw InputError({file + ": exists, but is not a library of shapes that this program reads; "
                             "move this file or choose another name"});
  }
}

}  // namespace trackbed::bed
