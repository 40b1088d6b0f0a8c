// What a run advances in time: a bed, placed stones or a ground in stages, or a track in one
// passage. The loop over stages and windows, requests to stop, checkpoints and the summary are in
// app/run/run.hpp, and are the same for all schemes.
#pragma once

#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "trackbed/bed/placed.hpp"
#include "trackbed/io/archive.hpp"
#include "trackbed/model/run_context.hpp"

namespace trackbed::model {

// Figures of the present state: for a line of the log, and as numbers with units in their names.
struct Status {
  std::string words;
  nlohmann::ordered_json figures = nlohmann::ordered_json::object();
};

// The state of progress is the course of the context: a scheme sets its clock and its steps when a
// stage begins. All calls are collective unless stated otherwise.
class Scheme {
 public:
  virtual ~Scheme() = default;

  // Local, as the following two.
  virtual std::size_t stages() const = 0;
  virtual std::string stage() const = 0;  // name of the present stage
  // Simulated, of the stages after the present one, s.
  virtual double duration_of_later_stages() const = 0;
  // Prints the main properties of the model, and begins histories or continues those of `resume`.
  virtual void start() = 0;
  // Chooses windows and sub-steps. False if a request to stop ended it; nothing has been changed
  // then, so that no checkpoint is needed.
  virtual bool begin_stage() = 0;
  virtual void advance() = 0;  // one window, at whose end the clock is moved on
  // An error of this rank; empty: none. Local.
  virtual std::string problem() = 0;
  // Whether errors and requests to stop are looked for after every window; otherwise at intervals
  // of wall time, for windows that take less time than a message. Local.
  virtual bool agrees_in_every_window() const = 0;
  // Whether the stage has reached its aim before its last window. Depends on state alone, so that a
  // resumed run decides alike.
  virtual bool is_done() const = 0;
  virtual void record() = 0;  // output after a window; changes no result
  virtual Status status() = 0;
  virtual void end_stage() = 0;           // output, and the changes at the end of a stage
  virtual bool keeps_stages() const = 0;  // a checkpoint after each stage; local
  // Writes what histories still hold in memory.
  virtual void flush() = 0;
  // After an error that all ranks have: writes what can still be written. Returns where the state
  // at the error can be seen, or nothing. Does not throw.
  virtual std::string rescue() noexcept { return {}; }
  // After the last stage: nothing more is added to the results.
  virtual void finish() {}
  // Warnings on results of a finished run.
  virtual std::vector<std::string> warnings_at_end() = 0;
  virtual void summarize(nlohmann::ordered_json& summary) = 0;

  virtual void archive(io::Archive& a) = 0;  // the course is loaded before
  // After loading: continues the same run; `histories`: the file beside the checkpoint.
  virtual void resume(const io::File& file, const std::string& histories) = 0;
};

// The scheme of the model. Builds it, which may take most of the memory of the run. `shapes`: of
// placed stones, made before; without effect for other models.
std::unique_ptr<Scheme> make_scheme(RunContext& context,
                                    const std::vector<bed::PlacedShape>& shapes);

// Rows of the histories when a checkpoint of a run in stages was written. Collective; throws
// RunError for one of a passage.
std::int64_t history_rows_in(const io::File& checkpoint);

}  // namespace trackbed::model
