// What each kind of stage does to the model when it begins, in every window, and when it ends.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/parameters.hpp"
#include "app/settlement.hpp"
#include "app/stage_train.hpp"
#include "app/world.hpp"
#include "trackbed/core/clock.hpp"

namespace trackbed::app {

// Holds references: world and model must outlive it.
class StageActions {
 public:
  // Throws InputError for a bad seat load table.
  StageActions(World& world, const Model& model);

  // Stones poured, sleepers placed, platen lowered, ground let go. Collective.
  void begin(const Stage& stage);
  // Stones that grow, to the end of a window that begins `time` s after the stage did.
  void grow(const Stage& stage, double time, double dt);
  void watch(const Stage& stage, const Clock& clock);  // after every window
  double duration(const Stage& stage) const;           // s
  // Once the stage's window (s) is known: its train, if it has one.
  void send_train(const Stage& stage, double window);
  // After the sleepers of a window.
  void move_train(const Stage& stage, const Clock& clock);
  const StageTrain& train() const { return train_; }
  // Force on each rail seat, N downwards, `time` s after the stage began.
  std::vector<double> seat_forces(const Stage& stage, double time) const;
  // The same of both seats of each sleeper, if it has two: `sums` are those of seat_forces.
  std::vector<double> on_seats(const Stage& stage, double time,
                               const std::vector<double>& sums) const;
  // On solid rails; none without them, or in other stages than passages.
  std::vector<track::AxleLoad> axles(const Stage& stage, double time) const;
  // Whether the stage has reached its aim before its duration is over. Depends on state alone, so
  // that a resumed run decides alike. Collective.
  bool settled(const Stage& stage, const Clock& clock) const;
  // A sentence on what the aim of a stage whose time is over still lacks, empty if it is reached;
  // nothing if the stage has none. Collective.
  std::optional<std::string> shortfall(const Stage& stage) const;
  double settlement() const { return settlement_.last(); }  // m, in the last cycle; < 0: none
  void end(const Stage& stage);                             // collective

  // What of a stage under way is in neither the deck nor the model. Collective.
  void save(io::File& file) const;
  void load(const io::File& file, double window);  // s, of the stage under way
  void load_done(const io::File& file);            // what stages left that are over

 private:
  double time_of_train(const Stage& stage, double time) const;
  void pour(const Stage& stage);
  void place_sleepers(const Stage& stage);
  void fill_cribs(const Stage& stage);
  bool walls_are_steady(const Stage& stage) const;

  World& world_;
  const Model& model_;
  track::SeatLoad seat_load_;
  Settlement settlement_;
  StageTrain train_;
};

}  // namespace trackbed::app
