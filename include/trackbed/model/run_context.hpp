// What a run and its scheme share.
#pragma once

#include <string>
#include <vector>

#include "trackbed/core/timers.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/model/course.hpp"
#include "trackbed/model/log.hpp"
#include "trackbed/model/parameters.hpp"
#include "trackbed/observe/results.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::model {

struct RunContext {
  // `name`: of the deck, for the log; `folder`: of the results.
  RunContext(const par::Comm& c, const Model& m, const input::Deck& d, std::string n, std::string f)
      : comm(c), model(m), deck(d), name(std::move(n)), folder(std::move(f)), log(c) {}

  const par::Comm& comm;
  const Model& model;
  const input::Deck& deck;
  const std::string name, folder;
  Course course;
  Timers timers;
  Log log;

  // A warning of the run: printed at once, stored in checkpoints and repeated in summary.json.
  // Local, but the same on all ranks.
  void warn(const std::string& sentence);
  // Fields of the present instant, named `name`; `parts` must outlive them.
  observe::FieldFiles field_files(const std::string& name,
                                  const std::vector<std::string>& parts) const;
  // s of wall time before the end of the batch job at which the run stops, to write a checkpoint.
  double reserve = 60;

  // Whether a signal has reached this rank, or, on rank 0, a limit of wall time: clocks of nodes
  // differ. Local.
  bool is_to_stop() const;
  // Whole windows in an interval (s), at least 1.
  std::int64_t windows_in(double interval) const;
  // Whether the present window ends a multiple of `interval` s; 0: never. Counted in windows of the
  // stage, so that it needs no state and does not drift: a resumed run writes in the same windows.
  bool ends(double interval) const;
};

}  // namespace trackbed::model
