// The state of the ground in a checkpoint: one row per node, named by its number in the lattice, so
// that any number of ranks reads what any number wrote.
//
// What is in the file is State and the count of steps: mesh, operators and borders follow from the
// deck. Collective.
#include <algorithm>

#include "room.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {
// Rows a rank looks at in one go: 8 MB of names.
constexpr std::size_t rows_at_once = 1u << 20;
}  // namespace

// The order of the datasets; who reads goes by names.
void State::list(const Visit& visit) {
  visit("displacement", "m", "deviation from the state of rest", displacement);
  visit("velocity", "m/s", "at the time of the checkpoint", velocity);
  visit("acceleration", "m/s^2", "at the end of the last window", acceleration);
  visit("internal", "N",
        "nodal force of the present deformation; implicit steps: of what the last one predicted",
        internal);
  visit("load", "N", "top load of the last window less the settled one", load);
  visit("settled", "N", "top load of the state of rest", settled);
  visit("offset", "m", "displacement when last settled, part of the shape", offset);
  visit("rest", "m", "static displacement under weight and settled load", rest);
  if (one_before.of[0].empty()) return;
  visit("acceleration_one_before", "m/s^2", "a window before the last one; implicit steps",
        one_before);
  visit("acceleration_two_before", "m/s^2", "two windows before the last one; implicit steps",
        two_before);
}

namespace {

// Zones that yield, each by its number and once.
void save_plasticity(Plasticity& plasticity, const Mesh& mesh, io::File& file,
                     const std::string& group) {
  std::vector<std::int64_t> names;
  std::vector<std::size_t> rows;
  for (std::size_t n = 0; n < plasticity.zones().size(); ++n) {
    const std::size_t zone = plasticity.zones()[n];
    if (!mesh.writes(zone)) continue;
    names.push_back(mesh.zone[zone]);
    rows.push_back(n);
  }
  file.write<std::int64_t>(group + "/plastic/zone", names, 1, {"-", "number in the lattice"});
  plasticity.list([&](const char* name, const char* unit, const char* meaning, std::size_t width,
                      std::vector<double>& values) {
    std::vector<double> mine;
    for (const std::size_t row : rows)
      for (std::size_t c = 0; c < width; ++c) mine.push_back(values[row * width + c]);
    file.write<double>(group + "/" + name, mine, width, {unit, meaning});
  });
}

// Every rank takes the zones it holds, those of its borders too.
void load_plasticity(Plasticity& plasticity, const Mesh& mesh, const io::File& file,
                     const std::string& group) {
  const std::size_t total = file.extent(group + "/plastic/zone")[0];
  constexpr std::size_t at_once = rows_at_once / 16;  // a row has up to 48 numbers
  for (std::size_t begin = 0; begin < total; begin += at_once) {
    const std::size_t count = std::min(at_once, total - begin);
    const auto names = file.read_rows<std::int64_t>(group + "/plastic/zone", begin, count);
    plasticity.list([&](const char* name, const char*, const char*, std::size_t width,
                        std::vector<double>& values) {
      const auto rows = file.read_rows<double>(group + "/" + name, begin, count);
      for (std::size_t r = 0; r < count; ++r) {
        const std::int64_t zone = mesh.local_zone(names[r]);
        if (zone < 0) continue;
        const std::int64_t number = plasticity.number(static_cast<std::size_t>(zone));
        if (number < 0) continue;
        std::copy_n(
            rows.begin() + static_cast<std::ptrdiff_t>(r * width), width,
            values.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(number) * width));
      }
    });
  }
  plasticity.loaded();
}

// As save_plasticity: zones by number.
void save_extremes(const Extremes& extremes, const Mesh& mesh, io::File& file,
                   const std::string& group) {
  std::vector<std::int64_t> names;
  std::vector<double> rows;
  for (std::size_t z = 0; z < mesh.zone.size(); ++z) {
    if (!mesh.writes(z)) continue;
    names.push_back(mesh.zone[z]);
    for (std::size_t q = 0; q < Extremes::count; ++q)
      rows.push_back(extremes.values[z * Extremes::count + q]);
  }
  file.write<std::int64_t>(group + "/extremes/zone", names, 1, {"-", "number in the lattice"});
  file.write<double>(
      group + "/extremes/stress", rows, Extremes::count,
      {"Pa", "most and least principal, most shear, most and least vertical so far"});
}

