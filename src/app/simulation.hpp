// A run: stages one after the other, each a straight loop over time windows.
#pragma once

#include <chrono>
#include <string>

#include "app/course.hpp"
#include "app/progress.hpp"
#include "app/stages.hpp"
#include "app/world.hpp"
#include "trackbed/core/timers.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/observe/results.hpp"

namespace trackbed::app {

enum class Outcome { finished, stopped };

// The result folder a checkpoint (file or folder) belongs to.
std::string folder_of_checkpoint(const std::string& checkpoint);

class Simulation {
 public:
  // `name`: of the deck, for reports. Results go into `folder`. Collective, as all below.
  // Builds the model, which may take most of the memory of the run.
  Simulation(const par::Comm& comm, const Model& model, const input::Deck& deck,
             const std::string& name, const std::string& folder);

  // Warnings that were said before, for the summary: those that each command on the deck and its
  // files says again.
  void keep(const std::vector<std::string>& said) { said_ = said; }
  // Those of the state that the run goes on from, which no later command may find again.
  void keep_in_state(const std::vector<std::string>& said) {
    course_.warnings.insert(course_.warnings.end(), said.begin(), said.end());
  }
  // Of the stones that the deck places, made before; nothing for other models.
  void give_shapes(const std::vector<bed::PlacedShape>& shapes) {
    if (world_.placement) world_.placement->give_shapes(shapes);
  }
  // Goes on exactly where the checkpoint was written.
  void resume(const std::string& checkpoint);
  // Takes the state a checkpoint at the end of a stage holds; this deck's later stages follow.
  void start_from(const std::string& checkpoint);
  Outcome run();
  // Of this run, or what it went on from; empty: none.
  const std::string& last_checkpoint() const { return last_checkpoint_; }

 private:
  // In rising weight: the largest over all ranks is what happens.
  enum class Verdict : std::int64_t { go_on, report, stop, trouble };

  void window();
  void move_sleepers(double dt);
  void move_solids(double dt);
  void press_platen(double dt);
  void move_ground(double dt);
  void press_ground(double dt);
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
  std::int64_t windows_in(double interval)
      const;  // at least 1  // whether the present window ends a multiple of `interval` s

  void save(io::File& file);
  void load(const io::File& file);
  void write_summary(bool finished);

  const par::Comm& comm_;
  const Model& model_;
  const input::Deck& deck_;
  std::string name_, folder_;
  const std::string files_;  // what those of the deck hold
  World world_;
  StageActions actions_;
  Timers timers_;
  Course course_;
  observe::Results results_;
  Progress progress_;
  std::string last_checkpoint_, started_from_;
  std::vector<std::string> said_;                  // warnings before the run began
  std::vector<std::string> periodic_checkpoints_;  // of this run, oldest first
  std::vector<double> seat_force_;                 // N, in the last window
  std::vector<Vec3> load_;                         // N, of pressures on the top, in the last window
  Measured measured_;                              // where the figures of the last stage begin
  double stage_begin_ = 0;                         // s of wall time
};

}  // namespace trackbed::app
