// Meshes: reading, repair and refusal.
#include "trackbed/geom/mesh.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"
#include "unit/geom/bodies.hpp"

namespace trackbed::geom::mesh_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double rounding = 1e-12;

std::string obj(const Mesh& mesh) {
  std::string text = "# a comment\no body\n";
  for (const Vec3& p : mesh.vertices) text += fmt::format("v {} {} {}\n", p.x(), p.y(), p.z());
  for (const auto& [a, b, c] : mesh.triangles)
    text += fmt::format("f {} {}//1 {}\n", a + 1, b + 1, c + 1);
  return text;
}

std::string ply(const Mesh& mesh) {
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\n"
      "property double z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
      mesh.vertices.size(), mesh.triangles.size());
  for (const Vec3& p : mesh.vertices) text += fmt::format("{} {} {}\n", p.x(), p.y(), p.z());
  for (const auto& [a, b, c] : mesh.triangles) text += fmt::format("3 {} {} {}\n", a, b, c);
  return text;
}

std::string stl(const Mesh& mesh) {
  std::string text = "solid body\n";
  for (const auto& triangle : mesh.triangles) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const int v : triangle) {
      const Vec3& p = mesh.vertices[static_cast<std::size_t>(v)];
      text += fmt::format("vertex {} {} {}\n", p.x(), p.y(), p.z());
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid body\n";
}

std::string binary_stl(const Mesh& mesh) {
  std::string bytes(80, ' ');
  const auto put = [&](const auto value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes.append(raw, sizeof value);
  };
  put(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles) {
    for (int k = 0; k < 3; ++k) put(0.0f);
    for (const int v : triangle)
      for (int k = 0; k < 3; ++k)
        put(static_cast<float>(mesh.vertices[static_cast<std::size_t>(v)][k]));
    put(std::uint16_t{0});
  }
  return bytes;
}

std::string reason(const std::string& bytes, MeshFormat format = MeshFormat::obj) {
  try {
    import_mesh(bytes, format, 1, "stone.obj");
  } catch (const InputError& error) {
    EXPECT_EQ(error.problems().at(0).rfind("stone.obj: ", 0), 0u);
    return error.problems().at(0).substr(11);
  }
  return "accepted";
}

TEST(Solids, OfMeshes) {
  const Solid s = mesh_solid(letter());
  EXPECT_NEAR(s.volume, 5, rounding);
  EXPECT_NEAR((s.centre - Vec3(1.1, 0.5, 1.1)).norm(), 0, rounding);
  // About y: x^2 + z^2 by blocks, less the centre's.
  EXPECT_NEAR(s.gyration[2], 2 * (9 + 2.0 / 3) / 5 - 2 * 1.21, rounding);
  EXPECT_NEAR(surface_area(letter()), 22, rounding);
  const double r = 0.1;
  const Piece rounded{convex_hull(cube().vertices), r};
  const Mesh picture = surface_of(rounded, 8);
  EXPECT_NEAR(mesh_solid(picture).volume, piece_solid(rounded).volume, 0.01);
  EXPECT_LT(mesh_solid(picture).volume, piece_solid(rounded).volume);
}

TEST(Import, EveryFormatGivesTheSameBody) {
  const Mesh body = letter();
  const auto volume = [](const std::string& bytes, MeshFormat format) {
    const Import import = import_mesh(bytes, format, 0.001, "body");
    EXPECT_TRUE(import.repairs.empty());
    EXPECT_EQ(import.mesh.vertices.size(), 12u);
    EXPECT_EQ(import.mesh.triangles.size(), 20u);
    return mesh_solid(import.mesh).volume;
  };
  EXPECT_NEAR(volume(obj(body), MeshFormat::obj), 5e-9, 1e-20);
  EXPECT_NEAR(volume(ply(body), MeshFormat::ply), 5e-9, 1e-20);
  EXPECT_NEAR(volume(stl(body), MeshFormat::stl), 5e-9, 1e-20);
  EXPECT_NEAR(volume(binary_stl(body), MeshFormat::stl), 5e-9, 1e-20);
}

// Words of a comment or a name are not part of the format.
TEST(Import, SkipsCommentsAndNames) {
  const auto volume = [](std::string bytes, const std::string& after, const std::string& line,
                         MeshFormat format) {
    bytes.insert(bytes.find(after) + after.size(), line);
    return mesh_solid(import_mesh(bytes, format, 1, "body").mesh).volume;
  };
  const std::string text = ply(letter());
  for (const char* line :
       {"comment one format for all\n", "comment each element 3 rows\n", "comment\n",
        "comment property of nobody\n", "obj_info before end_header\r\n", "comment comment\r\n"}) {
    EXPECT_NEAR(volume(text, "ascii 1.0\n", line, MeshFormat::ply), 5, rounding) << line;
    EXPECT_NEAR(volume(text, "double z\n", line, MeshFormat::ply), 5, rounding) << line;
  }
  for (const char* name : {" my vertex model", " vertex"}) {
    EXPECT_NEAR(volume(stl(letter()), "solid body", name, MeshFormat::stl), 5, rounding) << name;
    EXPECT_NEAR(volume(stl(letter()), "endsolid body", name, MeshFormat::stl), 5, rounding) << name;
  }
}

