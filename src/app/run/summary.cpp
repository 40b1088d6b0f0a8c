// summary.json: what all runs have, and the figures of the scheme. Names and units are fixed
// (docs/running.md).
#include <sys/resource.h>

#include <algorithm>

#include "app/run/result_folder.hpp"
#include "app/run/run.hpp"

namespace trackbed::app {

namespace {

using Json = nlohmann::ordered_json;

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;  // Linux counts in KiB
}

// Fractions of the wall time (s), mean over ranks. Collective.
Json time_fractions(const par::Comm& comm, const Timers& timers, double wall) {
  const auto fraction = [&](Phase phase) {
    return wall > 0 ? comm.sum(timers.seconds(phase)) / comm.size() / wall : 0;
  };
  Json result;
  double known = 0;
  for (const auto& [name, value] :
       {std::pair{"dem", fraction(Phase::dem)}, std::pair{"ground", fraction(Phase::ground)},
        std::pair{"track", fraction(Phase::track)},
        std::pair{"coupling", fraction(Phase::coupling)},
        std::pair{"output", fraction(Phase::output) + fraction(Phase::observe)}}) {
    result[name] = value;
    known += value;
  }
  // Not below zero by rounding.
  result["other"] = std::max(0.0, 1 - known);
  return result;
}

// Of each phase, s; parts within the phase that includes them. Collective.
Json times(const par::Comm& comm, const Timers& timers) {
  Json result = Json::object();
  for (const model::PhaseTime& time : model::times_over_ranks(comm, timers)) {
    const std::string name(name_of(time.phase));
    Json& here = is_part(time.phase)
                     ? result[std::string(name_of(parent_of(time.phase)))]["parts"][name]
                     : result[name];
    here["min_s"] = time.least, here["mean_s"] = time.mean, here["max_s"] = time.largest;
  }
  return result;
}

const char* name_of(model::ModelKind kind) {
  switch (kind) {
    case model::ModelKind::bed:
      return "bed";
    case model::ModelKind::track:
      return "track";
    case model::ModelKind::track_on_ground:
      return "track_on_ground";
    case model::ModelKind::ground:
      return "ground";
    case model::ModelKind::stones:
      return "stones";
  }
  return "?";
}

}  // namespace

// Collective.
void Run::write_summary(Outcome outcome) {
  const par::Comm& comm = context_.comm;
  const double wall = context_.log.wall_time();
  Json json{{"deck", context_.name},
            {"model", name_of(context_.model.kind)},
            {"finished", outcome == Outcome::finished},
            {"ranks", comm.size()},
            {"simulated_time_s", course_.clock.time()},
            {"wall_time_s", comm.max(wall)},
            {"wall_time_of_all_parts_s", course_.earlier_wall_time + comm.max(wall)},
            {"windows", course_.windows}};
  scheme_.summarize(json);
  json["share"] = time_fractions(comm, context_.timers, wall);
  json["timers"] = times(comm, context_.timers);
  json["memory_mb_per_rank"] = comm.max(peak_memory_mb());
  json["warnings"] = warnings();
  // Warnings may name files whose names are no UTF-8.
  write_summary_file(comm, context_.folder,
                     json.dump(2, ' ', false, Json::error_handler_t::replace));
}

}  // namespace trackbed::app
