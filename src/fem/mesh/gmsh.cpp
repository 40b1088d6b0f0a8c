// The sections of a mesh file, one function each. Both formats end in the same lists.
//
// Own reader: of libgmsh nothing else would be used, its errors have no line numbers, and it
// depends on CAD and GUI libraries (docs/decisions/ground_from_files.md).
#include "fem/mesh/gmsh.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>
#include <unordered_map>

#include "fem/mesh/gmsh_words.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

// Element types in the numbering of Gmsh.
struct Kind {
  int number, nodes, dimension;
  const char* name;
};
constexpr std::array kinds = {Kind{1, 2, 1, "2-node line"},
                              Kind{2, 3, 2, "3-node triangle"},
                              Kind{3, 4, 2, "4-node quadrangle"},
                              Kind{4, 4, 3, "4-node tetrahedron"},
                              Kind{5, 8, 3, "8-node hexahedron"},
                              Kind{6, 6, 3, "6-node prism"},
                              Kind{7, 5, 3, "5-node pyramid"},
                              Kind{8, 3, 1, "3-node line"},
                              Kind{9, 6, 2, "6-node triangle"},
                              Kind{10, 9, 2, "9-node quadrangle"},
                              Kind{11, 10, 3, "10-node tetrahedron"},
                              Kind{12, 27, 3, "27-node hexahedron"},
                              Kind{13, 18, 3, "18-node prism"},
                              Kind{14, 14, 3, "14-node pyramid"},
                              Kind{15, 1, 0, "point"},
                              Kind{16, 8, 2, "8-node quadrangle"},
                              Kind{17, 20, 3, "20-node hexahedron"},
                              Kind{18, 15, 3, "15-node prism"},
                              Kind{19, 13, 3, "13-node pyramid"},
                              Kind{20, 9, 2, "9-node triangle"},
                              Kind{21, 10, 2, "10-node triangle"},
                              Kind{26, 4, 1, "4-node line"},
                              Kind{29, 20, 3, "20-node tetrahedron"}};
constexpr int triangle = 9, tetrahedron = 11, linear_tetrahedron = 4;

// The order of mid-edge nodes in Gmsh is 01 12 02 03 23 13: the last two are swapped.
constexpr std::array<std::size_t, 10> place = {0, 1, 2, 3, 4, 5, 6, 7, 9, 8};

class Reader {
 public:
  Reader(const std::string& text, const std::string& path) : words_(text, path) {
    file_.path = path;
  }
  GmshFile read();

 private:
  void section(std::string_view name);
  void format();
  void names();
  void entities();
  void nodes_4(), elements_4(), nodes_2(), elements_2();
  void node(Id tag);
  void element(int kind, Id tag, std::size_t line, int group);
  const Kind& kind_of(Id number) const;
  int group(int dimension, Id signed_tag);
  int group_of_entity(int dimension, Id tag) const;
  void require_known() const;

  Words words_;
  GmshFile file_;
  bool old_ = false;  // 2.2
  bool has_format_ = false, has_nodes_ = false, has_elements_ = false;
  std::unordered_map<Id, std::int32_t> index_;  // of node tags
  std::map<std::pair<int, Id>, int> group_of_;  // dimension and tag: index
  std::map<std::pair<int, Id>, int> entity_;    // dimension and tag: group
  struct Refused {
    std::size_t count = 0, line = 0;
    Id tag = 0;
  };
  std::map<int, Refused> refused_;  // by kind
};

const Kind& Reader::kind_of(Id number) const {
  for (const Kind& kind : kinds)
    if (kind.number == number) return kind;
  words_.fail(fmt::format("{} is not a known element type", number));
}

// Gmsh numbers groups separately in each dimension. A minus sign at an entity or an element means
// that it is reversed, which is not used here: the tetrahedra define the outward direction.
int Reader::group(int dimension, Id signed_tag) {
  const Id tag = std::abs(std::max(signed_tag, -std::numeric_limits<Id>::max()));
  const auto [at, is_new] =
      group_of_.try_emplace({dimension, tag}, static_cast<int>(file_.groups.size()));
  if (is_new) file_.groups.push_back({dimension, static_cast<int>(tag), fmt::format("{}", tag)});
  return at->second;
}

int Reader::group_of_entity(int dimension, Id tag) const {
  const auto found = entity_.find({dimension, tag});
  return found == entity_.end() ? GmshFile::none : found->second;
}

