// What each kind of stage does to the model when it begins, in every window, and when it ends.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/scene/world.hpp"
#include "model/stages/jump.hpp"
#include "model/stages/settlement.hpp"
#include "model/stages/stage_train.hpp"
#include "trackbed/core/clock.hpp"
#include "trackbed/model/parameters.hpp"

namespace trackbed::model {

// Holds references: world and model must outlive it.
class StageActions {
 public:
  // Throws InputError for a bad seat load table.
  StageActions(World& world, const Model& model);

  // Pours stones, places sleepers, platen or tines, cuts to the profile. Returns a sentence on
  // that, or nothing. Collective.
  std::string begin(const Stage& stage);
  // Growth of stones in a window that begins `time` s after the stage did.
  void grow(const Stage& stage, double time, double dt);
  // Damping and friction of the stage; a resume sets them again.
  void set_contacts(const Stage& stage);
  void watch(const Stage& stage, const Clock& clock);  // after every window
  double duration(const Stage& stage) const;           // s
  // Starts the stage's train, if it has one, once the window (s) is known.
  void send_train(const Stage& stage, double window);
  // To be called after the sleepers have moved in a window.
  void move_train(const Stage& stage, const Clock& clock);
  const StageTrain& train() const { return train_; }
  // Force on the seats of each sleeper, N downwards, `time` s after the stage began.
  std::vector<double> seat_forces(const Stage& stage, double time) const;
  // The same for both seats of each sleeper, if it has two: `sums` are those of seat_forces.
  std::vector<double> on_seats(const Stage& stage, double time,
                               const std::vector<double>& sums) const;
  // On solid rails; none without them, or in other stages than passages.
  std::vector<track::AxleLoad> axles(const Stage& stage, double time) const;
  // Whether the stage has reached its aim before the end of its duration. Depends on state alone,
  // so that a resumed run decides identically. Collective.
  bool settled(const Stage& stage, const Clock& clock) const;
  // At the end of a stage: a sentence on the missed aim, empty if it is reached; no value if the
  // stage has no aim. Collective.
  std::optional<std::string> shortfall(const Stage& stage) const;
  double settlement() const { return settlement_.last(); }  // m, in the last cycle; < 0: none
  const Jump& jump() const { return jump_; }
  void end(const Stage& stage);  // collective

  // State of the present stage that is in neither the deck nor the model, and what finished ones
  // leave. `window`: s, of the present stage. After the sleepers' state.
  void archive(io::Archive& a, double window);

 private:
  double time_of_train(const Stage& stage, double time) const;
  void pour(const Stage& stage);
  void place_sleepers(const Stage& stage);
  void fill_cribs(const Stage& stage);
  bool walls_are_steady(const Stage& stage) const;
  std::optional<std::string> load_left(const Stage& stage) const;  // of the lifted platen

  World& world_;
  const Model& model_;
  track::SeatLoad seat_load_;
  Settlement settlement_;
  Jump jump_;
  StageTrain train_;
};

}  // namespace trackbed::model
