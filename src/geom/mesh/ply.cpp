// PLY files: a header that describes the content, then rows of numbers, as text or binary.
//
// The header lists elements (vertex, face, others), each with a number of rows and its properties;
// the rows follow in that order without any mark between them. So every property has to be read,
// also those that are not used. Vertices must precede the faces that refer to them.
#include <bit>
#include <cstring>
#include <stdexcept>
#include <string>

#include "geom/convex/refusal.hpp"
#include "geom/mesh/soup.hpp"

namespace trackbed::geom {

namespace {

enum class Number { i8, u8, i16, u16, i32, u32, f32, f64 };

Number number_named(std::string_view name) {
  if (name == "char" || name == "int8") return Number::i8;
  if (name == "uchar" || name == "uint8") return Number::u8;
  if (name == "short" || name == "int16") return Number::i16;
  if (name == "ushort" || name == "uint16") return Number::u16;
  if (name == "int" || name == "int32") return Number::i32;
  if (name == "uint" || name == "uint32") return Number::u32;
  if (name == "float" || name == "float32") return Number::f32;
  if (name == "double" || name == "float64") return Number::f64;
  refuse("the file header has a property of unknown type; save the mesh as STL or OBJ");
}

struct Property {
  std::string_view name;
  Number type;
  bool list;
  Number count;  // of a list
};

struct Element {
  std::string_view name;
  // As a number, since a damaged header may contain anything; compared, never used as a size.
  double rows;
  std::vector<Property> properties;
};

struct Head {
  std::vector<Element> elements;
  bool text = true, swapped = false;
};

Property property_of(Words& words) {
  const std::string_view type = words.next();
  if (type != "list") return {words.next(), number_named(type), false, Number::u8};
  const Number count = number_named(words.next()), item = number_named(words.next());
  return {words.next(), item, true, count};
}

Head read_head(Words& words) {
  Head head;
  if (words.next() != "ply") refuse("the file does not begin with the word ply");
  for (auto key = words.next(); key != "end_header"; key = words.next()) {
    if (key.empty()) refuse("the file header has no end_header");
    if (key == "format") {
      const std::string_view format = words.next();
      head.text = format == "ascii";
      const auto order = format == "binary_big_endian" ? std::endian::big : std::endian::little;
      head.swapped = order != std::endian::native;
    } else if (key == "element") {
      const std::string_view name = words.next();
      head.elements.push_back({name, words.number(), {}});
    } else if (key == "property") {
      if (head.elements.empty()) refuse("the file header has a property before any element");
      head.elements.back().properties.push_back(property_of(words));
    } else {
      words.skip_line();  // a comment, which may contain words of the format
    }
  }
  return head;
}

// Reads the rows number by number. All types are converted to double: 32-bit integers fit exactly.
class Rows {
 public:
  Rows(std::string_view bytes, const Head& head)
      : words_(bytes), bytes_(bytes), text_(head.text), swapped_(head.swapped) {
    bytes_.remove_prefix(std::min(bytes_.find('\n') + 1, bytes_.size()));  // of end_header
  }
  double next(Number type) {
    // In text the type has no effect.
    if (text_) return words_.number();
    switch (type) {
      case Number::i8:
        return raw<std::int8_t>();
      case Number::u8:
        return raw<std::uint8_t>();
      case Number::i16:
        return raw<std::int16_t>();
      case Number::u16:
        return raw<std::uint16_t>();
      case Number::i32:
        return raw<std::int32_t>();
      case Number::u32:
        return raw<std::uint32_t>();
      case Number::f32:
        return raw<float>();
      default:
        return raw<double>();
    }
  }

 private:
  template <class T>
  double raw() {
    if (bytes_.size() < sizeof(T)) refuse("the file is cut short");
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes_.data(), sizeof(T));
    if (swapped_) std::reverse(raw.begin(), raw.end());
    bytes_.remove_prefix(sizeof(T));
    return static_cast<double>(std::bit_cast<T>(raw));
  }
  Words words_;
  std::string_view bytes_;
  bool text_, swapped_;
};

// Items of a property in one row; a plain number is a list of one. The count is compared as a
// number, so that a negative one or one that is not a number is an empty list; for a huge one
// reading stops at the end of the file.
std::vector<double> items(const Property& property, Rows& rows) {
  const double count = property.list ? rows.next(property.count) : 1;
  std::vector<double> values;
  while (static_cast<double>(values.size()) < count) values.push_back(rows.next(property.type));
  return values;
}

// An element of another name may have properties x, y, z too: they are read and ignored.
void read_row(const Element& element, Rows& rows, Soup& soup) {
  Vec3 point = Vec3::Zero();
  std::vector<std::size_t> polygon;
  for (const Property& property : element.properties) {
    const std::vector<double> values = items(property, rows);
    if (!property.list && property.name.size() == 1 && property.name[0] >= 'x' &&
        property.name[0] <= 'z')
      point[property.name[0] - 'x'] = values[0];
    if (property.name != "vertex_indices" && property.name != "vertex_index") continue;
    for (const double v : values) {
      if (!(v >= 0 && v < static_cast<double>(soup.points.size())))
        refuse("a facet refers to a vertex that does not exist");
      polygon.push_back(static_cast<std::size_t>(v));
    }
  }
  if (element.name == "vertex") soup.points.push_back(point);
  if (element.name == "face") soup.polygons.push_back(polygon);
}

}  // namespace

// An element without properties has rows of no bytes, which are skipped: reading them would only
// count, perhaps for ever.
Soup read_ply(std::string_view bytes) {
  Words words(bytes);
  const Head head = read_head(words);
  Rows rows(words.rest(), head);
  Soup soup;
  for (const Element& element : head.elements)
    for (double row = 0; row < element.rows && !element.properties.empty(); ++row)
      read_row(element, rows, soup);
  return soup;
}

}  // namespace trackbed::geom
