// Facets as a mesh file lists them; only the indices have been checked.
#pragma once

#include <string_view>
#include <vector>

#include "trackbed/geom/mesh.hpp"

namespace trackbed::geom {

// Points need not be shared between facets (STL never does), and their order is arbitrary.
struct Soup {
  std::vector<Vec3> points;  // in units of the file
  std::vector<std::vector<std::size_t>> polygons;
};

// Throw std::invalid_argument with the reason. STL and PLY: text or binary.
Soup read_soup(std::string_view bytes, MeshFormat format);
Soup read_ply(std::string_view bytes);

// Words and numbers of a text, one after the other. Views into the text, which must outlive them.
// The decimal mark is a point whatever the locale.
class Words {
 public:
  explicit Words(std::string_view text) : text_(text) {}
  std::string_view next();  // empty at the end
  double number();
  void skip_line();  // the rest of the line
  std::string_view rest() const { return text_; }

 private:
  std::string_view text_;
};
double number_of(std::string_view word);

}  // namespace trackbed::geom
