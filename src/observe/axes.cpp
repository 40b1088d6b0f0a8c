// Axes of the histories and envelopes, as readers of netCDF expect them: in each group a dataset
// `time` (one and the same in all groups) and one for the columns: their positions along the track
// where these do not change, or their numbers from 0.
#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "observe/layout.hpp"

namespace trackbed::observe {

namespace {

// Axis of the columns of a dataset. The first row with this beginning of the path applies.
struct ColumnAxis {
  const char* of;
  // Positions, m, of which the first with one number per column becomes the axis `x`.
  std::array<const char*, 2> positions;
  const char* numbers;  // name of the axis without positions
  const char* meaning;
};

constexpr const char* of_axes = "x y z, of a quaternion x y z w";
constexpr const char* plain = "number, from 0";
constexpr std::array<const char*, 2> none{"", ""};

constexpr std::array column_axes = {
    ColumnAxis{"history/sleeper/moment", none, "place", "sleeper by sleeper, from left to right"},
    ColumnAxis{"history/sleeper", {"sleepers/x", ""}, "seat", plain},
    ColumnAxis{"history/ground", {"ground/x", "sleepers/x"}, "place", plain},
    ColumnAxis{"history/rail/force", none, "force_number", plain},
    ColumnAxis{"history/rail", {"rail/x", "sleepers/x"}, "seat", "left before right"},
    ColumnAxis{"history/wheel", none, "wheel", plain},
    ColumnAxis{"history/body", none, "vehicle", plain},
    ColumnAxis{"history/seat", none, "seat", "left before right"},
    ColumnAxis{"history/solid/bending_stress", none, "place", "seats, then middles of sleepers"},
    ColumnAxis{"history/solid", none, "seat", "left before right"},
    ColumnAxis{"history/region", none, "cell",
               "x fastest, then y; six values of a tensor for each"},
    ColumnAxis{"history", none, "component", of_axes},
    ColumnAxis{"envelope/ground", {"ground/x", ""}, "place", plain},
    ColumnAxis{"envelope", {"envelope/x", "sleepers/x"}, "place", plain},
    ColumnAxis{"extreme", {"rail/x", ""}, "place", plain}};

const ColumnAxis& column_axis_of(const std::string& path) {
  return *std::find_if(column_axes.begin(), column_axes.end(),
                       [&](const ColumnAxis& one) { return path.starts_with(one.of); });
}

bool has_length(const io::File& file, const std::string& path, std::size_t length) {
  return file.has(path) && file.extent(path).at(0) == length;
}

// The dataset that is the axis `name` of `group`: the same as `source`, or numbers if it is empty.
// Datasets of a group with different numbers of columns have different axes.
std::string axis_in(const par::Comm& comm, io::File& file, const std::string& path,
                    const std::string& source, const ColumnAxis& of, std::size_t length) {
  const std::size_t slash = path.rfind('/');
  const std::string group = path.substr(0, slash + 1);
  if (!source.empty()) {
    const std::string axis = group + source.substr(source.rfind('/') + 1);
    if (!file.has(axis)) file.link(axis, source);
    if (has_length(file, axis, length)) return axis;
  }
  std::string axis = group + of.numbers;
  if (file.has(axis) && !has_length(file, axis, length)) axis += "_of_" + path.substr(slash + 1);
  if (!file.has(axis)) {
    std::vector<std::int64_t> numbers(comm.root() ? length : 0);
    std::iota(numbers.begin(), numbers.end(), 0);
    file.write<std::int64_t>(axis, numbers, 1, {"-", of.meaning});
  }
  return axis;
}

void set_column_axis(const par::Comm& comm, io::File& file, const std::string& path,
                     std::size_t dimension, std::size_t length) {
  const ColumnAxis& of = column_axis_of(path);
  std::string source;
  for (const char* positions : of.positions)
    if (source.empty() && *positions != 0 && has_length(file, positions, length))
      source = positions;
  file.set_axis(path, dimension, axis_in(comm, file, path, source, of, length));
}

void set_axes_of_history(const par::Comm& comm, io::File& file, const std::string& path) {
  if (file.has_axis(path, 0)) return;
  const std::string time = path.substr(0, path.rfind('/')) + "/time";
  if (!file.has(time)) file.link(time, "history/time");
  file.set_axis(path, 0, time);
  const std::size_t width = file.extent(path).at(1);
  if (width > 1) set_column_axis(comm, file, path, 1, width);
}

}  // namespace

std::vector<std::string> members(const io::File& file, const std::string& group) {
  std::vector<std::string> paths;
  if (file.has(group))
    for (const std::string& name : file.names(group)) paths.push_back(group + "/" + name);
  return paths;
}

std::vector<std::string> columns(const io::File& file, const std::string& group) {
  std::vector<std::string> paths = members(file, group);
  std::erase_if(paths, [&](const std::string& path) { return file.is_axis(path); });
  return paths;
}

void set_axes(const par::Comm& comm, io::File& file) {
  if (!file.has("history/time")) return;
  std::vector<std::string> groups(plain_histories.begin(), plain_histories.end());
  for (const char* list : named_histories)
    for (const std::string& group : members(file, list)) groups.push_back(group);
  if (file.has("history/stage")) file.set_axis("history/stage", 0, "history/time");
  for (const std::string& group : groups)
    for (const std::string& path : columns(file, group)) set_axes_of_history(comm, file, path);
  for (const char* group : {"envelope/sleeper", "envelope/ground", "envelope/rail", "extreme/rail"})
    for (const std::string& path : columns(file, group))
      if (!file.has_axis(path, 0)) set_column_axis(comm, file, path, 0, file.extent(path).at(0));
}

}  // namespace trackbed::observe
