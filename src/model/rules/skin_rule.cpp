// The limits are wide: the skin affects only the speed, not the results. The skin chosen by the
// program is 0.15 to 0.3 of the smallest radius.
#include "model/rules/skin_rule.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace trackbed::model {

// With a skin above a diameter, lists include stones behind the neighbours, and the whole bed if
// the skin is in mm; with a skin of a thousandth of a radius they are outdated in each sub-step.
void declare_skin(const Model& model, double smallest, double largest, input::Section& s) {
  const double skin = model.dem.skin;
  s.rule(
      "dem.skin", skin == 0 || (skin >= 5e-4 * smallest && skin <= largest),
      fmt::format(
          "makes neighbour lists that are {}: for stones with diameters of about {:.3g} to {:.3g} "
          "m, the skin should be between {:.2g} and {:.3g} m; is it in m? With 0 the program "
          "chooses it",
          skin > largest ? "very long" : "soon outdated", smallest, largest, 5e-4 * smallest,
          largest),
      {.severity = input::Severity::warning, .reads = {"dem.skin", model.stones_section()}});
}

// Sieve sizes are in mm. Those of a cell are in its own deck.
void declare_skin_of_bed(const Model& model, input::Section& s) {
  double smallest = std::numeric_limits<double>::infinity(), largest = 0;
  const auto add = [&](const bed::LayerParameters& layer) {
    for (const double size : layer.sieve) {
      smallest = std::min(smallest, 1e-3 * size);
      largest = std::max(largest, 1e-3 * size);
    }
  };
  add(model.bed);
  for (const bed::NamedLayer& layer : model.bed.layers) add(layer);
  if (largest > 0 && model.bed.cell.empty()) declare_skin(model, smallest, largest, s);
}

}  // namespace trackbed::model
