// What a ground from a mesh file asks of the rest of the deck.
#include <fmt/format.h>

#include "app/rules.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::app {

// Of layers the deck tells what a node of the top weighs, and so how long a window may be. Declared
// after the steps in time.
void declare_ground_mesh(const Model& model, input::Section& s) {
  const fem::GroundParameters& ground = model.ground;
  if (!ground.present || ground.mesh.empty()) return;
  s.rule("ground.mesh", model.dimension == Dimension::space, "needs dimension = \"space\"",
         {.reads = {"dimension", "ground.mesh"}});
  s.rule("time.window", model.time.window > 0,
         "must be given with ground.mesh: what its top's nodes weigh is not in the deck",
         {.reads = {"time.window", "ground.mesh"}});
}

// The box around the top: whether it has holes within is for the eye.
GroundFile require_ground(const Model& model, const input::Deck& deck) {
  constexpr double rounding = 1e-9;  // m
  if (!model.ground.present || model.ground.mesh.empty()) return {};
  const fem::MeshReport mesh = fem::look_at_mesh(model.ground);
  std::vector<std::string> problems;
  const auto below = [&](const char* axis, const std::vector<double>& bed, int a) {
    if (bed.size() == 2 &&
        (bed[0] < mesh.top_low[a] - rounding || bed[1] > mesh.top_high[a] + rounding))
      problems.push_back(
          fmt::format("{} = [{:g}, {:g}] reaches beyond the top of the mesh ({:g} to {:g} m): "
                      "stones would fall beside the ground",
                      deck.where(std::string("bed.") + axis), bed[0], bed[1], mesh.top_low[a],
                      mesh.top_high[a]));
  };
  if (model.has_stages()) below("x", model.bed.x, 0), below("y", model.bed.y, 1);
  if (!problems.empty()) throw InputError(problems);
  const auto from_to = [&](int a) {
    return fmt::format("{:g} to {:g}", mesh.low[a], mesh.high[a]);
  };
  return {fmt::format("  mesh: x = {}, y = {}, z = {} m, {:.6g} m^3", from_to(0), from_to(1),
                      from_to(2), mesh.volume),
          mesh.warnings};
}

}  // namespace trackbed::app
