// Axes of the histories, envelopes and tables of stages, as readers of netCDF expect them: in each
// group a dataset `time` (one and the same in all groups of histories) and one for the columns:
// their positions along the track where these do not change, or their numbers from 0.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>

#include "observe/layout.hpp"

namespace trackbed::observe {

namespace {

// Axis of the columns of the datasets `name` (empty: all) in a group or in the groups below it. The
// first row that fits applies.
struct ColumnAxis {
  const char *group, *name;
  // Positions, m, of which the first with one number per column becomes the axis `x`.
  std::array<const char*, 2> positions;
  const char* numbers;  // name of the axis without positions, or where a position occurs twice
  const char* order;    // of the columns
};

constexpr std::array<const char*, 2> none{"", ""};
constexpr const char* along =
    "along the track; with two rails, two columns for each place: left, then "
    "right";
constexpr const char* of_sleepers = "sleeper by sleeper, left before right";
constexpr const char* of_cells = "xx yy zz xy xz yz of the first cell, then of the next";

constexpr std::array column_axes = {
    ColumnAxis{
        "history/sleeper", "moment", none, "section",
        "of each sleeper: below the left rail, in the middle, below the right rail (half sleeper: "
        "only the first two)"},
    ColumnAxis{"history/sleeper", "", {"sleepers/x", ""}, "place", along},
    ColumnAxis{"history/ground", "", {"ground/x", "sleepers/x"}, "place", along},
    ColumnAxis{"history/rail", "force", none, "force_number", "as [[force]] in the deck"},
    ColumnAxis{"history/rail", "", {"rail/x", "sleepers/x"}, "place", along},
    ColumnAxis{"history/wheel", "", none, "wheel", "front first; on two rails left before right"},
    ColumnAxis{"history/body", "", none, "vehicle", "front first"},
    ColumnAxis{"history/seat", "", none, "place", of_sleepers},
    ColumnAxis{"history/solid", "bending_stress", none, "section",
               "of each sleeper: below its seats in the order of the deck, then in its middle"},
    ColumnAxis{"history/solid", "", none, "solid_seat",
               "of each sleeper: its seats in the order of the deck"},
    ColumnAxis{"history/region", "stress", none, "cell_component", of_cells},
    ColumnAxis{"history/region", "fabric", none, "cell_component", of_cells},
    ColumnAxis{"history/region", "", none, "cell", "x fastest, then y"},
    ColumnAxis{"history/sensor", "stress", none, "stress_component", "xx yy zz xy xz yz"},
    ColumnAxis{"history/sensor", "stress_static", none, "stress_component", "xx yy zz xy xz yz"},
    ColumnAxis{"history", "attitude", none, "quaternion", "x y z w"},
    ColumnAxis{"history", "", none, "component", "x y z"},
    ColumnAxis{"envelope/ground", "", {"ground/x", ""}, "place", along},
    ColumnAxis{"envelope", "", {"envelope/x", "sleepers/x"}, "place", along},
    ColumnAxis{"extreme", "", {"rail/x", ""}, "place", along}};

// "history/wheel/" and "force" of "history/wheel/force".
struct Place {
  std::string group, name;
  explicit Place(const std::string& path)
      : group(path.substr(0, path.rfind('/') + 1)), name(path.substr(path.rfind('/') + 1)) {}
};

const ColumnAxis& column_axis_of(const Place& at) {
  return *std::find_if(column_axes.begin(), column_axes.end(), [&](const ColumnAxis& one) {
    return at.group.starts_with(std::string(one.group) + "/") &&
           (*one.name == 0 || at.name == one.name);
  });
}

// Positions of `length` columns, or nothing.
std::string positions_of(const io::File& file, const ColumnAxis& of, std::size_t length) {
  for (const char* path : of.positions)
    if (*path != 0 && file.has(path) && file.extent(path).at(0) == length) return path;
  return "";
}

// A coordinate must be unique to select by it.
bool is_unique(const io::File& file, const std::string& positions) {
  std::vector<double> x = file.read_all<double>(positions);
  std::sort(x.begin(), x.end());
  return std::adjacent_find(x.begin(), x.end()) == x.end();
}

std::string link_in(io::File& file, const std::string& group, const std::string& source) {
  std::string path = group + Place(source).name;
  if (!file.has(path)) file.link(path, source);
  return path;
}

// Each rank writes its part: contacts may be more than one rank can hold.
std::string numbers_in(const par::Comm& comm, io::File& file, const std::string& group,
                       const char* name, const char* order, std::size_t length) {
  std::string path = group + name;
  if (file.has(path)) return path;
  const auto [begin, count] = io::row_range(length, comm.rank(), comm.size());
  std::vector<std::int64_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), static_cast<std::int64_t>(begin));
  file.write<std::int64_t>(path, numbers, 1,
                           {"-", std::string("index, counted from 0; order: ") + order});
  return path;
}

