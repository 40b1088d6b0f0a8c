// Extremes over a passage. Taken from the histories in the file, so that they need no state of
// their own and a resumed run gives the same ones.
// Alternative: running extremes in memory. They would be state: in the checkpoint, and wrong after
// a resume that cuts histories. Cost: one pass over the rows of one stage, once, shared by all
// ranks.
#include <algorithm>

#include "observe/room.hpp"

namespace trackbed::observe {

namespace {

enum class Extreme { least, most };
// What an extreme is measured from: the state when the passage begins (the track has settled under
// its own weight before), or nothing, for quantities that rest at zero.
enum class From { first_row, zero };

// One line of the table below is one dataset of the results: sources and targets stand side by
// side.
struct Wanted {
  const char* source;
  const char* target;
  Extreme extreme;
  From from;
  io::Label label;
};

// Displacements and stresses from the begin of the passage, since they hold what earlier stages
// left; accelerations from zero, since a track at rest has none. No filter: what is drawn is what
// was computed, and the history is there for who wants one.
const std::vector<Wanted>& envelopes() {
  static const std::vector<Wanted> list{
      {"history/sleeper/displacement",
       "envelope/sleeper/displacement_min",
       Extreme::least,
       From::first_row,
       {"m", "lowest, from the begin of the passage"}},
      {"history/sleeper/displacement",
       "envelope/sleeper/displacement_max",
       Extreme::most,
       From::first_row,
       {"m", "highest, from the begin of the passage"}},
      {"history/sleeper/acceleration",
       "envelope/sleeper/acceleration_max",
       Extreme::most,
       From::zero,
       {"m/s2", "largest magnitude of the rows of the history, no filter"}},
      {"history/ground/displacement",
       "envelope/ground/displacement_min",
       Extreme::least,
       From::first_row,
       {"m", "lowest, from the begin of the passage"}},
      {"history/ground/sigma_z",
       "envelope/ground/sigma_z_min",
       Extreme::least,
       From::first_row,
       {"Pa", "largest compression, from the begin of the passage"}}};
  return list;
}

// Rows [begin, end) of the stage.
// Collective; every rank reads the column of stages, 8 bytes a row. Both equal if the stage has no
// rows.
std::pair<std::size_t, std::size_t> rows_of_stage(const io::File& file, std::int64_t stage) {
  const auto stages = file.read_all<std::int64_t>("history/stage");
  // The rows of a stage are contiguous: the number of the stage only rises along a run.
  const auto first = std::find(stages.begin(), stages.end(), stage);
  const auto last = std::find_if(first, stages.end(), [&](std::int64_t s) { return s != stage; });
  return {static_cast<std::size_t>(first - stages.begin()),
          static_cast<std::size_t>(last - stages.begin())};
}

// Every rank reads its share of the rows; minimum and maximum do not depend on the split.
// Collective. Values of a row lie side by side, so k % columns is the column.
std::vector<double> extremes(const par::Comm& comm, const io::File& file, const Wanted& wanted,
                             std::pair<std::size_t, std::size_t> rows) {
  const std::size_t columns = file.extent(wanted.source).at(1);
  std::vector<double> origin = file.read_rows<double>(wanted.source, rows.first, 1);
  if (wanted.from == From::zero) std::fill(origin.begin(), origin.end(), 0.0);
  const auto [begin, count] = io::share(rows.second - rows.first, comm.rank(), comm.size());
  const auto values = file.read_rows<double>(wanted.source, rows.first + begin, count);
  // One maximum serves all: lowest is the largest of the negated, turned back at the end.
  const double sign = wanted.extreme == Extreme::most ? 1 : -1;
  std::vector<double> found(columns, 0.0);  // the first row itself is at most zero away
  // Magnitude from zero, or the way from the origin in the direction asked for.
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double away = values[k] - origin[k % columns];
    const double size = wanted.from == From::zero ? std::abs(away) : sign * away;
    found[k % columns] = std::max(found[k % columns], size);
  }
  comm.max(std::span<double>(found));
  for (double& value : found) value *= sign;
  return found;
}

}  // namespace

// Collective. Reads first and closes, then changes a copy: a file must not be open twice.
void Results::envelope(std::int64_t stage) {
  flush();
  Room& room = *room_;
  std::vector<std::pair<const Wanted*, std::vector<double>>> found;
  {
    const io::File file(room.comm, room.path, io::Mode::read);
    const auto rows = rows_of_stage(file, stage);
    // Written once: a resumed run comes here again with an envelope that it copied from the old
    // file.
    if (rows.first == rows.second || file.has("envelope")) return;
    for (const Wanted& wanted : envelopes())
      if (file.has(wanted.source))
        found.emplace_back(&wanted, extremes(room.comm, file, wanted, rows));
  }
  room.replace([&](io::File& file) {
    for (const auto& [wanted, values] : found)
      file.write<double>(wanted->target,
                         std::span(values).first(room.comm.root() ? values.size() : 0), 1,
                         wanted->label);
    // A resume from an earlier checkpoint drops an envelope that knows rows it does not have.
    file.attribute("envelope", "rows", room.rows);
    file.attribute("envelope", "stage", stage);
  });
}

}  // namespace trackbed::observe
