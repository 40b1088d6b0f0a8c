#include "trackbed/io/named_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <compare>
#include <utility>

#include "trackbed/core/error.hpp"

namespace trackbed::io {

namespace {

using Lists = std::vector<std::vector<std::int64_t>>;  // one for each rank

// The rank's own list is not sent: one rank alone may have more than a message can hold.
template <class T>
std::vector<std::vector<T>> exchanged(const par::Comm& comm, std::vector<std::vector<T>> out) {
  const auto self = static_cast<std::size_t>(comm.rank());
  std::vector<T> own;
  own.swap(out[self]);
  auto in = comm.exchange(out);
  in[self] = std::move(own);
  return in;
}

// The rank whose part of the rows contains one, as row_range divides them.
std::size_t reader_of(std::size_t row, std::size_t rows, int ranks) {
  std::size_t low = 0, high = static_cast<std::size_t>(ranks) - 1;
  while (low < high) {
    const std::size_t middle = (low + high + 1) / 2;
    if (row_range(rows, static_cast<int>(middle), ranks).begin <= row)
      low = middle;
    else
      high = middle - 1;
  }
  return low;
}

struct Entry {
  std::int64_t number, row;
  auto operator<=>(const Entry&) const = default;
};

// The row of each wanted number, -1 if there is none.
std::vector<std::int64_t> rows_of(const par::Comm& comm, const std::vector<std::int64_t>& mine,
                                  std::size_t begin, std::span<const std::int64_t> wanted) {
  const auto ranks = static_cast<std::size_t>(comm.size());
  const auto knows = [&](std::int64_t number) { return static_cast<std::size_t>(number) % ranks; };
  std::vector<std::vector<Entry>> entries(ranks);
  for (std::size_t k = 0; k < mine.size(); ++k)
    entries[knows(mine[k])].push_back({mine[k], static_cast<std::int64_t>(begin + k)});
  std::vector<Entry> directory;
  for (const auto& list : exchanged(comm, std::move(entries)))
    directory.insert(directory.end(), list.begin(), list.end());
  std::sort(directory.begin(), directory.end());

  Lists asked(ranks);
  for (const std::int64_t number : wanted) asked[knows(number)].push_back(number);
  Lists answers = exchanged(comm, std::move(asked));
  for (auto& list : answers)
    for (std::int64_t& number : list) {
      const auto at = std::lower_bound(directory.begin(), directory.end(), Entry{number, 0});
      number = at != directory.end() && at->number == number ? at->row : -1;
    }
  answers = exchanged(comm, std::move(answers));
  std::vector<std::int64_t> found(wanted.size());
  std::vector<std::size_t> next(ranks, 0);
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    const std::size_t rank = knows(wanted[k]);
    found[k] = answers[rank][next[rank]++];
  }
  return found;
}

}  // namespace

NamedRows::NamedRows(const par::Comm& comm, const File& file, const std::string& numbers,
                     std::span<const std::int64_t> wanted)
    : comm_(comm), file_(&file), rows_(file.extent(numbers)[0]), wanted_(wanted.size()) {
  const auto ranks = static_cast<std::size_t>(comm.size());
  const std::size_t begin = row_range(rows_, comm.rank(), comm.size()).begin;
  const auto found = rows_of(comm, file.read_own_rows<std::int64_t>(numbers), begin, wanted);
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
    const std::size_t reader = reader_of(static_cast<std::size_t>(found[k]), rows_, comm.size());
    asks[reader].push_back(found[k]);
    place_[reader].push_back(k);
  }
  const Lists in = exchanged(comm, std::move(asks));
  for (std::size_t rank = 0; rank < ranks; ++rank)
    for (const std::int64_t row : in[rank])
      asked_[rank].push_back(static_cast<std::size_t>(row) - begin);
}

std::vector<double> NamedRows::read(const std::string& path, std::size_t columns) const {
  const auto extent = file_->extent(path);
  if (extent[0] != rows_ || extent[1] != columns)
    throw RunError(
        fmt::format("dataset {} has {} rows of {} values, not {} of {}; use an earlier "
                    "checkpoint",
                    path, extent[0], extent[1], rows_, columns));
  const auto mine = file_->read_own_rows<double>(path);
  std::vector<std::vector<double>> out(asked_.size());
  for (std::size_t rank = 0; rank < out.size(); ++rank) {
    out[rank].reserve(asked_[rank].size() * columns);
    for (const std::size_t row : asked_[rank])
      for (std::size_t c = 0; c < columns; ++c) out[rank].push_back(mine[row * columns + c]);
  }
  const auto in = exchanged(comm_, std::move(out));
  std::vector<double> values(wanted_ * columns);
  for (std::size_t rank = 0; rank < in.size(); ++rank)
    for (std::size_t k = 0; k < place_[rank].size(); ++k)
      std::copy_n(in[rank].begin() + static_cast<std::ptrdiff_t>(k * columns), columns,
                  values.begin() + static_cast<std::ptrdiff_t>(place_[rank][k] * columns));
  return values;
}

}  // namespace trackbed::io
