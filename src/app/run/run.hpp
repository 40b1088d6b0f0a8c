// A run: the one loop over stages and their windows, with its agreement of ranks, checkpoints, log
// and summary. What a window does is the scheme's (trackbed/model/scheme.hpp).
#pragma once

#include <string>
#include <vector>

#include "app/run/progress.hpp"
#include "trackbed/model/scheme.hpp"

namespace trackbed::app {

enum class Outcome { finished, stopped };

// The result folder a checkpoint (file or folder) belongs to.
std::string folder_of_checkpoint(const std::string& checkpoint);

class Run {
 public:
  // Keeps references. Collective.
  Run(model::RunContext& context, model::Scheme& scheme);

  // Earlier warnings, for the summary: those of the deck and its files, which each command repeats.
  void add_deck_warnings(const std::vector<std::string>& warnings) { deck_warnings_ = warnings; }
  // Warnings of the state from which the run continues, which later commands cannot repeat.
  void add_state_warnings(const std::vector<std::string>& warnings);
  // Continues the run of the checkpoint; the result is bitwise identical to an uninterrupted run.
  // Collective, as all below.
  void resume(const std::string& checkpoint);
  // Takes the state of a checkpoint at the end of a stage; this deck's later stages follow.
  void start_from(const std::string& checkpoint);
  // Throws RunError with the time, the stage and the last checkpoint.
  Outcome execute();
  // Of this run, or the one from which it continued; empty: none.
  const std::string& last_checkpoint() const { return last_checkpoint_; }

 private:
  // In rising priority: the maximum over all ranks decides.
  enum class Verdict : std::int64_t { go_on, report, save, report_and_save, stop, trouble };

  Outcome run_stages();
  bool begin_stage();
  bool runs() const;
  double time_left() const;  // s of simulated time, rough
  void end_stage();
  Outcome stop_with_checkpoint();
  Outcome stop();
  Outcome finish();
  bool is_at_given_stop() const;
  bool must_agree() const;
  Verdict agree();
  void plan_next_agreement();
  void report();
  void note_warnings();
  bool is_long_without_checkpoint() const;  // on rank 0
  void periodic_checkpoint();
  std::string name_of_checkpoint() const;
  void checkpoint(const std::string& name);
  void save(io::File& file);
  void load(const io::File& file);
  std::vector<std::string> warnings() const;  // of the deck, then of the run
  void write_summary(Outcome outcome);

  model::RunContext& context_;
  model::Scheme& scheme_;
  Progress progress_;
  model::Course& course_ = context_.course;
  std::string last_checkpoint_, started_from_;
  std::vector<std::string> deck_warnings_;         // before the run began
  std::size_t warnings_noted_ = 0;                 // in progress.jsonl
  std::vector<std::string> periodic_checkpoints_;  // of this run, oldest first
  std::int64_t agreed_ = 0, next_agreement_ = 0;   // windows of the run
  double agreed_at_ = 0, checkpoint_at_ = 0;       // s of wall time
  const std::string files_;                        // hashes of the files of the deck
};

}  // namespace trackbed::app
