// Particles in a checkpoint: the listed state, the templates and the contact history, each row
// once. Every rank writes its rows and reads a fraction of them, in parallel; templates are
// read by all. The order of rows does not matter: histories are sent to the ranks that have read
// their particles, and particles with their histories to their owners at the next rebuild. Derived
// quantities (mass, inertia, spin, radius) are not stored, so they cannot be inconsistent. Lists
// are not stored either: they do not affect results.
#include <algorithm>

#include "dem/particles/impl.hpp"
#include "dem/state/rendezvous.hpp"
#include "dem/state/stored.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/dem/templates.hpp"

namespace trackbed::dem {

// Collective. May be called at any time between windows, also before new lists exist: waiting
// histories are written like those in the lists.
void Particles::save(io::File& file, const std::string& group) const {
  Impl& r = *impl_;
  visit_state(r.state, [&](auto quantity, const auto& array) {
    using T = typename Number<std::decay_t<decltype(array[0])>>::type;
    const auto numbers = flat(array, r.state.own, quantity.columns);
    file.write<T>(group + "/" + quantity.name, numbers, quantity.columns,
                  {quantity.unit, quantity.meaning});
  });
  save_templates(file, group + "/template", r.shapes.templates(), r.comm);
  std::vector<std::int64_t> keys;
  std::vector<double> xi, size, roll;
  const auto end = r.state.id.begin() + static_cast<std::ptrdiff_t>(r.state.own);
  for (const std::vector<History>& records : {r.history(), r.waiting})
    for (const History& h : records)
      // Both ranks of a contact have its history; the owner of the first particle writes it. Own
      // particles are in the order of ids.
      if (std::binary_search(r.state.id.begin(), end, particle_of(h.first))) {
        keys.insert(keys.end(), {h.first, h.second});
        xi.insert(xi.end(), {h.xi[0], h.xi[1], h.xi[2], h.turn});
        size.insert(size.end(), {h.size, h.ring});
        roll.insert(roll.end(), h.roll, h.roll + 3);
      }
  file.write<std::int64_t>(group + "/history/keys", keys, 2,
                           {"-",
                            "columns: key of a piece (particle id * 65536 + piece); key of the "
                            "other piece, or of a patch of a surface, "
                            "-1 - (surface number * 2^32 + patch)"});
  file.write<double>(
      group + "/history/xi", xi, 4,
      {"m, m, m, rad", "tangential displacement x y z, relative rotation about the normal"});
  file.write<double>(
      group + "/history/size", size, 2,
      {"m, m3",
       "column 1: contact size a = sqrt(R delta), m, at the time when the displacement was stored "
       "(linear law: 1); column 2: a times the mean of d^2, m3 (linear law: m2), where d is the "
       "distance of a contact point from the normal through the centre of the contact"});
  if (r.laws.any_rolls())
    file.write<double>(group + "/history/roll", roll, 3,
                       {"m", "displacement of rolling x y z; missing without rolling resistance"});
  for (std::size_t n = 0; n < r.names.size(); ++n)
    file.attribute(group, "surface_" + std::to_string(n), r.names[n]);
  file.attribute(group, "surfaces", static_cast<std::int64_t>(r.names.size()));
  file.attribute(group, "steps", r.steps);
  file.attribute(group, "elapsed", r.elapsed);
  file.attribute(group, "rebuilds", r.rebuilds);
  file.attribute(group, "local_damping", r.local_damping);
  file.attribute(group, "growing", r.state.growing);
  file.attribute(group, "grown", r.state.grown);
  file.attribute(group, "load_quantum", r.load_quantum);
  file.attribute(group, "removed_friction", r.removed.friction);
  file.attribute(group, "removed_contact_damping", r.removed.contact_damping);
  file.attribute(group, "removed_local_damping", r.removed.local_damping);
  file.attribute(group, "removed_supplied", r.removed.supplied);
  r.save_breakage(file, group);
  r.save_bonds(file, group);
}

// A run without rolling resistance wrote no rolling displacements: they begin at zero.
std::vector<History> read_histories(const io::File& file, const std::string& group, Rows rows) {
  const auto numbers = [&](const char* name) {
    const std::string path = group + "/history/" + name;
    return rows == Rows::all ? file.read_all<double>(path) : file.read_own_rows<double>(path);
  };
  const std::string pairs = group + "/history/keys";
  const auto keys = rows == Rows::all ? file.read_all<std::int64_t>(pairs)
                                      : file.read_own_rows<std::int64_t>(pairs);
  const auto xi = numbers("xi"), size = numbers("size");
  auto roll = file.has(group + "/history/roll") ? numbers("roll") : std::vector<double>{};
  roll.resize(3 * keys.size() / 2, 0.0);
  std::vector<History> all;
  for (std::size_t k = 0; 2 * k < keys.size(); ++k)
    all.push_back({keys[2 * k],
                   keys[2 * k + 1],
                   {xi[4 * k], xi[4 * k + 1], xi[4 * k + 2]},
                   xi[4 * k + 3],
                   size[2 * k],
                   size[2 * k + 1],
                   {roll[3 * k], roll[3 * k + 1], roll[3 * k + 2]}});
  return all;
}

std::vector<std::string> read_surface_names(const io::File& file, const std::string& group) {
  std::vector<std::string> names;
  for (std::int64_t n = 0; n < file.integer_attribute(group, "surfaces"); ++n)
    names.push_back(file.text_attribute(group, "surface_" + std::to_string(n)));
  return names;
}

// Collective; any number of ranks. Replaces particles, templates and names of surfaces, so surfaces
// must be set again afterwards: their histories refer to these names by number.
void Particles::load(const io::File& file, const std::string& group) {
  Impl& r = *impl_;
  r.shapes = {};
  r.load_shapes(file, group);
  visit_state(r.state, [&](auto quantity, auto& array) {
    using T = typename Number<std::decay_t<decltype(array[0])>>::type;
    const std::string path = group + "/" + quantity.name;
    if (is_stored(file, path)) unflatten(file.read_own_rows<T>(path), array, quantity.columns);
  });
  fill_unstored(r.state);
  r.state.growing = file.integer_attribute(group, "growing");
  r.state.grown = file.number_attribute(group, "grown");
  r.steps = file.integer_attribute(group, "steps");
  r.elapsed = file.number_attribute(group, "elapsed");
  // A fraction by number of rows, not by position; the rebuild sends each particle to its owner.
  r.state.own = r.state.id.size();
  r.sort_own();
  r.derive(0);
  r.forget_contacts();
  r.waiting = delivered(
      r.comm, std::span(r.state.id), read_histories(file, group, Rows::part), [](const History& h) {
        return std::array{particle_of(h.first), h.second >= 0 ? particle_of(h.second) : Id{-1}};
      });
  r.names = read_surface_names(file, group);
  r.load_breakage(file, group);
  r.load_bonds(file, group);
  r.rebuilds = file.integer_attribute(group, "rebuilds");
  r.local_damping = file.number_attribute(group, "local_damping");
  r.load_quantum = file.number_attribute(group, "load_quantum");
  r.removed = {file.number_attribute(group, "removed_friction"),
               file.number_attribute(group, "removed_contact_damping"),
               file.number_attribute(group, "removed_local_damping"),
               file.number_attribute(group, "removed_supplied")};
  // Last: the work of the first partition is counted from the waiting histories.
  r.choose_grid(r.work());
}

}  // namespace trackbed::dem
