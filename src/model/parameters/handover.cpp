// Parameters of the hand-over loop are in the deck of the bed, so that one file contains all input;
// the loop itself is jobs/handover.py: each round runs the program on decks with one more stage,
// from checkpoint to checkpoint. Rejected: a stage that performs a whole round; its track alone
// would have neither results nor figures of its own.
#include "trackbed/model/handover.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "trackbed/model/parameters.hpp"

namespace trackbed::model {

void HandoverParameters::declare(input::Section& s) {
  s.text("after", after, "Name of the stage after which the rounds begin; empty: no loop.");
  s.integer("rounds", rounds, {.at_least = 1, .at_most = 1000},
            "Number of rounds; each round: static load test for the support stiffness; run of a "
            "track alone for the seat forces; trains on the bed; update of the rail geometry.");
  s.integer("trains", trains, {.at_least = 1, .at_most = 10000},
            "Number of trains computed in a round.");
  s.number("each", each, {.above = 0, .usually_to = 1e6},
           "Number of trains that each computed train represents: the settlement under a computed "
           "train is multiplied by this number before the rail geometry is updated.");
  s.number("load", load, {.unit = "N", .above = 0, .usually_from = 100, .usually_to = 1e6},
           "Peak force on each sleeper in the static load test of the supports, in addition to "
           "seat_force.");
}

// The loop itself sets the geometry of the rails.
void declare_handover(const Model& model, input::Section& s) {
  const std::string& after = model.handover.after;
  if (after.empty()) return;
  const bool known = std::any_of(model.stages.begin(), model.stages.end(),
                                 [&](const Stage& stage) { return stage.name == after; });
  s.rule("handover.after", known, fmt::format("there is no stage \"{}\"", after),
         {.reads = {"handover", "stage"}});
  s.rule("handover.after", model.has_train(), "needs a stage with train = true",
         {.reads = {"handover", "stage"}});
  s.rule(
      "irregularity.kind", model.track.irregularity.kind == track::IrregularityKind::none,
      "must be \"none\" in a deck with [handover]: the loop derives the geometry of the rails from "
      "the settlement",
      {.reads = {"handover", "irregularity"}});
  if (model.track.line.track.dimension == Dimension::plane) return;
  const track::IrregularityKind right = model.track.irregularity_right.kind;
  s.rule("irregularity_right.kind",
         right == track::IrregularityKind::none || right == track::IrregularityKind::same,
         "must be \"none\" or \"same\" in a deck with [handover]: the loop derives the geometry of "
         "the rails from the settlement",
         {.reads = {"handover", "irregularity_right"}});
  s.rule(
      "sleepers.model", model.sleepers.model == track::SleeperBody::rigid,
      "must be \"rigid\" in a deck with [handover] and two rails: on a solid sleeper, seat loads "
      "from a table act equally on both seats",
      {.reads = {"handover", "track", "sleepers"}});
  const auto& free = model.sleepers.free;
  s.rule(
      "sleepers.free", std::find(free.begin(), free.end(), "rx") != free.end(),
      "must contain \"rx\" in a deck with [handover] and two rails: the loop derives the geometry "
      "of the rails from the settlement of both ends of the sleepers",
      {.reads = {"handover", "track", "sleepers"}});
}

}  // namespace trackbed::model
