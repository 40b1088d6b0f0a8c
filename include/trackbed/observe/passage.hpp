// Histories of a train on a track alone: stored in memory and written once, at the end. A passage
// has a few thousand rows of a few dozen numbers.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trackbed/io/archive.hpp"
#include "trackbed/observe/passage_envelope.hpp"
#include "trackbed/observe/results.hpp"
#include "trackbed/par/comm.hpp"
#include "trackbed/track/passage.hpp"

namespace trackbed::observe {

class PassageHistories {
 public:
  // Rail displacements at `points` (m); the sleepers nearest to them, each once, if there are any;
  // `forces`: number of forces on the rail.
  PassageHistories(const track::Line& line, const track::Train& train, std::vector<double> points,
                   std::size_t forces = 0);
  // Adds a row. Local.
  void sample(const track::Passage& passage);
  // Updates the extremes with the present step, which has a row only if it is sampled. Local.
  void update_extremes(const track::Passage& passage);
  std::int64_t rows() const { return static_cast<std::int64_t>(times_.size()); }
  // Over all steps: lowest rail displacement at each point, m, left before right; at most 0.
  const std::vector<double>& lowest() const { return lowest_; }
  void archive(io::Archive& a);  // rows and extremes
  // Writes results.h5 at `path` and replaces an existing file. Collective; throws RunError.
  void write(const par::Comm& comm, const std::string& path, const About& about);

 private:
  // One dataset: rows of `width` numbers.
  struct Column {
    std::string path;
    io::Label label;
    std::size_t width;
    std::vector<double> values;
  };
  void put(std::size_t column, double value) { columns_[column].values.push_back(value); }

  const track::Line& line_;
  const track::Train& train_;
  std::vector<double> points_;
  std::size_t forces_;
  std::vector<std::size_t> sleepers_;
  std::vector<double> times_, lowest_;
  PassageEnvelope envelope_;
  std::vector<Column> columns_;
};

}  // namespace trackbed::observe