void Reader::format() {
  const std::string_view version = words_.next();
  if (version != "4.1" && version != "2.2")
    words_.fail(
        fmt::format("format {} is not supported; save as 4.1 or 2.2 (in Gmsh: "
                    "Mesh.MshFileVersion = 4.1)",
                    version.substr(0, 12)));
  old_ = version == "2.2";
  if (words_.integer("0 for ASCII") != 0)
    words_.fail("the file is binary; save it as ASCII (in Gmsh: Mesh.Binary = 0)");
  words_.integer("the size of a number");
  has_format_ = true;
}

void Reader::names() {
  for (std::size_t n = words_.count("physical names"); n > 0; --n) {
    const Id dimension = words_.integer("the dimension of a group");
    const Id tag = words_.integer("a tag of a physical group");
    if (dimension < 0 || dimension > 3)
      words_.fail(fmt::format("the dimension of a group must be 0 to 3, not {}", dimension));
    const auto at = static_cast<std::size_t>(group(static_cast<int>(dimension), tag));
    file_.groups[at].name = words_.quoted();
  }
}

// A point has a position, other entities a bounding box; each has a list of its bounding entities.
void Reader::entities() {
  std::array<std::size_t, 4> counts{};
  for (std::size_t& count : counts) count = words_.count("entities");
  for (int dimension = 0; dimension < 4; ++dimension)
    for (std::size_t n = counts[static_cast<std::size_t>(dimension)]; n > 0; --n) {
      const Id tag = words_.integer("an entity tag");
      for (int k = dimension == 0 ? 3 : 6; k > 0; --k) words_.number("a position");
      const std::size_t groups = words_.count("physical groups");
      for (std::size_t k = 0; k < groups; ++k) {
        const int in = group(dimension, words_.integer("a tag of a physical group"));
        entity_[{dimension, tag}] = groups == 1 ? in : GmshFile::several;
      }
      if (dimension == 0) continue;
      for (std::size_t k = words_.count("bounding entities"); k > 0; --k)
        words_.integer("an entity tag");
    }
}

void Reader::node(Id tag) {
  const std::size_t line = words_.line();
  Vec3 at;
  for (double& x : at) x = words_.number("a coordinate");
  if (!index_.try_emplace(tag, static_cast<std::int32_t>(file_.nodes.size())).second)
    words_.fail(fmt::format("node {} is given twice", tag));
  file_.nodes.push_back({tag, at, line});
}

// Blocks of node numbers, then of coordinates.
void Reader::nodes_4() {
  const std::size_t blocks = words_.count("blocks of nodes");
  const std::size_t total = words_.count("nodes");
  words_.integer("the lowest node tag"), words_.integer("the highest node tag");
  std::vector<Id> tags;
  for (std::size_t b = 0; b < blocks; ++b) {
    const Id dimension = words_.integer("a dimension");
    words_.integer("an entity tag");
    const bool parametric = words_.integer("0 or 1") != 0;
    tags.resize(words_.count("nodes"));
    for (Id& tag : tags) tag = words_.integer("a node tag");
    for (const Id tag : tags) {
      node(tag);
      for (Id k = 0; parametric && k < std::min<Id>(dimension, 3); ++k) words_.number("a number");
    }
  }
  if (file_.nodes.size() != total)
    words_.fail(fmt::format("{} nodes are declared, {} are given", total, file_.nodes.size()));
}

void Reader::nodes_2() {
  for (std::size_t n = words_.count("nodes"); n > 0; --n) node(words_.integer("a node tag"));
}

// Reads the nodes of one element.
void Reader::element(int number, Id tag, std::size_t line, int group) {
  const Kind& kind = kind_of(number);
  GmshFile::Element found{tag, line, group, {}};
  const bool kept = number == triangle || number == tetrahedron;
  for (int k = 0; k < kind.nodes; ++k) {
    const Id name = words_.integer("a node tag");
    const auto node = index_.find(name);
    if (node == index_.end())
      words_.fail(fmt::format("element {} has a node {}, which is not in $Nodes", tag, name));
    if (kept) found.nodes[place[static_cast<std::size_t>(k)]] = node->second;
  }
  if (kept) {
    (number == triangle ? file_.triangles : file_.tetrahedra).push_back(found);
  } else if (kind.dimension > 1) {
    Refused& refused = refused_[number];
    if (refused.count++ == 0) refused.line = line, refused.tag = tag;
  }
}

