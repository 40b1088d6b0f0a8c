// A run: stages one after the other, each a straight loop over time windows.
#pragma once

#include <chrono>
#include <string>

#include "app/run/course.hpp"
#include "app/run/progress.hpp"
#include "app/scene/world.hpp"
#include "app/stages/stages.hpp"
#include "trackbed/core/timers.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/observe/results.hpp"

namespace trackbed::app {

enum class Outcome { finished, stopped };

// The result folder a checkpoint (file or folder) belongs to.
std::string folder_of_checkpoint(const std::string& checkpoint);

class Simulation {
 public:
  // `name`: of the deck, for the log. Results are written into `folder`. Collective, as all below.
  // Builds the model, which may take most of the memory of the run.
  Simulation(const par::Comm& comm, const Model& model, const input::Deck& deck,
             const std::string& name, const std::string& folder);

  // Earlier warnings, for the summary: those of the deck and its files, which each command repeats.
  void keep(const std::vector<std::string>& warnings) { deck_warnings_ = warnings; }
  // Warnings of the state from which the run continues, which later commands cannot repeat.
  void keep_in_state(const std::vector<std::string>& warnings) {
    course_.warnings.insert(course_.warnings.end(), warnings.begin(), warnings.end());
  }
  // Shapes of placed stones, made before; without effect for other models.
  void give_shapes(const std::vector<bed::PlacedShape>& shapes) {
    if (world_.placement) world_.placement->give_shapes(shapes);
  }
  // Continues the run of the checkpoint; the result is bitwise identical to an uninterrupted run.
  void resume(const std::string& checkpoint);
  // Takes the state of a checkpoint at the end of a stage; this deck's later stages follow.
  void start_from(const std::string& checkpoint);
  Outcome run();
  // Of this run, or the one from which it continued; empty: none.
  const std::string& last_checkpoint() const { return last_checkpoint_; }

 private:
  // In rising priority: the maximum over all ranks decides.
  enum class Verdict : std::int64_t { go_on, report, stop, trouble };

  void window();
  void move_sleepers(double dt);
  void move_solids(double dt);
  void move_platen(double dt);
  void move_ground(double dt);
  void load_ground(double dt);
  void move_stones(double dt);
  void average_support(double dt);

  const Stage& stage() const { return model_.stages[course_.stage]; }
  bool settle_ground();
  bool runs() const;
  bool is_last_passage() const;
  bool begin_stage();
  void end_stage();
  void judge(const StageRecord& record, const std::string& shortfall);
  void warn(const std::string& sentence);
  Outcome run_stages();
  bool is_to_stop() const;
  Verdict agree();
  void observe();
  void sample();
  void checkpoint_if_due();
  void checkpoint(const std::string& name);
  bool every(double interval) const;
  bool keeps_extremes() const;
  void begin_extremes();
  void resume_extremes(bool kept);
  std::int64_t windows_in(double interval) const;  // at least 1

  void save(io::File& file);
  void load(const io::File& file);
  void write_summary(bool finished);

  const par::Comm& comm_;
  const Model& model_;
  const input::Deck& deck_;
  std::string name_, folder_;
  const std::string files_;  // hashes of the files of the deck
  World world_;
  StageActions actions_;
  Timers timers_;
  Course course_;
  observe::Results results_;
  Progress progress_;
  std::string last_checkpoint_, started_from_;
  std::vector<std::string> deck_warnings_;         // before the run began
  std::vector<std::string> periodic_checkpoints_;  // of this run, oldest first
  std::vector<double> seat_force_;                 // N, in the last window
  std::vector<Vec3> load_;                         // N, of pressures on the top, in the last window
  SpeedCounters measured_;                         // counters at the start of the last stage
  double stage_begin_ = 0;                         // s of wall time
};

}  // namespace trackbed::app
