// Rules of tamping: tines must have clearance to sleepers and walls, and remain above the floor.
#include <fmt/format.h>

#include <algorithm>

#include "model/rules/rules.hpp"

namespace trackbed::model {

namespace {

// Between the sleepers, and between the outer ones and the ends of the bed.
void declare_clearance(const Model& model, input::Section& s) {
  const bed::TampingParameters& p = model.tamping;
  const track::SleeperParameters& sleepers = model.sleepers;
  const input::About about{
      .reads = {"tamping", "sleepers", "bed", "stage", "dimension", "periodic"}};
  const double reach = p.reach();
  s.rule("tamping.gap",
         sleepers.count < 2 || 2 * reach <= sleepers.spacing - sleepers.width + same_length,
         fmt::format("two tines need {:g} m each (gap, thickness and amplitude), together more "
                     "than the space between sleepers ({:g} m); reduce gap, thickness or amplitude",
                     reach, sleepers.spacing - sleepers.width),
         about);
  // Surfaces have no periodic images: a stone that crosses the side near a tine would suddenly
  // overlap it.
  const double stone = model.bed.sieve.empty() ? 0 : 1.5e-3 * model.bed.sieve.back();  // mm
  const double half = sleepers.width / 2 + reach + (model.periodic_in("x") ? stone : 0);
  const auto& x = model.bed.x;
  s.rule("tamping.gap",
         x.size() != 2 || (sleepers.first - half >= x[0] - same_length &&
                           sleepers.last() + half <= x[1] + same_length),
         fmt::format("tines and their clearance reach from x = {:g} to {:g} m, beyond the ends of "
                     "the bed (bed.x = {:g} to {:g} m); make the bed longer or the gap smaller",
                     sleepers.first - half, sleepers.last() + half, x.empty() ? 0 : x.front(),
                     x.empty() ? 0 : x.back()),
         about);
  if (model.dimension == Dimension::plane) return;
  s.rule("tamping.y", !p.y.empty(), "must give the positions of the tines across the track", about);
  const auto& y = model.bed.y;
  s.rule("tamping.y",
         y.size() != 2 || std::all_of(p.y.begin(), p.y.end(),
                                      [&](double at) {
                                        return at - p.width / 2 >= y[0] - same_length &&
                                               at + p.width / 2 <= y[1] + same_length;
                                      }),
         fmt::format("puts tines beyond the sides of the bed (bed.y = {:g} to {:g} m)",
                     y.empty() ? 0 : y.front(), y.empty() ? 0 : y.back()),
         about);
}

}  // namespace

void declare_tamping(const Model& model, input::Section& s) {
  if (!model.has_stage(StageKind::tamp)) {
    s.rule("tamping", model.tamping == bed::TampingParameters{},
           "has no effect: no stage is of kind tamp", {.reads = {"tamping", "stage"}});
    return;
  }
  declare_clearance(model, s);
  for (const Stage& stage : model.stages)
    s.rule("tamping.depth",
           stage.kind != StageKind::sleepers || stage.height == 0 ||
               stage.height + model.tamping.lift > model.tamping.depth,
           fmt::format("puts the tips of the tines below the floor: the sleepers are {:g} m above "
                       "the floor and are lifted by {:g} m",
                       stage.height, model.tamping.lift),
           {.reads = {"tamping", "stage"}});
}

}  // namespace trackbed::model
