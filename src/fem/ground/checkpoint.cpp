// The state of the ground in a checkpoint: one row per node, identified by its number in the
// lattice, so that a checkpoint can be read on any number of ranks.
//
// The file contains State and the number of steps: mesh, operators and borders follow from the
// deck. Collective.
#include <fmt/format.h>

#include <algorithm>

#include "fem/ground/impl.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/io/numbered_rows.hpp"

namespace trackbed::fem {

// The order in which datasets are written; they are read by name.
void State::list(const Visit& visit) {
  visit("displacement", "m", "deviation from static equilibrium", displacement);
  visit("velocity", "m/s", "at the time of the checkpoint", velocity);
  visit("acceleration", "m/s^2", "at the end of the last window", acceleration);
  visit("internal", "N",
        "internal nodal forces of the present displacements; with implicit steps those of the last "
        "predictor",
        internal);
  visit("load", "N", "top load of the last window minus that in static equilibrium", load);
  visit("settled", "N", "top load in static equilibrium", settled);
  visit("offset", "m",
        "displacement at the time of the last static equilibrium; it is part of the shape of the "
        "surface from then on and not of `displacement`",
        offset);
  visit("rest", "m",
        "static displacement under the weight and the top load in static equilibrium (`settled`)",
        static_displacement);
  if (one_before.of[0].empty()) return;
  visit("acceleration_one_before", "m/s^2",
        "at the end of the last but one window (only with implicit steps)", one_before);
  visit("acceleration_two_before", "m/s^2",
        "at the end of the third last window (only with implicit steps)", two_before);
}

namespace {

// Yielding elements, each written once with its number.
void save_plasticity(Plasticity& plasticity, const Mesh& mesh, io::File& file,
                     const std::string& group) {
  std::vector<std::int64_t> names;
  std::vector<std::size_t> rows;
  for (std::size_t n = 0; n < plasticity.elements().size(); ++n) {
    const std::size_t element = plasticity.elements()[n];
    if (!mesh.writes(element)) continue;
    names.push_back(mesh.element[element]);
    rows.push_back(n);
  }
  file.write<std::int64_t>(group + "/plastic/element", names, 1,
                           {"-", "global number of the element"});
  plasticity.list([&](const char* name, const char* unit, const char* meaning, std::size_t width,
                      std::vector<double>& values) {
    std::vector<double> mine;
    for (const std::size_t row : rows)
      for (std::size_t c = 0; c < width; ++c) mine.push_back(values[row * width + c]);
    file.write<double>(group + "/" + name, mine, width, {unit, meaning});
  });
}

// A rank holds elements at its borders that others write.
void load_plasticity(Plasticity& plasticity, const Mesh& mesh, const io::File& file,
                     const std::string& group) {
  std::vector<std::int64_t> names;
  for (const std::size_t element : plasticity.elements()) names.push_back(mesh.element[element]);
  const io::NumberedRows rows(mesh.comm, file, group + "/plastic/element", names);
  plasticity.list([&](const char* name, const char*, const char*, std::size_t width,
                      std::vector<double>& values) {
    const auto stored = rows.read(group + "/" + name, width);
    std::copy(stored.begin(), stored.end(), values.begin());  // which may be padded
  });
  plasticity.loaded();
}

// As save_plasticity: elements by number.
void save_extremes(const Extremes& extremes, const Mesh& mesh, io::File& file,
                   const std::string& group) {
  std::vector<std::int64_t> names;
  std::vector<double> rows;
  for (std::size_t z = 0; z < mesh.element.size(); ++z) {
    if (!mesh.writes(z)) continue;
    names.push_back(mesh.element[z]);
    for (std::size_t q = 0; q < Extremes::count; ++q)
      rows.push_back(extremes.values[z * Extremes::count + q]);
  }
  file.write<std::int64_t>(group + "/extremes/element", names, 1,
                           {"-", "global number of the element"});
  file.write<double>(
      group + "/extremes/stress", rows, Extremes::count,
      {"Pa", "largest and least principal, largest shear, largest and least vertical up to now"});
}

void load_extremes(Extremes& extremes, const Mesh& mesh, const io::File& file,
                   const std::string& group) {
  const io::NumberedRows rows(mesh.comm, file, group + "/extremes/element", mesh.element);
  extremes.values = rows.read(group + "/extremes/stress", Extremes::count);
}

}  // namespace

// Own nodes only: every node of the model is in the file once.
void Ground::save(io::File& file, const std::string& group) const {
  const Mesh& mesh = impl_->mesh;
  const int components = impl_->components();
  std::vector<std::int64_t> names;
  for (const std::int32_t n : mesh.own) names.push_back(mesh.node[static_cast<std::size_t>(n)]);
  file.write<std::int64_t>(group + "/node", names, 1, {"-", "global number of the node"});
  impl_->state.list([&](const char* name, const char* unit, const char* meaning, Nodal& values) {
    std::vector<double> rows;
    for (const std::int32_t n : mesh.own)
      for (int c = 0; c < components; ++c) rows.push_back(values[c][n]);
    file.write<double>(group + "/" + name, rows, static_cast<std::size_t>(components),
                       {unit, meaning});
  });
  file.attribute(group, "steps", impl_->steps);
  if (impl_->plasticity) save_plasticity(*impl_->plasticity, mesh, file, group);
  if (impl_->extremes) save_extremes(*impl_->extremes, mesh, file, group);
  if (!impl_->free_field) return;
  // The free-field columns are the same on every rank: the first rank writes them.
  const std::string beside = group + "/free_field";
  file.write<double>(beside + "/time",
                     mesh.comm.root() ? std::vector<double>{impl_->time} : std::vector<double>{}, 1,
                     {"s", "time since the ground started to move"});
  impl_->free_field->list([&](const char* name, const char* unit, std::vector<double>& values) {
    if (values.empty()) return;  // no columns: sides of another kind
    file.write<double>(beside + "/" + name, mesh.comm.root() ? values : std::vector<double>{}, 1,
                       {unit, "of the columns beside the model, from the base up"});
  });
}

void Ground::load(const io::File& file, const std::string& group) {
  Mesh& mesh = impl_->mesh;
  const auto components = static_cast<std::size_t>(impl_->components());
  const std::size_t total = file.extent(group + "/node")[0];
  if (total != static_cast<std::size_t>(mesh.node_count()))
    throw RunError(
        fmt::format("the ground in the checkpoint has {} nodes, but that of the deck has {}; give "
                    "the deck the ground with which the checkpoint was written",
                    total, mesh.node_count()));
  std::vector<std::int64_t> names;
  for (const std::int32_t n : mesh.own) names.push_back(mesh.node[static_cast<std::size_t>(n)]);
  const io::NumberedRows rows(mesh.comm, file, group + "/node", names);
  impl_->state.list([&](const char* name, const char*, const char*, Nodal& values) {
    // An explicit run that continues with implicit steps has no earlier accelerations.
    const bool guess = &values == &impl_->state.one_before || &values == &impl_->state.two_before;
    if (guess && !file.has(group + "/" + name)) return;
    const auto numbers = rows.read(group + "/" + name, components);
    for (std::size_t k = 0; k < mesh.own.size(); ++k)
      for (std::size_t c = 0; c < components; ++c)
        values[static_cast<int>(c)][mesh.own[k]] = numbers[k * components + c];
  });
  // Ghost displacements are set by refresh_surface; the other arrays are used on own nodes only.
  for (Nodal* values : {&impl_->state.offset, &impl_->state.static_displacement})
    mesh.exchange(*values);
  impl_->steps = file.integer_attribute(group, "steps");
  if (impl_->plasticity) load_plasticity(*impl_->plasticity, mesh, file, group);
  if (file.has(group + "/extremes/element")) {
    begin_extremes();
    load_extremes(*impl_->extremes, mesh, file, group);
  }
  if (impl_->free_field) {
    const std::string beside = group + "/free_field";
    impl_->time = file.read_rows<double>(beside + "/time", 0, 1)[0];
    impl_->free_field->list([&](const char* name, const char*, std::vector<double>& values) {
      if (!values.empty()) values = file.read_rows<double>(beside + "/" + name, 0, values.size());
    });
  }
  impl_->refresh_surface();
}

}  // namespace trackbed::fem
