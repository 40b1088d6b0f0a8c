// Quantities and histories as stored in a checkpoint, for loading a run and for repeating a cell.
#pragma once

#include <string>
#include <vector>

#include "dem/state/state.hpp"
#include "trackbed/io/file.hpp"

namespace trackbed::dem {

// Rows of `columns` numbers from an array of numbers or Vec4. `rows` are the own particles; ghosts
// after them belong to other ranks. Of a Vec4 only the first numbers are the quantity: w of
// position and velocity holds radius and mass, which are derived.
template <class T>
std::vector<T> flat(const std::vector<T>& array, std::size_t rows, int) {
  return {array.begin(), array.begin() + static_cast<std::ptrdiff_t>(rows)};
}
inline std::vector<double> flat(const std::vector<Vec4>& array, std::size_t rows, int columns) {
  std::vector<double> numbers;
  for (std::size_t b = 0; b < rows; ++b) {
    const double four[] = {array[b].x, array[b].y, array[b].z, array[b].w};
    numbers.insert(numbers.end(), four, four + columns);
  }
  return numbers;
}
template <class T>
void unflatten(const std::vector<T>& numbers, std::vector<T>& array, int) {
  array = numbers;
}
inline void unflatten(const std::vector<double>& numbers, std::vector<Vec4>& array, int columns) {
  const auto n = static_cast<std::size_t>(columns);
  array.assign(numbers.size() / n, Vec4{});
  for (std::size_t b = 0; b < array.size(); ++b) {
    double* const four[] = {&array[b].x, &array[b].y, &array[b].z, &array[b].w};
    for (std::size_t k = 0; k < n; ++k) *four[k] = numbers[b * n + k];
  }
}

// False for quantities that older files lack: they have neither held particles nor fragments.
inline bool is_stored(const io::File& file, const std::string& path) {
  const bool lacks = path.ends_with("/held") || path.ends_with("/part");
  return !lacks || file.has(path);
}
inline void fill_unstored(State& state) {
  state.held.resize(state.id.size(), 0);
  state.part.resize(state.id.size(), 0);
}

// The type stored in a file for an array of T.
template <class T>
struct Number {
  using type = T;
};
template <>
struct Number<Vec4> {
  using type = double;
};

// All of them on every rank, or the rank's even part; numbers of surfaces refer to the file's
// names. Collective.
enum class Rows { all, part };
std::vector<History> read_histories(const io::File& file, const std::string& group, Rows rows);
std::vector<std::string> read_surface_names(const io::File& file, const std::string& group);

}  // namespace trackbed::dem
