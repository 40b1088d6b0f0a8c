// Cycles of load: their number, and jumps over them.
#pragma once

#include <algorithm>
#include <string>

#include "model/scene/world.hpp"
#include "trackbed/core/clock.hpp"
#include "trackbed/io/archive.hpp"
#include "trackbed/model/parameters.hpp"

namespace trackbed::model {

class Jump {
 public:
  Jump(World& world, const Model& model) : world_(world), model_(model) {}

  // Notes the level of the sleepers if the measured cycles begin, and their aim if a jump does; of
  // a jump a sentence about it.
  std::string begin(const Stage& stage);
  void end_cycle(const Stage& stage);  // a cycle of the stage, not of a jump, is complete
  // After each window: at the end of the cycles of a jump friction falls.
  void watch(const Stage& stage, const Clock& clock);
  void end(const Stage& stage);  // of the stage

  // N on each sleeper in a jump, `time` s after it began, besides the seat force.
  double load(const Stage& stage, double time) const;
  double friction() const { return friction_; }  // over that of the contact laws
  // Whether a cycle of a jump ends now, and the sleepers have settled as they should.
  bool is_over(const Stage& stage, const Clock& clock) const;
  // At the end of a jump: what it has missed, or an empty sentence.
  std::string shortfall() const;

  bool counts() const { return counted_ >= 0; }
  double cycles() const { return std::max(counted_, 0.0); }  // since jump.from, jumps included
  void archive(io::Archive& a);

 private:
  void note_level_before_jump(const Stage& stage);
  bool ends_cycle(const Clock& clock) const;
  double level() const;                                // m, mean of the sleepers
  double settled() const { return level_ - level(); }  // m, in a jump
  double missing() const;                              // m, of the settlement in a jump

  World& world_;
  const Model& model_;
  double counted_ = -1;  // cycles; below 0: none count yet
  double in_stage_ = 0;  // complete cycles of the present stage
  double noted_ = -1;    // `counted_` when the level was noted; below 0: it was not
  double level_ = 0;     // m, then; in a jump at its begin
  double aim_ = 0;       // m, settlement of a jump
  double friction_ = 1;
};

}  // namespace trackbed::model
