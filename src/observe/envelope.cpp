// Extremes over a passage, computed from the histories in the file, so that they have no state of
// their own and a resumed run gives the same ones.
// Rejected: running extremes in memory. They would be state in the checkpoint, and wrong after a
// resume that cuts histories. Cost: one pass over the rows of one stage, distributed over all
// ranks.
#include <algorithm>

#include "observe/impl.hpp"
#include "observe/layout.hpp"

namespace trackbed::observe {

namespace {

enum class Extreme { least, most };
// Reference of an extreme: the state at the beginning of the passage (the track has settled under
// its own weight before), or zero, for quantities that are zero at rest.
enum class Reference { first_row, zero };

// One entry of the table below is one dataset of the results, with its source.
struct EnvelopeSpec {
  const char* source;
  const char* target;
  Extreme extreme;
  Reference reference;
  io::Label label;
};

// Displacements and stresses are relative to the beginning of the passage, since they include the
// effects of earlier stages; accelerations are relative to zero. No filter is applied; the history
// is available for filtering.
const std::vector<EnvelopeSpec>& envelopes() {
  static const std::vector<EnvelopeSpec> list{
      {"history/sleeper/displacement",
       "envelope/sleeper/displacement_min",
       Extreme::least,
       Reference::first_row,
       {"m", "lowest, relative to the beginning of the passage"}},
      {"history/sleeper/displacement",
       "envelope/sleeper/displacement_max",
       Extreme::most,
       Reference::first_row,
       {"m", "highest, relative to the beginning of the passage"}},
      {"history/sleeper/acceleration",
       "envelope/sleeper/acceleration_max",
       Extreme::most,
       Reference::zero,
       {"m/s2", "largest magnitude of the rows of the history, no filter"}},
      {"history/ground/displacement",
       "envelope/ground/displacement_min",
       Extreme::least,
       Reference::first_row,
       {"m", "lowest, relative to the beginning of the passage"}},
      {"history/ground/sigma_z",
       "envelope/ground/sigma_z_min",
       Extreme::least,
       Reference::first_row,
       {"Pa", "largest compression, relative to the beginning of the passage"}}};
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

// Every rank reads a fraction of the rows; minimum and maximum do not depend on the distribution.
// Collective. Values of a row are contiguous, so k % columns is the column.
std::vector<double> extremes(const par::Comm& comm, const io::File& file,
                             const EnvelopeSpec& wanted, std::pair<std::size_t, std::size_t> rows) {
  const std::size_t columns = file.extent(wanted.source).at(1);
  std::vector<double> origin = file.read_rows<double>(wanted.source, rows.first, 1);
  if (wanted.reference == Reference::zero) std::fill(origin.begin(), origin.end(), 0.0);
  const auto [begin, count] = io::row_range(rows.second - rows.first, comm.rank(), comm.size());
  const auto values = file.read_rows<double>(wanted.source, rows.first + begin, count);
  // Only the maximum is computed: the minimum is that of the negated values, negated at the end.
  const double sign = wanted.extreme == Extreme::most ? 1 : -1;
  std::vector<double> found(columns, 0.0);  // the first row has zero distance
  // Magnitude, or the difference from the origin in the requested direction.
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double away = values[k] - origin[k % columns];
    const double size = wanted.reference == Reference::zero ? std::abs(away) : sign * away;
    found[k % columns] = std::max(found[k % columns], size);
  }
  comm.max(std::span<double>(found));
  for (double& value : found) value *= sign;
  return found;
}

}  // namespace

// Collective. Reads and closes the file, then changes a copy, since a file must not be open twice.
void Results::envelope(std::int64_t stage) {
  flush();
  Impl& impl = *impl_;
  std::vector<std::pair<const EnvelopeSpec*, std::vector<double>>> found;
  {
    const io::File file(impl.comm, impl.path, io::Mode::read);
    const auto rows = rows_of_stage(file, stage);
    // Written once: a resumed run may have copied the envelope from the old file.
    if (rows.first == rows.second || file.has("envelope")) return;
    for (const EnvelopeSpec& wanted : envelopes())
      if (file.has(wanted.source))
        found.emplace_back(&wanted, extremes(impl.comm, file, wanted, rows));
  }
  impl.replace([&](io::File& file) {
    for (const auto& [wanted, values] : found) {
      file.write<double>(wanted->target,
                         std::span(values).first(impl.comm.root() ? values.size() : 0), 1,
                         wanted->label);
      set_axis_of_envelope(impl.comm, file, wanted->target);
    }
    // A resume from an earlier checkpoint drops an envelope that includes later rows.
    file.attribute("envelope", "rows", impl.rows);
    file.attribute("envelope", "stage", stage);
  });
}

}  // namespace trackbed::observe
