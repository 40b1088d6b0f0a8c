#include "trackbed/io/archive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "trackbed/core/error.hpp"

namespace trackbed::io {

template <class T>
void Archive::write(const std::string& name, std::span<T> values, std::size_t columns,
                    const Label& label) {
  out_->write<T>(group_ + name, values.first(comm_->root() ? values.size() : 0), columns, label);
}

namespace {

// Decks are compared before: the shape differs where a file is damaged but its deck is not.
std::string other_shape(const std::string& path, std::size_t stored, const char* unit,
                        std::size_t expected) {
  return fmt::format(
      "dataset {} of the checkpoint has {} {}, but the model has {}: the checkpoint is damaged; "
      "continue from another checkpoint",
      path, stored, unit, expected);
}

}  // namespace

template <class T>
void Archive::fixed(const std::string& name, std::span<T> values, std::size_t columns,
                    const Label& label) {
  if (!reads()) return write(name, values, columns, label);
  const std::string path = group_ + name;
  const std::vector<std::size_t> stored = file_->extent(path);
  const std::size_t rows = values.size() / columns;
  if (stored.at(0) != rows) throw RunError(other_shape(path, stored[0], "rows", rows));
  if (stored.at(1) != columns) throw RunError(other_shape(path, stored[1], "columns", columns));
  const std::vector<T> found = file_->read_all<T>(path);
  std::copy(found.begin(), found.end(), values.begin());
}

template <class T>
void Archive::list(const std::string& name, std::vector<T>& values, const Label& label) {
  if (reads())
    values = file_->read_all<T>(group_ + name);
  else
    write(name, std::span(values), 1, label);
}

void Archive::operator()(const std::string& name, double& value, const Label& label) {
  fixed(name, std::span(&value, 1), 1, label);
}

void Archive::operator()(const std::string& name, std::int64_t& value, const Label& label) {
  fixed(name, std::span(&value, 1), 1, label);
}

void Archive::operator()(const std::string& name, Vec3& value, const Label& label) {
  table(name, {value.data(), 3}, 3, label);
}

void Archive::operator()(const std::string& name, Eigen::VectorXd& values, const Label& label) {
  table(name, {values.data(), static_cast<std::size_t>(values.size())}, 1, label);
}

void Archive::table(const std::string& name, std::span<double> values, std::size_t columns,
                    const Label& label) {
  fixed(name, values, columns, label);
}

void Archive::operator()(const std::string& name, std::vector<double>& values, const Label& label) {
  list(name, values, label);
}

// A dataset, since attributes of HDF5 are limited to 64 kB.
void Archive::operator()(const std::string& name, std::vector<std::string>& texts,
                         const Label& label) {
  std::vector<std::uint8_t> letters;
  for (const std::string& text : texts) {
    letters.insert(letters.end(), text.begin(), text.end());
    letters.push_back('\n');
  }
  list(name, letters, label);
  if (!reads()) return;
  texts.clear();
  std::istringstream lines(std::string(letters.begin(), letters.end()));
  for (std::string line; std::getline(lines, line);) texts.push_back(line);
}

}  // namespace trackbed::io
