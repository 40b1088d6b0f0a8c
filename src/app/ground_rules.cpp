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
void require_ground(const Model& model, const input::Deck& deck) {
  constexpr double rounding = 1e-9;  // m
  if (!model.ground.present || model.ground.mesh.empty()) return;
  const fem::TopBounds top = fem::top_of_mesh(model.ground);
  std::vector<std::string> problems;
  const auto below = [&](const char* axis, const std::vector<double>& bed, int a) {
    if (bed.size() == 2 && (bed[0] < top.low[a] - rounding || bed[1] > top.high[a] + rounding))
      problems.push_back(fmt::format(
          "{} = [{:g}, {:g}] reaches beyond the top of the mesh ({:g} to {:g} m): "
          "stones would fall beside the ground",
          deck.where(std::string("bed.") + axis), bed[0], bed[1], top.low[a], top.high[a]));
  };
  below("x", model.bed.x, 0);
  below("y", model.bed.y, 1);
  if (!problems.empty()) throw InputError(problems);
}

}  // namespace trackbed::app
