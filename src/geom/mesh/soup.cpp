// Mesh files as facets: OBJ and STL, and functions shared with PLY. CGAL has readers for all three,
// but its PLY reader crashes on damaged files.
//
// The files come from other sources, so every byte may be wrong: sizes are compared before bytes
// are read, indices before they are used, and numbers must be valid to their last character.
// Content beyond positions and facets (normals, colours, textures) is skipped: normals follow from
// the order of the corners, and those in files are often wrong.
#include "geom/mesh/soup.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cstring>
#include <stdexcept>

#include "geom/convex/refusal.hpp"

namespace trackbed::geom {

namespace {

// `word` of a face is v, v/vt, v//vn or v/vt/vn; negative numbers count from the end. Only vertices
// above the line can be referred to, so that negative numbers are well defined.
std::size_t obj_index(std::string_view word, std::size_t points) {
  const double given = number_of(word.substr(0, word.find('/')));
  const double index = given < 0 ? given + static_cast<double>(points) : given - 1;
  if (!(index >= 0 && index < static_cast<double>(points)))
    refuse("a facet refers to a vertex that does not exist");
  return static_cast<std::size_t>(index);
}

// Line by line, since a facet ends with its line.
Soup read_obj(std::string_view bytes) {
  Soup soup;
  while (!bytes.empty()) {
    const std::size_t end = std::min(bytes.find('\n'), bytes.size());
    Words line(bytes.substr(0, end));
    bytes.remove_prefix(std::min(end + 1, bytes.size()));
    const std::string_view key = line.next();
    if (key == "v") {
      const double x = line.number(), y = line.number();
      soup.points.emplace_back(x, y, line.number());
    } else if (key == "f") {
      soup.polygons.emplace_back();
      for (auto word = line.next(); !word.empty(); word = line.next())
        soup.polygons.back().push_back(obj_index(word, soup.points.size()));
    }
  }
  return soup;
}

// STL repeats each corner in every facet; equal points are merged when the facets are joined.
void add_corner(Soup& soup, const Vec3& corner) {
  if (soup.points.size() % 3 == 0) soup.polygons.emplace_back();
  soup.polygons.back().push_back(soup.points.size());
  soup.points.push_back(corner);
}

// Only `vertex` counts: the words around it differ between programs. A name, up to the end of its
// line, may contain any word.
Soup read_stl_text(std::string_view bytes) {
  Soup soup;
  Words words(bytes);
  for (auto word = words.next(); !word.empty(); word = words.next()) {
    if (word == "solid" || word == "endsolid") words.skip_line();
    if (word != "vertex") continue;
    const double x = words.number(), y = words.number();
    add_corner(soup, {x, y, words.number()});
  }
  if (soup.points.size() % 3 != 0) refuse("the last facet is not complete");
  return soup;
}

constexpr std::size_t stl_head = 84, stl_facet = 50;  // bytes

// The number of facets follows a header of 80 bytes; a text of exactly this length is unlikely. The
// first word does not identify the format: binary headers that begin with "solid" are common.
bool is_binary_stl(std::string_view bytes) {
  if (bytes.size() < stl_head) return false;
  std::uint32_t facets = 0;
  std::memcpy(&facets, bytes.data() + 80, sizeof facets);
  return bytes.size() == stl_head + stl_facet * std::size_t{facets};
}

// Little-endian by the format, and read without conversion: hosts are assumed to be little-endian.
Soup read_stl_binary(std::string_view bytes) {
  Soup soup;
  for (std::size_t at = stl_head; at < bytes.size(); at += stl_facet)
    for (std::size_t k = 0; k < 3; ++k) {
      float corner[3];  // after the normal
      std::memcpy(corner, bytes.data() + at + 12 * (k + 1), sizeof corner);
      add_corner(soup, Vec3(corner[0], corner[1], corner[2]));
    }
  return soup;
}

}  // namespace

// A '+' is valid in files but not to from_chars.
double number_of(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty() || error != std::errc() || end != word.data() + word.size())
    refuse("the file is cut short, or a number is not valid");
  return value;
}

std::string_view Words::next() {
  constexpr std::string_view blank = " \t\r\n\v\f";
  text_.remove_prefix(std::min(text_.find_first_not_of(blank), text_.size()));
  const std::string_view word = text_.substr(0, text_.find_first_of(blank));
  text_.remove_prefix(word.size());
  return word;
}

// A carriage return ends a line, too, as some programs write it alone.
void Words::skip_line() {
  text_.remove_prefix(std::min(text_.find_first_of("\r\n"), text_.size()));
}

double Words::number() { return number_of(next()); }

Soup read_soup(std::string_view bytes, MeshFormat format) {
  Soup soup;
  switch (format) {
    case MeshFormat::obj:
      soup = read_obj(bytes);
      break;
    case MeshFormat::ply:
      soup = read_ply(bytes);
      break;
    case MeshFormat::stl:
      soup = is_binary_stl(bytes) ? read_stl_binary(bytes) : read_stl_text(bytes);
  }
  if (soup.polygons.empty()) refuse("the mesh has no facets");
  for (const auto& polygon : soup.polygons)
    if (polygon.size() < 3) refuse("a facet has less than three corners");
  return soup;
}

}  // namespace trackbed::geom