TEST(Import, RepairsMinorDefects) {
  Mesh body = letter();
  for (auto& t : body.triangles) std::swap(t[0], t[1]);  // inside out
  EXPECT_GT(mesh_solid(import_mesh(obj(body), MeshFormat::obj, 1, "").mesh).volume, 4.999);
  body = letter();
  std::swap(body.triangles[3][0], body.triangles[3][1]);  // one facet
  body.triangles.push_back(body.triangles[5]);            // one twice
  const Import mixed = import_mesh(obj(body), MeshFormat::obj, 1, "");
  EXPECT_NEAR(mesh_solid(mixed.mesh).volume, 5, rounding);
  ASSERT_EQ(mixed.repairs.size(), 1u);
  EXPECT_EQ(mixed.repairs[0], "facets removed, because they have no area or are duplicates: 1");
  Mesh open = ball_mesh();
  open.triangles.pop_back();
  const Import closed = import_mesh(obj(open), MeshFormat::obj, 1, "");
  EXPECT_EQ(closed.mesh.triangles.size(), ball_mesh().triangles.size());
  EXPECT_EQ(closed.repairs.at(0), "small holes closed: 1");
  Mesh specks = letter();
  const auto first = static_cast<int>(specks.vertices.size());
  for (const Vec3& p : cube().vertices) specks.vertices.push_back(0.05 * p + Vec3(5, 0, 0));
  for (auto [a, b, c] : cube().triangles)
    specks.triangles.push_back({first + a, first + b, first + c});
  const Import clean = import_mesh(obj(specks), MeshFormat::obj, 1, "");
  EXPECT_NEAR(mesh_solid(clean.mesh).volume, 5, rounding);
  EXPECT_EQ(clean.repairs.at(0), "separate surfaces left out: 1 (each at most 1 % of the area)");
}

// Two triangles given as one facet that returns to a corner they share: it is split there.
TEST(Import, ReportsSplitFacets) {
  Mesh body = letter();
  const auto [a, b, c] = body.triangles[0];
  const auto [d, e, f] = body.triangles[4];
  ASSERT_EQ(a, d);
  body.triangles.erase(body.triangles.begin() + 4);
  body.triangles.erase(body.triangles.begin());
  const std::string text =
      obj(body) + fmt::format("f {} {} {} {} {} {}\n", a + 1, b + 1, c + 1, d + 1, e + 1, f + 1);
  const Import cut = import_mesh(text, MeshFormat::obj, 1, "");
  EXPECT_NEAR(mesh_solid(cut.mesh).volume, 5, rounding);
  ASSERT_EQ(cut.repairs.size(), 1u);
  EXPECT_EQ(cut.repairs[0], "self-touching facets were split, which gives 1 facets more");
}

TEST(Import, GivesTheReasonOfARefusal) {
  Mesh body = letter();
  body.triangles.resize(body.triangles.size() - 2);  // a side is missing
  EXPECT_NE(reason(obj(body)).find("not closed: a hole has a border of"), std::string::npos);
  body = cube();
  for (Vec3& p : body.vertices) p.z() = 0;
  EXPECT_EQ(reason(obj(body)), "the mesh is flat; use a scan of the whole stone");
  body = letter();
  body.vertices[4] = body.vertices[10] = Vec3(2, 0.5, -1);  // a corner through the far side
  EXPECT_EQ(reason(obj(body)),
            "the mesh intersects itself; repair it in a mesh editor, for example MeshLab");
  body = letter();
  for (const Vec3& p : cube().vertices) body.vertices.push_back(p + Vec3(5, 0, 0));
  for (auto [a, b, c] : cube().triangles) body.triangles.push_back({a + 12, b + 12, c + 12});
  EXPECT_EQ(reason(obj(body)), "the mesh has 2 separate surfaces; a file must contain one body");
  body = letter();
  body.triangles[0][0] = 99;
  EXPECT_NE(reason(obj(body)), "accepted");
  EXPECT_EQ(reason(ply(body), MeshFormat::ply), "a facet refers to a vertex that does not exist");
  body = letter();
  body.vertices[0].x() = 1e300;
  EXPECT_EQ(
      reason(obj(body)),
      "a coordinate is 1e+300 m; coordinates must be numbers of at most 1000 km in magnitude; "
      "is the length unit right?");
  EXPECT_NE(reason(""), "accepted");
  EXPECT_NE(reason("solid body\n", MeshFormat::stl), "accepted");
  const std::string whole = binary_stl(letter());
  EXPECT_NE(reason(whole.substr(0, whole.size() / 2), MeshFormat::stl), "accepted");
  EXPECT_NE(reason(obj(letter()), MeshFormat::ply), "accepted");
}

// Any bytes result in a mesh with a volume or in a reason.
TEST(Import, SurvivesDamagedFiles) {
  struct Sample {
    std::string bytes;
    MeshFormat format;
  };
  const std::vector<Sample> samples{{obj(letter()), MeshFormat::obj},
                                    {ply(letter()), MeshFormat::ply},
                                    {stl(letter()), MeshFormat::stl},
                                    {binary_stl(letter()), MeshFormat::stl}};
  int accepted = 0, refused = 0;
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    auto [bytes, format] = samples[seed % samples.size()];
    const auto draw = [&](std::uint64_t key, std::size_t below) {
      return static_cast<std::size_t>(uniform(seed, key) * static_cast<double>(below));
    };
    for (std::size_t k = 0; k < 1 + seed % 5; ++k)
      bytes[draw(2 * k, bytes.size())] = static_cast<char>(draw(2 * k + 1, 256));
    if (seed % 7 == 0) bytes.resize(draw(20, bytes.size()));
    if (seed % 11 == 0)
      bytes.insert(draw(21, bytes.size()), bytes.substr(draw(22, bytes.size()), 40));
    try {
      EXPECT_GT(mesh_solid(import_mesh(bytes, format, 1, "sample").mesh).volume, 0);
      ++accepted;
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(accepted, 30);
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace trackbed::geom::mesh_test