void Reader::elements_4() {
  const std::size_t blocks = words_.count("blocks of elements");
  const std::size_t total = words_.count("elements");
  words_.integer("the lowest element tag");
  words_.integer("the highest element tag");
  std::size_t read = 0;
  for (std::size_t b = 0; b < blocks; ++b) {
    words_.integer("a dimension");
    const Id entity = words_.integer("an entity tag");
    const Kind& kind = kind_of(words_.integer("an element type"));
    const std::size_t count = words_.count("elements");
    read += count;
    for (std::size_t n = 0; n < count; ++n) {
      const Id tag = words_.integer("an element tag");
      element(kind.number, tag, words_.line(), group_of_entity(kind.dimension, entity));
    }
  }
  if (read != total)
    words_.fail(fmt::format("{} elements are declared, {} are given", total, read));
}

// The first tag of an element is its physical group, 0 for none.
void Reader::elements_2() {
  for (std::size_t n = words_.count("elements"); n > 0; --n) {
    const Id tag = words_.integer("an element tag");
    const std::size_t line = words_.line();
    const Kind& kind = kind_of(words_.integer("an element type"));
    int in = GmshFile::none;
    const std::size_t tags = words_.count("tags");
    for (std::size_t k = 0; k < tags; ++k) {
      const Id value = words_.integer("a tag");
      if (k == 0 && value != 0) in = group(kind.dimension, value);
    }
    element(kind.number, tag, line, in);
  }
}

void Reader::section(std::string_view name) {
  const std::size_t begin = words_.line();
  const std::string end = "$End" + std::string(name.substr(1));
  const bool known = name == "$MeshFormat" || name == "$PhysicalNames" || name == "$Nodes" ||
                     name == "$Elements" || (name == "$Entities" && !old_);
  if (!known) return words_.skip_to(end, begin);
  if (name != "$MeshFormat" && !has_format_) words_.fail("$MeshFormat must come first");
  if (name == "$MeshFormat") format();
  if (name == "$PhysicalNames") names();
  if (name == "$Entities") entities();
  if (name == "$Nodes") old_ ? nodes_2() : nodes_4();
  if (name == "$Elements") old_ ? elements_2() : elements_4();
  has_nodes_ = has_nodes_ || name == "$Nodes";
  has_elements_ = has_elements_ || name == "$Elements";
  words_.expect(end);
}

// One message per element type, with its first element.
void Reader::require_known() const {
  std::vector<std::string> problems;
  for (const auto& [number, first] : refused_) {
    const Kind& kind = kind_of(number);
    std::string why =
        "a ground from a file consists of 10-node tetrahedra and their 6-node faces "
        "(in Gmsh: Mesh.ElementOrder = 2, no recombination)";
    if (number == linear_tetrahedron)
      why =
          "linear tetrahedra lock in bending and near incompressibility; use 10-node ones (in "
          "Gmsh: Mesh.ElementOrder = 2)";
    problems.push_back(file_.where(
        first.line,
        fmt::format("element {} is of type {}{}: {}", first.tag, kind.name,
                    first.count > 1 ? fmt::format(" (the first of {})", first.count) : "", why)));
  }
  if (!problems.empty()) throw InputError(problems);
}

GmshFile Reader::read() {
  while (words_.more()) {
    const std::string_view name = words_.next();
    if (!name.starts_with("$") || name.size() < 2)
      words_.fail("a section such as $Nodes is expected here; is this a mesh file of Gmsh?");
    section(name);
  }
  if (!has_format_ || !has_nodes_ || !has_elements_)
    words_.fail(fmt::format("the file has no {}; is it a complete mesh file of Gmsh?",
                            !has_format_  ? "$MeshFormat"
                            : !has_nodes_ ? "$Nodes"
                                          : "$Elements"));
  require_known();
  return std::move(file_);
}

}  // namespace

std::string GmshFile::where(std::size_t line, std::string_view sentence) const {
  return fmt::format("{}:{}: {}", path, line, sentence);
}

GmshFile parse_gmsh(const std::string& text, const std::string& path) {
  return Reader(text, path).read();
}

GmshFile read_gmsh(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) throw InputError({fmt::format("{}: cannot be read", path)});
  return parse_gmsh(text.str(), path);
}

}  // namespace trackbed::fem
