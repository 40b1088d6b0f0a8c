// The part of [ground] that defines a mesh file and the meaning of its groups.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

using input::About;
using input::Section;

namespace {

// Index of the first name that occurs twice in a list of unique names, or -1.
template <class List>
int repeated(const List& list, std::set<std::string> names) {
  for (std::size_t i = 0; i < list.size(); ++i)
    if (!names.insert(list[i].name).second) return static_cast<int>(i);
  return -1;
}

template <class List>
void declare_once(const List& list, const std::string& key, const std::set<std::string>& taken,
                  Section& s) {
  const int again = repeated(list, taken);
  s.rule(fmt::format("{}[{}].name", key, std::max(again, 0)), again < 0,
         "is already the name of another part of the mesh; names must be unique", {.reads = {key}});
}

// Parameters of layers and elements have no effect on a mesh.
void refuse_layers(const GroundParameters& p, Section& s) {
  const GroundParameters common;
  const auto without = [&](const char* key, bool holds, const char* instead) {
    s.rule(key, holds, fmt::format("has no effect with ground.mesh; {}", instead),
           {.reads = {"mesh", key}});
  };
  const char* solids = "describe the volumes of the mesh by [[ground.solid]]";
  const char* borders = "describe the surfaces of the mesh by [[ground.border]]";
  const char* shape = "the file of the mesh defines the shape";
  without("layer", p.layers.empty(), solids);
  without("section", p.sections.empty(), shape);
  without("block", p.blocks.empty(), solids);
  without("base", p.base == common.base, borders);
  without("sides", p.sides == common.sides, borders);
  without("side_x_low", p.side_x_low == common.side_x_low, borders);
  without("side_x_high", p.side_x_high == common.side_x_high, borders);
  without("side_y_low", p.side_y_low == common.side_y_low, borders);
  without("side_y_high", p.side_y_high == common.side_y_high, borders);
  without("plane", p.plane == common.plane, "a mesh is for three-dimensional models");
  without("x", p.x == common.x, shape);
  without("y", p.y == common.y, shape);
  without("elements_x", p.elements_x == common.elements_x, shape);
  without("elements_y", p.elements_y == common.elements_y, shape);
  without("elements_z", p.elements_z == common.elements_z, shape);
  without("ratio_x", p.ratio_x == common.ratio_x, shape);
  without("ratio_y", p.ratio_y == common.ratio_y, shape);
}

}  // namespace

void MeshSolid::declare(Section& s) {
  s.text("name", name, "Name of the physical volume of the mesh.", {}, true);
  solid.declare(s);
  strength.declare(s);
}

void MeshBorder::declare(Section& s) {
  s.text("name", name, "Name of the physical surface of the mesh.", {}, true);
  s.choice("holds", holds, {"free", "fixed", "roller", "viscous"},
           "Boundary condition; free: none; fixed: held in all directions; roller: held along its "
           "normal; viscous: dashpots that absorb waves, and at the base the springs of "
           "base_stiffness.");
}

void GroundParameters::declare_mesh(Section& s) {
  auto fixed = s.fixed_by(input::state::any);
  s.file("mesh", mesh,
         "Gmsh file (ASCII, format 4.1 or 2.2) of 10-node tetrahedra, instead of layers and "
         "elements; each physical volume of the file needs a solid, each physical surface except "
         "mesh_top a border; empty: none.");
  s.text("mesh_top", mesh_top,
         "Name of the physical surface of the mesh that is the top of the ground (below stones, "
         "sleepers or pressures); it must be at z = 0.");
  fixed.end();
  s.tables("solid", solids, "Material of a physical volume of the mesh.");
  {
    const auto fixed_borders = s.fixed_by(input::state::moved_ground);
    s.tables("border", borders, "Boundary condition of a physical surface of the mesh.");
  }
  const About with_mesh{.reads = {"mesh", "mesh_top", "solid", "border"}};
  if (mesh.empty()) {
    s.rule("solid", solids.empty(), "has no effect without mesh", with_mesh);
    s.rule("border", borders.empty(), "has no effect without mesh", with_mesh);
    s.rule("mesh_top", mesh_top == GroundParameters().mesh_top, "has no effect without mesh",
           with_mesh);
    return;
  }
  declare_once(solids, "solid", {}, s);
  declare_once(borders, "border", {mesh_top}, s);
  // Whether the borders hold all rigid motions depends on the file (mesh_report.cpp).
  const bool held = std::any_of(borders.begin(), borders.end(), [](const MeshBorder& border) {
    return border.holds != BorderKind::free;
  });
  s.rule("border", held, "must hold the ground somewhere: all borders are free", with_mesh);
  refuse_layers(*this, s);
}

}  // namespace trackbed::fem
