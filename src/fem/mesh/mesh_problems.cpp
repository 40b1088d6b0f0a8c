#include "fem/mesh/mesh_problems.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "trackbed/core/error.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::fem {

namespace {

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Suggestion of a name; `none`: if there are no names.
std::string instead_of(const std::string& name, const std::vector<std::string>& names,
                       const std::string& none) {
  if (names.empty()) return none;
  const std::string near = input::nearest(name, names);
  return near.empty() ? fmt::format("known names: {}", fmt::join(names, ", "))
                      : fmt::format("did you mean {}?", near);
}

std::vector<std::string> names_of(const std::vector<MeshSolid>& solids) {
  std::vector<std::string> names;
  for (const MeshSolid& solid : solids) names.push_back(solid.name);
  return names;
}

std::vector<std::string> surfaces_of(const GroundParameters& parameters) {
  std::vector<std::string> names = {parameters.mesh_top};
  for (const MeshBorder& border : parameters.borders) names.push_back(border.name);
  return names;
}

}  // namespace

void MeshProblems::add(const std::string& kind, const std::string& sentence) {
  for (Kind& known : kinds_)
    if (known.name == kind) {
      ++known.count;
      return;
    }
  kinds_.push_back({kind, sentence, 1});
}

void MeshProblems::add(const std::string& kind, const GmshFile::Element& element,
                       std::string_view sentence) {
  add(kind, file_.where(element.line, fmt::format("element {} {}", element.tag, sentence)));
}

void MeshProblems::add(const std::string& kind, const GmshFile::Node& node,
                       std::string_view sentence) {
  add(kind, file_.where(node.line, fmt::format("node {} {}", node.tag, sentence)));
}

void MeshProblems::match(int dimension, const std::vector<std::string>& wanted, const char* what,
                         const char* table) {
  std::vector<std::string> there;
  for (const GmshFile::Group& group : file_.groups)
    if (group.dimension == dimension) there.push_back(group.name);
  for (const std::string& name : there)
    if (!has(wanted, name))
      add("group " + name,
          fmt::format("{}: the {} \"{}\" has no {} of that name; {}", file_.path, what, name, table,
                      instead_of(name, wanted, fmt::format("the deck defines no {}", table))));
  for (const std::string& name : wanted)
    if (!has(there, name))
      add("wanted " + name,
          fmt::format("{}: has no {} \"{}\", which the deck names; {}", file_.path, what, name,
                      instead_of(name, there, fmt::format("the file contains no {}", what))));
}

void MeshProblems::check_groups(const GroundParameters& parameters) {
  match(3, names_of(parameters.solids), "physical volume", "[[ground.solid]]");
  match(2, surfaces_of(parameters), "physical surface", "[[ground.border]]");
  if (file_.tetrahedra.empty()) add("empty", fmt::format("{}: has no tetrahedra", file_.path));
  const auto is_top = [&](const GmshFile::Element& triangle) {
    return triangle.group >= 0 &&
           file_.groups[static_cast<std::size_t>(triangle.group)].name == parameters.mesh_top;
  };
  if (kinds_.empty() && std::none_of(file_.triangles.begin(), file_.triangles.end(), is_top))
    add("no top", fmt::format("{}: the physical surface \"{}\" is empty: it must be the top of the "
                              "ground, at z = 0 (ground.mesh_top)",
                              file_.path, parameters.mesh_top));
}

const GmshFile::Group* MeshProblems::group_of(const GmshFile::Element& element, const char* what) {
  if (element.group >= 0) return &file_.groups[static_cast<std::size_t>(element.group)];
  if (element.group == GmshFile::several)
    add(fmt::format("several {}", what), element, fmt::format("is in more than one {}", what));
  else
    add(fmt::format("no {}", what), element, fmt::format("is in no {}", what));
  return nullptr;
}

// A group without solid is reported by check_groups.
int MeshProblems::solid_of(const GmshFile::Element& element, const GroundParameters& parameters) {
  const GmshFile::Group* group = group_of(element, "physical volume");
  for (std::size_t s = 0; group != nullptr && s < parameters.solids.size(); ++s)
    if (parameters.solids[s].name == group->name) return static_cast<int>(s);
  return 0;
}

int MeshProblems::border_of(const GmshFile::Element& element, const GroundParameters& parameters) {
  const GmshFile::Group* group = group_of(element, "physical surface");
  for (std::size_t b = 0; group != nullptr && b < parameters.borders.size(); ++b)
    if (parameters.borders[b].name == group->name) return static_cast<int>(b);
  return group == nullptr ? nowhere : -1;
}

void MeshProblems::raise() const {
  if (kinds_.empty()) return;
  std::vector<std::string> sentences;
  for (const Kind& kind : kinds_)
    sentences.push_back(
        kind.count == 1 ? kind.first : fmt::format("{} (and {} more)", kind.first, kind.count - 1));
  throw InputError(sentences);
}

}  // namespace trackbed::fem
