// Public interface: construction, adding and removing particles, surfaces, the time window.
#include "trackbed/dem/particles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "dem/particles/impl.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/exact_sum.hpp"
#include "trackbed/dem/stiffness.hpp"

namespace trackbed::dem {

void Parameters::declare(input::Section& s) {
  s.number("skin", skin, {.unit = "m", .at_least = 0},
           "Verlet skin: distance beyond contact up to which neighbour lists contain pairs; 0: 0.3 "
           "times the smallest particle's radius, or 0.15 times if stones have corners. The skin "
           "changes the speed of the program, not its results.");
  s.number(
      "rebalance", rebalance, {.unit = "-", .at_least = 0},
      "Stones are redistributed if the work of the busiest rank divided by the mean work of all "
      "ranks exceeds this value; 0: never. It changes the speed of the program, not its results.");
  // A collision takes pi/safety sub-steps: 6 hardly resolve it, 3000 only cost time.
  s.number("safety", safety,
           {.unit = "-", .above = 0, .at_most = 1, .usually_from = 1e-3, .usually_to = 0.5},
           "Safety factor: longest sub-step divided by sqrt(m/k) of the lightest particle and the "
           "stiffest contact. If the damping ratio of a contact law exceeds 1 (hertz, restitution "
           "below about 0.15), the sub-step is also divided by this ratio.");
  s.number("largest_overlap", largest_overlap, {.unit = "-", .above = 0},
           "Largest permitted overlap divided by the smaller radius of two particles (stones with "
           "corners: the smaller rounding radius); above this value the run stops.");
  s.number("gravity", gravity, {.unit = "m/s2", .at_least = 0, .usually_to = 100},
           "Gravitational acceleration along -z.");
  s.flag("energy_balance", energy_balance,
         "Whether the energies dissipated by friction and damping and supplied by surfaces are "
         "summed up; they are histories beside those of the stones' energies.");
}

namespace {

// The thickness for line contacts is that of the particles.
Physics within(Physics physics, const Domain& domain) {
  physics.thickness = domain.dimension == Dimension::plane ? domain.thickness : 0;
  return physics;
}

}  // namespace

Particles::Impl::Impl(const par::Comm& comm_, const Physics& physics_,
                      const Parameters& parameters_, const Domain& domain_)
    : comm(comm_),
      declared(within(physics_, domain_)),
      physics(declared),
      parameters(parameters_),
      domain(domain_),
      laws(physics) {}

Particles::Particles(const par::Comm& comm, const Physics& physics, const Parameters& parameters,
                     const Domain& domain)
    : impl_(std::make_unique<Impl>(comm, physics, parameters, domain)) {}
Particles::~Particles() = default;
Particles::Particles(Particles&&) noexcept = default;

int Particles::add_template(const Template& shape) { return impl_->shapes.add(shape); }

// Collective. The rank that made a particle keeps it until the next rebuild sends it to its owner,
// so the initial distribution does not matter. Attitudes are normalised here; every step preserves
// this.
void Particles::add(std::span<const NewParticle> mine) {
  Impl& r = *impl_;
  const std::vector<History> kept = r.history();
  visit_state(r.state, [&](auto, auto& array) { array.resize(r.state.own); });
  for (const NewParticle& p : mine) {
    visit_state(r.state, [](auto, auto& array) { array.emplace_back(); });
    r.state.id.back() = p.id, r.state.shape.back() = p.shape;
    r.state.material.back() = p.material, r.state.scale.back() = p.scale;
    r.state.x.back().set(p.position), r.state.q.back() = vec4(p.attitude.normalized());
    r.state.v.back().set(p.velocity), r.state.held.back() = p.held ? 1 : 0;
    r.state.part.back() = 0;
  }
  const std::size_t begin = r.state.own;
  r.state.own = r.state.size();
  r.derive(begin);
  for (std::size_t k = 0; k < mine.size(); ++k) {
    const std::size_t b = begin + k;
    // L = I w in principal axes, rotated to space axes; `w` is the given value, without conversion
    // errors.
    const Quat q = quat(r.state.q[b]);
    const Vec3 body = q.conjugate() * mine[k].spin;
    r.state.l[b].set(q * Vec3(body.cwiseProduct(r.state.inertia[b].vec3())));
    r.state.w[b].set(mine[k].spin);
  }
  // Histories are kept as records: the lists refer to the previous particles.
  r.forget_contacts();
  r.waiting.insert(r.waiting.end(), kept.begin(), kept.end());
  r.check_laws();
  r.choose_grid(r.work());
}

// Collective: every rank receives all removed ids, because a neighbour may have the history of a
// contact with one. Their partners are free from the next sub-step on.
std::int64_t Particles::remove(const std::function<bool(const ParticleView&)>& selected) {
  Impl& r = *impl_;
  std::vector<History> kept = r.history();
  std::vector<std::size_t> removed;
  for (std::size_t b = 0; b < r.state.own; ++b)
    if (selected((*this)[b])) removed.push_back(b);
  std::vector<Id> gone;
  std::vector<Vec4> accounts;
  for (const std::size_t b : removed)
    gone.push_back(r.state.id[b]), accounts.push_back(r.state.account[b]);
  if (r.parameters.energy_balance) r.removed += r.total_of(accounts);
  gone = r.comm.all_gather(std::span<const Id>(gone));
  std::sort(gone.begin(), gone.end());
  const auto is_gone_id = [&](Id id) { return std::binary_search(gone.begin(), gone.end(), id); };
  const auto is_gone = [&](std::int64_t key) { return key >= 0 && is_gone_id(particle_of(key)); };
  const auto is_stale = [&](const History& h) { return is_gone(h.first) || is_gone(h.second); };
  std::erase_if(kept, is_stale);
  std::erase_if(r.waiting, is_stale);
  r.forget_cracks(gone);
  std::erase_if(r.bonding.bonds, [&](const Bond& bond) {
    return is_gone_id(bond.first) || is_gone_id(bond.second);
  });
  visit_state(r.state, [&](auto, auto& array) {
    array.resize(r.state.own);
    // From the back, so that the numbers of the others stay valid.
    for (std::size_t k = removed.size(); k-- > 0;)
      array.erase(array.begin() + static_cast<std::ptrdiff_t>(removed[k]));
  });
  r.state.own = r.state.id.size();
  r.derive(0);
  r.forget_contacts();
  r.waiting.insert(r.waiting.end(), kept.begin(), kept.end());
  r.choose_grid(r.work());
  return static_cast<std::int64_t>(gone.size());
}

// The state is not changed: the next rebuild sends particles and histories to their new owners.
void Particles::repartition(const std::function<double(const ParticleView&)>& weight) {
  Impl& r = *impl_;
  std::vector<double> work = r.work();  // while the lists still exist
  for (std::size_t b = 0; weight && b < work.size(); ++b) work[b] = weight((*this)[b]);
  const std::vector<History> kept = r.history();
  visit_state(r.state, [&](auto, auto& array) { array.resize(r.state.own); });
  r.forget_contacts();
  r.waiting.insert(r.waiting.end(), kept.begin(), kept.end());
  r.choose_grid(work);
}

// Materials of all ranks' particles, each with each and with every surface: a missing law is
// reported before the first step and not when two stones touch after an hour. Some of these pairs
// may never be in contact.
void Particles::Impl::check_laws() const {
  std::vector<std::int64_t> used(laws.materials(), 0);
  for (std::size_t b = 0; b < state.own; ++b) ++used[static_cast<std::size_t>(state.material[b])];
  comm.sum(used);
  std::set<std::pair<std::size_t, std::size_t>> pairs_of_materials;
  for (std::size_t a = 0; a < used.size(); ++a)
    if (used[a] > 0) {
      if (used[a] > 1) pairs_of_materials.insert({a, a});
      for (std::size_t b = a + 1; b < used.size(); ++b)
        if (used[b] > 0) pairs_of_materials.insert({a, b});
      for (const Surface* surface : surfaces)
        pairs_of_materials.insert(std::minmax(a, static_cast<std::size_t>(surface->material)));
    }
  std::vector<std::string> problems;
  for (const auto& [a, b] : pairs_of_materials)
    if (laws.index(static_cast<int>(a), static_cast<int>(b)) < 0)
      problems.push_back(fmt::format("contact: no law is given between \"{}\" and \"{}\"",
                                     physics.materials[a].name, physics.materials[b].name));
  if (!problems.empty()) throw InputError(problems);
}

// Numbers are assigned once and kept, also of removed surfaces, so that no history is assigned to
// another surface. The same on every rank, since surfaces are set in the same order.
int Particles::Impl::name_number(const std::string& name) {
  const auto known = std::find(names.begin(), names.end(), name);
  if (known == names.end()) names.push_back(name);
  return static_cast<int>(std::find(names.begin(), names.end(), name) - names.begin());
}

// Owned by the caller. Meshes are made here; nodes may move afterwards, triangles may not change.
void Particles::set_surfaces(std::vector<Surface*> surfaces) {
  Impl& r = *impl_;
  const std::vector<History> kept = r.history();
  r.waiting.insert(r.waiting.end(), kept.begin(), kept.end());
  r.forget_contacts();
  r.surfaces = std::move(surfaces);
  r.surface_names.clear(), r.meshes.clear();
  r.surface_reference.assign(r.surfaces.size(), {});
  r.surface_path.assign(r.surfaces.size(), 0);
  r.surface_travel.assign(r.surfaces.size(), 0);
  r.surface_last.assign(r.surfaces.size(), {});
  for (Surface* surface : r.surfaces) {
    r.surface_names.push_back(r.name_number(surface->name));
    r.meshes.emplace_back(*surface);
    // Loads collected with another quantum would be invalid.
    surface->load_quantum = r.load_quantum;
    surface->clear_load();
  }
  r.check_laws();
  r.ready = false;
}

// Grows on demand, not from the start: a quantum for the load of a bed of millions of stones on one
// node, over a window of a thousand sub-steps, would be too coarse for the loads of stones in light
// contact.
void Particles::expect_load(double newtons) {
  Impl& r = *impl_;
  if (!(newtons > 0) || exact_quantum(newtons) <= r.load_quantum) return;
  r.load_quantum = exact_quantum(newtons);
  r.choose_quantum();
}

// The margin: a stone's ball around a centre in the rank's cells, the depth behind a surface at
// which it is still in contact, and twice the skin, since stones leave their cells before the next
// rebuild and surfaces move too.
bool Particles::reaches(const Vec3& low, const Vec3& high) const {
  const double deep = impl_->shapes.any_stones() ? 1 + largest_corner_depth : 1;
  const Vec3 margin = Vec3::Constant(deep * impl_->bound + 2 * impl_->skin);
  return impl_->grid.owns_part_of(low - margin, high + margin, impl_->comm.rank());
}

// Collective: the lightest particle and the largest one may be on different ranks.
double Particles::stable_step(std::string* limit) const {
  const Impl& r = *impl_;
  double lightest = std::numeric_limits<double>::infinity(), largest = 0;
  for (std::size_t b = 0; b < r.state.own; ++b) {
    // A held particle acts like an infinitely heavy one.
    if (r.state.held[b] == 0) lightest = std::min(lightest, r.mass(b));
    largest = std::max(largest, r.radius(b));
  }
  lightest = r.comm.min(lightest), largest = r.comm.max(largest);
  if (r.breaking.active && r.breaking.least_mass > 0)
    lightest = std::min(lightest, r.breaking.least_mass);
  const double contacts = dem::stable_step(r.physics, r.parameters, lightest, largest, limit);
  const double bonds = r.comm.min(r.stable_step_of_bonds());
  if (limit && bonds < contacts) *limit = "stiff bonds on a light stone";
  return std::min(contacts, bonds);
}

// One window; with no sub-steps: new lists only, where they are due. Surfaces must have their new
// motion on every rank before. Collective.
void Particles::advance(double dt_window, int steps) {
  require(steps >= 0, "the number of sub-steps of a window is not negative");
  Impl& r = *impl_;
  r.action = {};
  r.break_off();
  if (!r.ready) r.rebuild();
  if (steps == 0) return;
  r.grow_fragments(steps);
  // Nodes move along lines, so the distance from a fixed place is largest at one end of the window;
  // the begin was the end of the window before.
  r.surface_motion = r.surface_motion_since_rebuild();
  r.update_surface_paths();
  r.check_tunnelling({dt_window / steps, 0, 0, steps});
  for (int k = 1; k <= steps; ++k)
    r.substep({dt_window / steps, static_cast<double>(k) / steps, k, steps});
  r.kick(dt_window / steps, 1);
  r.stone_contacts.store(r.stones);
  r.elapsed += dt_window;
  r.find_cuts(steps);
  // One reduction for all. A plain sum: it is only compared with a tolerance.
  double sums[8];
  Eigen::Map<Vec3>(sums, 3) = r.action.force;
  Eigen::Map<Vec3>(sums + 3, 3) = r.action.moment;
  sums[6] = r.action.work, sums[7] = static_cast<double>(r.breaking.waiting());
  r.comm.sum(std::span<double>(sums, 8));
  r.breaking.pending = std::llround(sums[7]);
  r.action = {Eigen::Map<Vec3>(sums, 3), Eigen::Map<Vec3>(sums + 3, 3), sums[6]};
}

void Particles::make_lists() {
  if (!impl_->ready) impl_->rebuild();
}

std::int64_t Particles::core_overlaps() const {
  return impl_->comm.sum(impl_->stone_contacts.deep());
}

std::string Particles::not_a_number() const {
  std::string words;
  for (std::size_t b = 0; b < impl_->state.own && words.empty(); ++b)
    words = impl_->not_a_number(b);
  return words;
}
std::string Particles::trouble() { return std::exchange(impl_->trouble, {}); }
void Particles::set_local_damping(double alpha) { impl_->local_damping = alpha; }
void Particles::set_friction(double mu) { impl_->laws.override_friction(mu); }
void Particles::scale_friction(double factor) { impl_->laws.scale_friction(factor); }
void Particles::set_stiffness(double fraction) {
  Impl& r = *impl_;
  r.stiffness = fraction, r.physics = with_stiffness(r.declared, fraction);
  r.laws.set_stiffness(r.physics);
  r.store_near_pairs(), r.near_valid = false;  // they contain limits of overlaps
}

std::string Particles::Impl::softness() const {
  if (stiffness >= 1) return "";
  return fmt::format(
      "; in this stage, contacts have {:g} times the stiffness of their laws "
      "(stage.stiffness)",
      stiffness);
}

// Positions and histories are kept: the springs stay loaded.
void Particles::stop() {
  State& state = impl_->state;
  for (auto* motion : {&state.v, &state.l, &state.w})
    for (std::size_t b = 0; b < motion->size(); ++b)
      if (state.held[b] == 0) (*motion)[b].x = (*motion)[b].y = (*motion)[b].z = 0;
}

std::size_t Particles::size() const { return impl_->state.own; }
bool Particles::any_corners() const { return impl_->shapes.any_stones(); }
const SurfaceAction& Particles::surface_action() const { return impl_->action; }
std::int64_t Particles::steps() const { return impl_->steps; }
std::int64_t Particles::rebuilds() const { return impl_->rebuilds; }
const Domain& Particles::domain() const { return impl_->domain; }
void Particles::time_with(Timers& timers) { impl_->timers = &timers; }

}  // namespace trackbed::dem