void load_extremes(Extremes& extremes, const Mesh& mesh, const io::File& file,
                   const std::string& group) {
  const std::size_t total = file.extent(group + "/extremes/zone")[0];
  for (std::size_t begin = 0; begin < total; begin += rows_at_once) {
    const std::size_t count = std::min(rows_at_once, total - begin);
    const auto names = file.read_rows<std::int64_t>(group + "/extremes/zone", begin, count);
    const auto rows = file.read_rows<double>(group + "/extremes/stress", begin, count);
    for (std::size_t r = 0; r < count; ++r) {
      const std::int64_t zone = mesh.local_zone(names[r]);
      if (zone < 0) continue;
      for (std::size_t q = 0; q < Extremes::count; ++q)
        extremes.values[static_cast<std::size_t>(zone) * Extremes::count + q] =
            rows[r * Extremes::count + q];
    }
  }
}

}  // namespace

// Own nodes only: every node of the model is in the file once.
void Ground::save(io::File& file, const std::string& group) const {
  const Mesh& mesh = room_->mesh;
  const int components = room_->components();
  std::vector<std::int64_t> names;
  for (const std::int32_t n : mesh.own) names.push_back(mesh.node[static_cast<std::size_t>(n)]);
  file.write<std::int64_t>(group + "/node", names, 1, {"-", "number in the lattice"});
  room_->state.list([&](const char* name, const char* unit, const char* meaning, Nodal& values) {
    std::vector<double> rows;
    for (const std::int32_t n : mesh.own)
      for (int c = 0; c < components; ++c) rows.push_back(values[c][n]);
    file.write<double>(group + "/" + name, rows, static_cast<std::size_t>(components),
                       {unit, meaning});
  });
  file.attribute(group, "steps", room_->steps);
  if (room_->plasticity) save_plasticity(*room_->plasticity, mesh, file, group);
  if (room_->extremes) save_extremes(*room_->extremes, mesh, file, group);
  if (!room_->free_field) return;
  // The columns beside the model are the same on every rank: the first one writes them.
  const std::string beside = group + "/free_field";
  file.write<double>(beside + "/time",
                     mesh.comm.root() ? std::vector<double>{room_->time} : std::vector<double>{}, 1,
                     {"s", "since the ground was let go"});
  room_->free_field->list([&](const char* name, const char* unit, std::vector<double>& values) {
    if (values.empty()) return;  // no columns: another kind of sides
    file.write<double>(beside + "/" + name, mesh.comm.root() ? values : std::vector<double>{}, 1,
                       {unit, "of the columns beside the model, from the base up"});
  });
}

// Each rank walks through all rows in pieces and keeps its own: memory stays bounded. Sorting rows
// to their owners first would read less per rank and is not worth it until that shows.
void Ground::load(const io::File& file, const std::string& group) {
  Mesh& mesh = room_->mesh;
  const auto components = static_cast<std::size_t>(room_->components());
  const std::size_t total = file.extent(group + "/node")[0];
  if (total != static_cast<std::size_t>(mesh.node_count()))
    throw RunError("the checkpoint holds a ground of " + std::to_string(total) +
                   " nodes, the deck one of " + std::to_string(mesh.node_count()));
  for (std::size_t begin = 0; begin < total; begin += rows_at_once) {
    const std::size_t count = std::min(rows_at_once, total - begin);
    const auto names = file.read_rows<std::int64_t>(group + "/node", begin, count);
    room_->state.list([&](const char* name, const char*, const char*, Nodal& values) {
      // An explicit run that goes on with implicit steps: its guesses start anew.
      const bool guess = &values == &room_->state.one_before || &values == &room_->state.two_before;
      if (guess && !file.has(group + "/" + name)) return;
      const auto rows = file.read_rows<double>(group + "/" + name, begin, count);
      for (std::size_t r = 0; r < count; ++r) {
        const std::int32_t n = mesh.local_node(names[r]);
        if (n < 0 || mesh.owned[static_cast<std::size_t>(n)] == 0) continue;
        for (std::size_t c = 0; c < components; ++c)
          values[static_cast<int>(c)][n] = rows[r * components + c];
      }
    });
  }
  // Displacement of ghosts comes with refresh_surface; the other arrays matter on own nodes only.
  for (Nodal* values : {&room_->state.offset, &room_->state.rest}) mesh.exchange(*values);
  room_->steps = file.integer_attribute(group, "steps");
  if (room_->plasticity) load_plasticity(*room_->plasticity, mesh, file, group);
  if (file.has(group + "/extremes/zone")) {
    begin_extremes();
    load_extremes(*room_->extremes, mesh, file, group);
  }
  if (room_->free_field) {
    const std::string beside = group + "/free_field";
    room_->time = file.read_rows<double>(beside + "/time", 0, 1)[0];
    room_->free_field->list([&](const char* name, const char*, std::vector<double>& values) {
      if (!values.empty()) values = file.read_rows<double>(beside + "/" + name, 0, values.size());
    });
  }
  room_->refresh_surface();
}

}  // namespace trackbed::fem
