#include "trackbed/io/numbered_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "trackbed/core/error.hpp"
#include "trackbed/par/directory.hpp"

namespace trackbed::io {

namespace {

using Lists = std::vector<std::vector<std::int64_t>>;  // one for each rank

// The rank whose part of the rows contains one, as row_range divides them.
std::size_t reader_of(std::size_t row, std::size_t rows, std::size_t ranks) {
  const std::size_t least = rows / ranks, longer = rows % ranks;  // parts that have one more
  const std::size_t end = longer * (least + 1);
  return row < end ? row / (least + 1) : longer + (row - end) / least;
}

}  // namespace

NumberedRows::NumberedRows(const par::Comm& comm, const File& file, const std::string& numbers,
                           std::span<const std::int64_t> wanted)
    : comm_(comm), file_(&file), rows_(file.extent(numbers)[0]), wanted_(wanted.size()) {
  const auto ranks = static_cast<std::size_t>(comm.size());
  // Not the file's own split: its communicator may be another one.
  part_ = row_range(rows_, comm.rank(), comm.size());
  const auto mine = file.read_rows<std::int64_t>(numbers, part_.begin, part_.count);
  std::vector<std::int64_t> rows(mine.size());
  std::iota(rows.begin(), rows.end(), static_cast<std::int64_t>(part_.begin));
  const auto found = par::Directory(comm, mine, rows).places_of(wanted);
  const auto missing = std::find(found.begin(), found.end(), -1);
  comm.agree(
      missing == found.end()
          ? ""
          : fmt::format("dataset {} of the checkpoint has no row {}; give the deck the model "
                        "with which the checkpoint was written",
                        numbers, wanted[static_cast<std::size_t>(missing - found.begin())]));
  Lists asks(ranks);
  place_.resize(ranks), asked_.resize(ranks);
  for (std::size_t k = 0; k < found.size(); ++k) {
    const std::size_t reader = reader_of(static_cast<std::size_t>(found[k]), rows_, ranks);
    asks[reader].push_back(found[k]);
    place_[reader].push_back(k);
  }
  const Lists in = comm.exchange(asks);
  for (std::size_t rank = 0; rank < ranks; ++rank)
    for (const std::int64_t row : in[rank])
      asked_[rank].push_back(static_cast<std::size_t>(row) - part_.begin);
}

std::vector<double> NumberedRows::read(const std::string& path, std::size_t columns) const {
  const auto extent = file_->extent(path);
  if (extent[0] != rows_ || extent[1] != columns)
    throw RunError(
        fmt::format("dataset {} has {} rows of {} values, not {} of {}; use an earlier "
                    "checkpoint",
                    path, extent[0], extent[1], rows_, columns));
  const auto mine = file_->read_rows<double>(path, part_.begin, part_.count);
  std::vector<std::vector<double>> out(asked_.size());
  for (std::size_t rank = 0; rank < out.size(); ++rank) {
    out[rank].reserve(asked_[rank].size() * columns);
    for (const std::size_t row : asked_[rank])
      for (std::size_t c = 0; c < columns; ++c) out[rank].push_back(mine[row * columns + c]);
  }
  const auto in = comm_.exchange(out);
  std::vector<double> values(wanted_ * columns);
  for (std::size_t rank = 0; rank < in.size(); ++rank)
    for (std::size_t k = 0; k < place_[rank].size(); ++k)
      std::copy_n(in[rank].begin() + static_cast<std::ptrdiff_t>(k * columns), columns,
                  values.begin() + static_cast<std::ptrdiff_t>(place_[rank][k] * columns));
  return values;
}

}  // namespace trackbed::io