// Positions that occur twice are not the axis but have the same axis as the columns. A single
// column has no dimension of its own; its position is in the group all the same.
void set_column_axis(const par::Comm& comm, io::File& file, const std::string& path,
                     std::size_t dimension, std::size_t length) {
  const Place at(path);
  const ColumnAxis& of = column_axis_of(at);
  const std::string source = positions_of(file, of, length);
  const std::string x = source.empty() ? "" : link_in(file, at.group, source);
  const bool single = length == 1 && dimension == 1;
  if (!x.empty() && is_unique(file, source)) {
    file.make_axis(x);
    if (!single) file.set_axis(path, dimension, x);
  } else if (!single) {
    const std::string numbers = numbers_in(comm, file, at.group, of.numbers, of.order, length);
    file.set_axis(path, dimension, numbers);
    if (!x.empty() && !file.has_axis(x, 0)) file.set_axis(x, 0, numbers);
  }
}

}  // namespace

std::vector<std::string> members(const io::File& file, const std::string& group) {
  std::vector<std::string> paths;
  if (file.has(group))
    for (const std::string& name : file.names(group)) paths.push_back(group + "/" + name);
  return paths;
}

// Links to positions that are no axes, as they occur twice, are those of `column_axes`.
std::vector<std::string> columns(const io::File& file, const std::string& group) {
  std::vector<std::string> paths = members(file, group);
  std::erase_if(paths, [&](const std::string& path) {
    return file.is_axis(path) || (path.ends_with("/x") && !path.starts_with("history/wheel/"));
  });
  return paths;
}

std::vector<std::string> histories(const io::File& file) {
  std::vector<std::string> paths;
  const auto add = [&](const std::string& group) {
    for (std::string& path : columns(file, group)) paths.push_back(std::move(path));
  };
  for (const char* group : plain_histories) add(group);
  for (const char* list : named_histories)
    for (const std::string& group : members(file, list)) add(group);
  return paths;
}

void set_axes_of_history(const par::Comm& comm, io::File& file, const std::string& path) {
  if (path == "history/time") return file.make_axis(path);
  const Place at(path);
  const std::string time =
      at.group == "history/" ? "history/time" : link_in(file, at.group, "history/time");
  file.set_axis(path, 0, time);
  if (at.group != "history/") set_column_axis(comm, file, path, 1, file.extent(path).at(1));
}

void set_axis_of_envelope(const par::Comm& comm, io::File& file, const std::string& path) {
  set_column_axis(comm, file, path, 0, file.extent(path).at(0));
}

void set_axes_of_snapshot(const par::Comm& comm, io::File& file, const std::string& stage) {
  // Names of the axes of a table, and the order of its columns; only rows for a list of numbers.
  struct Axes {
    const char *table, *rows, *columns = "", *order = "";
  };
  constexpr std::array tables = {
      Axes{"chains/%/segments", "contact", "end", "x0 z0 x1 z1"},
      Axes{"chains/%/force", "contact"},
      Axes{"stones/%/centre", "pebble", "component", "x z"},
      Axes{"stones/%/radius", "pebble"},
      Axes{"stones/%/sieved", "stone", "property", "sieve, mass"},
      Axes{"surface/%/top", "cell", "component", "x y z"},
      Axes{"bonds/%/whole", "bond", "bond_property",
           "both stones, kind, x, y, z, force, utilisation, damage"},
      Axes{"bonds/%/broken", "broken_bond", "break_property",
           "time, both stones, kind, by shear, x, y, z, tensile stress, shear stress, energy"}};
  for (const Axes& axes : tables) {
    std::string path = axes.table;
    path.replace(path.find('%'), 1, stage);
    if (!file.has(path)) continue;
    const auto set = [&](std::size_t dimension, const char* name, const char* order) {
      const std::size_t length = file.extent(path).at(dimension);
      file.set_axis(path, dimension,
                    numbers_in(comm, file, Place(path).group, name, order, length));
    };
    set(0, axes.rows, "that of the file");
    if (*axes.columns != 0) set(1, axes.columns, axes.order);
  }
}

void set_axes(const par::Comm& comm, io::File& file) {
  if (!file.has("history/time")) return;
  for (const char* path : {"history/time", "history/stage"})
    if (file.has(path)) set_axes_of_history(comm, file, path);
  for (const std::string& path : histories(file)) set_axes_of_history(comm, file, path);
  for (const char* group : {"envelope/sleeper", "envelope/ground", "envelope/rail", "extreme/rail"})
    for (const std::string& path : columns(file, group)) set_axis_of_envelope(comm, file, path);
}

void name_stages(io::File& file, const std::vector<std::string>& names) {
  const std::string meanings = fmt::format("{}", fmt::join(names, " "));
  const bool known = file.has_attribute("history/stage", "flag_meanings") &&
                     file.text_attribute("history/stage", "flag_meanings") == meanings;
  if (names.empty() || known) return;  // a resume may have other names of later stages
  std::vector<std::int64_t> numbers(names.size());
  std::iota(numbers.begin(), numbers.end(), std::int64_t{0});
  file.attribute("history/stage", "flag_values", numbers);
  file.attribute("history/stage", "flag_meanings", meanings);
}

}  // namespace trackbed::observe
