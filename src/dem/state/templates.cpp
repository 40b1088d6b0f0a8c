// Shapes in flat arrays: one row for each template, the rest one after the other with counts for
// each template. Only corners, faces and radius of a piece are stored; edges, normals and triangles
// are derived by `convex_of`, so a file cannot be inconsistent in them. Numbers are doubles as they
// are in memory: a shape is bitwise identical after writing and reading.
#include "trackbed/dem/templates.hpp"

#include <algorithm>

#include "trackbed/core/error.hpp"

namespace trackbed::dem {

void save_templates(io::File& file, const std::string& group,
                    const std::vector<Template>& templates, const par::Comm& comm) {
  std::vector<double> solids, radii, corners;
  std::vector<std::int64_t> counts, sizes, loops;
  // The other ranks write no rows but take part in the collective call.
  for (const Template& t : templates) {
    if (!comm.root()) break;
    solids.insert(solids.end(),
                  {t.volume, t.gyration.x(), t.gyration.y(), t.gyration.z(), t.sieve});
    counts.push_back(static_cast<std::int64_t>(t.pieces.size()));
    for (const Piece& p : t.pieces) {
      radii.push_back(p.radius);
      sizes.insert(sizes.end(), {static_cast<std::int64_t>(p.core.vertices.size()),
                                 static_cast<std::int64_t>(p.core.faces.size())});
      for (const Vec3& v : p.core.vertices) corners.insert(corners.end(), {v.x(), v.y(), v.z()});
      for (const geom::Face& f : p.core.faces) {
        loops.push_back(static_cast<std::int64_t>(f.vertices.size()));
        loops.insert(loops.end(), f.vertices.begin(), f.vertices.end());
      }
    }
  }
  file.write<double>(
      group + "/solid", solids, 5,
      {"m3, m2, m2, m2, m",
       "volume (plane: area, m2), squared radii of gyration about x y z, sieve size"});
  file.write<std::int64_t>(group + "/pieces", counts, 1, {"-", "pieces of each template"});
  file.write<double>(group + "/radius", radii, 1, {"m", "rounding of each piece"});
  file.write<std::int64_t>(group + "/sizes", sizes, 2, {"-", "corners and faces of each piece"});
  file.write<double>(group + "/corners", corners, 3, {"m", "of the cores, piece after piece"});
  file.write<std::int64_t>(group + "/faces", loops, 1,
                           {"-", "for each face: number of corners, then corner indices"});
}

// Every rank reads all. Throws RunError if counts and lists are inconsistent, before anything is
// read beyond its end: libraries of shapes come from other sources.
std::vector<Template> load_templates(const io::File& file, const std::string& group) {
  const auto solids = file.read_all<double>(group + "/solid");
  const auto counts = file.read_all<std::int64_t>(group + "/pieces");
  const auto radii = file.read_all<double>(group + "/radius");
  const auto sizes = file.read_all<std::int64_t>(group + "/sizes");
  const auto corners = file.read_all<double>(group + "/corners");
  const auto loops = file.read_all<std::int64_t>(group + "/faces");
  const auto whole = [&](bool fits) {
    if (!fits)
      throw RunError(group +
                     ": the numbers of pieces, corners and faces of the stored shapes do not "
                     "agree: the file is damaged");
  };
  std::size_t corner = 0, loop = 0;
  const auto piece = [&](std::size_t p) {
    whole(p < radii.size() && 2 * p + 1 < sizes.size());
    std::vector<Vec3> vertices;
    std::vector<std::vector<int>> faces;
    for (std::int64_t n = 0; n < sizes[2 * p]; ++n, corner += 3) {
      whole(corner + 3 <= corners.size());
      vertices.push_back(Eigen::Map<const Vec3>(&corners[corner]));
    }
    for (std::int64_t n = 0; n < sizes[2 * p + 1]; ++n) {
      whole(loop < loops.size() && loops[loop] > 0);
      const auto first = loops.begin() + static_cast<std::ptrdiff_t>(loop) + 1;
      const std::int64_t count = loops[loop];
      whole(count < static_cast<std::int64_t>(loops.size() - loop));
      whole(std::all_of(first, first + count, [&](std::int64_t corner_of_face) {
        return corner_of_face >= 0 && corner_of_face < sizes[2 * p];
      }));
      faces.emplace_back(first, first + count);
      loop += 1 + static_cast<std::size_t>(count);
    }
    return Piece{geom::convex_of(std::move(vertices), faces), radii[p]};
  };
  whole(solids.size() == 5 * counts.size());
  std::vector<Template> templates;
  for (std::size_t k = 0, p = 0; k < counts.size(); ++k) {
    Template t;
    t.volume = solids[5 * k];
    t.gyration = {solids[5 * k + 1], solids[5 * k + 2], solids[5 * k + 3]};
    t.sieve = solids[5 * k + 4];
    whole(counts[k] > 0);
    for (std::int64_t n = 0; n < counts[k]; ++n, ++p) t.pieces.push_back(piece(p));
    templates.push_back(std::move(t));
  }
  return templates;
}

}  // namespace trackbed::dem
