// Adds a row to columns. Private to the module.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "trackbed/fem/ground.hpp"
#include "trackbed/observe/column.hpp"

namespace trackbed::observe {

// Columns are created at the first row and filled in the same order at each row.
class ColumnWriter {
 public:
  explicit ColumnWriter(std::vector<Column>& columns)
      : columns_(columns), creates_(columns.empty()), next_(0) {}

  void put(const std::string& path, const io::Label& label, std::span<const double> numbers) {
    if (creates_) columns_.push_back({path, label, numbers.size()});
    Column& column = columns_[next_++];
    column.values.insert(column.values.end(), numbers.begin(), numbers.end());
  }
  void put(const std::string& path, const io::Label& label, double number) {
    put(path, label, std::span<const double>(&number, 1));
  }
  void put(const std::string& path, const io::Label& label, const Vec3& value) {
    put(path, label, std::span<const double>(value.data(), 3));
  }

 private:
  std::vector<Column>& columns_;
  bool creates_;
  std::size_t next_;
};

// Of a ground, relative to static equilibrium.
void put_energies(const fem::GroundEnergies& energies, ColumnWriter& to);

}  // namespace trackbed::observe
