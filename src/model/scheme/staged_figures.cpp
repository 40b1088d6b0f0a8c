// The names of these figures are fixed (docs/running.md). Speeds are particles (elements) times
// steps over the largest wall time of any rank, per rank, of the last stage.
//
// All sums are collective: every rank computes the figures, and rank 0 writes them. Names include
// the unit; a figure without meaning in a run is 0 or left out, never a text.
#include "model/scheme/staged_figures.hpp"

#include <fmt/format.h>

#include <ctime>

#include "trackbed/core/ratio.hpp"

namespace trackbed::model {

namespace {

using Json = nlohmann::ordered_json;

// s, CPU time of this rank: less sensitive than wall time on a shared machine. Waiting in MPI is
// included if MPI polls.
double cpu_time() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

Json dem_figures(const FigureInput& run, const dem::Totals& totals) {
  const par::Comm& comm = run.world.comm;
  // Of the slowest rank, since the others wait for it.
  const double seconds = comm.max(run.timers.seconds(Phase::dem) - run.measured.dem_seconds);
  const double own = run.timers.seconds(Phase::dem) - run.measured.dem_seconds;
  const double neighbours = run.timers.seconds(Phase::search) - run.measured.neighbour_seconds;
  const dem::Memory memory = run.world.particles.memory();
  const auto per_particle = [&](std::size_t bytes) {
    return ratio(static_cast<double>(comm.sum(static_cast<std::int64_t>(bytes))),
                 static_cast<double>(totals.particles));
  };
  const auto particles = static_cast<double>(totals.particles);
  const std::int64_t steps = run.world.particles.steps() - run.measured.dem_steps;
  // From the start of the last stage, since earlier stages (packing) have other speeds.
  const double done = particles * static_cast<double>(steps);
  // Factor 2: a contact is counted once and belongs to two stones.
  return {{"particles", totals.particles},
          {"pieces", totals.pieces},
          {"steps", run.world.particles.steps()},
          {"contacts_per_particle", ratio(2 * static_cast<double>(totals.contacts), particles)},
          {"neighbours_per_particle",
           ratio(static_cast<double>(run.world.particles.neighbours()), particles)},
          {"particle_steps_per_second_per_core", ratio(done, seconds) / comm.size()},
          {"core_overlaps", run.world.particles.core_overlaps()},
          {"state_hash", fmt::format("{:016x}", run.world.particles.state_hash())},
          {"measured_stage", run.measured.stage},
          {"measured_steps", steps},
          {"measured_dem_time_s", seconds},
          {"measured_cpu_time_s", comm.max(cpu_time() - run.measured.cpu_seconds)},
          {"neighbour_share", ratio(comm.sum(neighbours), comm.sum(own))},
          {"memory_per_particle_b", per_particle(memory.total())},
          {"memory_per_particle_without_contacts_b", per_particle(memory.particles)}};
}

Json ground_figures(const FigureInput& run) {
  if (!run.world.ground) return {{"elements", 0}};
  const par::Comm& comm = run.world.comm;
  const fem::GroundTotals totals = run.world.ground->totals();
  const double seconds = comm.max(totals.seconds - run.measured.ground_seconds);
  const auto steps = static_cast<double>(totals.steps - run.measured.ground_steps);
  const auto elements = static_cast<double>(totals.elements);
  return {{"elements", totals.elements},
          {"unknowns", totals.unknowns},
          {"steps", totals.steps},
          {"element_steps_per_second_per_core", ratio(elements * steps, seconds) / comm.size()},
          {"iterations_mean", totals.iterations_mean},
          {"newton_iterations_mean", totals.newton_mean},
          {"newton_iterations_max", totals.newton_most},
          {"newton_steps_lagging", totals.lagging_steps},
          {"seconds_per_step", ratio(seconds, steps)},
          {"kinetic_j", totals.kinetic},
          {"elastic_j", totals.elastic},
          {"plastic_j", totals.plastic}};
}

// Their wall time is included in share.track.
Json solid_figures(const fem::Bodies& bodies) {
  const fem::BodiesTotals totals = bodies.totals();
  return {{"elements", totals.elements},
          {"unknowns", totals.unknowns},
          {"factor_entries", totals.factor},
          {"kinetic_j", totals.kinetic},
          {"elastic_j", totals.elastic}};
}

// Figures that a stage does not have are left out.
Json stage_list(const Course& course) {
  Json list = Json::array();
  for (const StageRecord& r : course.done) {
    Json stage{{"name", r.name},
               {"time_s", r.time},
               {"duration_s", r.duration},
               {"window_s", r.window},
               {"substeps", static_cast<std::int64_t>(r.substeps)},
               {"particles", static_cast<std::int64_t>(r.particles)},
               {"bulk_density_kg_m3", r.bulk_density},
               {"wall_time_s", r.wall_time}};
    if (r.platen_pressure >= 0) stage["platen_pressure_pa"] = r.platen_pressure;
    if (r.settlement >= 0) stage["settlement_m"] = r.settlement;
    if (r.stable_step > 0) stage["stable_step_s"] = r.stable_step;
    if (!r.has(Aim::none)) stage["aim_reached"] = r.has(Aim::reached);
    list.push_back(stage);
  }
  return list;
}

// Values at the end of the run; a box of several cells gives a list of them. Collective.
Json region_list(const FigureInput& run) {
  Json list = Json::array();
  for (const observe::Region& region : run.world.model.regions) {
    Json cells = Json::array();
    for (const observe::Measurement& m :
         observe::measure(run.world.comm, run.world.particles, region))
      cells.push_back({{"porosity", m.porosity},
                       {"bulk_density_kg_m3", m.bulk_density},
                       {"stones", m.stones},
                       {"coordination", m.coordination},
                       {"contacts", m.contacts},
                       {"contact_force_n", m.contact_force},
                       {"speed_m_s", m.speed},
                       {"speed_deviation_m_s", m.speed_deviation},
                       {"largest_speed_m_s", m.largest_speed},
                       {"stone_force_n", m.stone_force},
                       {"stone_force_deviation_n", m.stone_force_deviation},
                       {"largest_stone_force_n", m.largest_stone_force},
                       {"stress_pa", m.stress},
                       {"fabric", m.fabric}});
    list.push_back({{"name", region.name}, {"cells", cells}});
  }
  return list;
}

// Largest over mean of the ranks' work on stones; 1: balanced. The halo exchange is left out, since
// ranks with less work wait there.
double imbalance(const FigureInput& run) {
  const par::Comm& comm = run.world.comm;
  const double work = run.timers.seconds(Phase::dem) - run.timers.seconds(Phase::halo) -
                      run.timers.seconds(Phase::waiting);
  return ratio(comm.max(work) * comm.size(), comm.sum(work));
}

// Placed stones and surfaces are driven: their histories have the work of all drives instead.
Json energy_figures(const dem::Totals& totals, bool placed) {
  Json json = {
      {"kinetic", totals.kinetic}, {"potential", totals.potential}, {"elastic", totals.elastic}};
  if (!totals.account) return json;
  json["friction"] = totals.account->friction;
  json["contact_damping"] = totals.account->contact_damping;
  json["local_damping"] = totals.account->local_damping;
  if (!placed) json["supplied"] = totals.account->supplied;
  return json;
}

}  // namespace

// Local: differences are summed over ranks when the figures are made.
SpeedCounters measure_from(const std::string& stage, const Timers& timers, const World& world) {
  SpeedCounters measured{.stage = stage,
                         .dem_seconds = timers.seconds(Phase::dem),
                         .neighbour_seconds = timers.seconds(Phase::search),
                         .cpu_seconds = cpu_time(),
                         .dem_steps = world.particles.steps(),
                         .ground_seconds = 0,
                         .ground_steps = 0};
  if (!world.ground) return measured;
  const fem::GroundTotals totals = world.ground->totals();
  measured.ground_seconds = totals.seconds;
  measured.ground_steps = totals.steps;
  return measured;
}

// Bulk density, kg/m^3: mass over the volume of a uniform layer with the same mean height, m,
//   rho = m/(L B 2 (z_mean - z_ground)),
// with L B the floor between the walls. Exact only for a uniform layer; for comparisons of stages.
// Collective.
StageRecord record_of(const Stage& stage, const Course& course, const World& world) {
  const Model& model = world.model;
  const dem::Totals totals = world.particles.totals();
  // The top of a layer of uniform density is at twice the mean height, which is less sensitive to
  // loose stones on top than the highest stone. E_pot/(m g) is the height of the centre of mass.
  const double mean_height =
      ratio(totals.potential, totals.mass * model.dem.gravity) - world.mean_ground_level();
  // 0 for a heap without walls.
  const auto& names = world.walls.names();
  const bool heap = !names.empty() && world.walls.displacement(names.back()).z() > 0;
  const double volume = heap || !model.has_bed() ? 0 : world.walls.area() * 2 * mean_height;
  const bool loaded = has_platen_load(stage.kind) && world.platen;
  return {.name = stage.name,
          .time = course.clock.time(),
          .duration = course.clock.time() - course.clock.start(),
          .window = course.steps.window,
          .substeps = static_cast<double>(course.steps.substeps),
          .particles = static_cast<double>(totals.particles),
          .bulk_density = ratio(totals.mass, volume),
          .platen_pressure = loaded ? world.platen->pressure() : -1};
}

void put_figures(const FigureInput& run, Json& json) {
  const dem::Totals totals = run.world.particles.totals();
  const couple::Balance& balance = run.world.coupler.balance();
  const bool stones = run.world.model.has_stones();
  if (stones) json["dem"] = dem_figures(run, totals);
  json["ground"] = ground_figures(run);
  if (run.world.solids) json["solids"] = solid_figures(run.world.solids->bodies());
  if (stones)
    json["coupling"] = {{"force", balance.force},
                        {"moment", balance.moment},
                        {"impulse", balance.impulse},
                        {"work", balance.work}};
  if (run.wheels.any)
    json["track"] = {{"wheel_force_max_n", run.wheels.most},
                     {"wheel_force_min_n", run.wheels.least}};
  if (stones) json["energy"] = energy_figures(totals, run.world.placement.has_value());
  if (run.world.model.breakage.any()) {
    const dem::BreakTotals broken = run.world.particles.broken();
    json["breakage"] = {{"fragments", broken.fragments},
                        {"fines", broken.fines},
                        {"cuts", broken.cuts},
                        {"splits", broken.splits},
                        {"wears", broken.wears},
                        {"fragment_mass_kg", broken.fragment_mass},
                        {"fines_mass_kg", broken.fines_mass},
                        {"dust_mass_kg", broken.dust_mass},
                        {"released_j", broken.released},
                        {"kinetic_lost_j", broken.lost}};
  }
  if (!run.world.model.bonds.empty()) {
    const dem::BondTotals bonds = run.world.particles.bonded();
    json["bonds"] = {{"made", bonds.made},
                     {"whole", bonds.whole},
                     {"broken_by_tension", bonds.by_tension},
                     {"broken_by_shear", bonds.by_shear},
                     {"released_j", bonds.released}};
  }
  if (stones) {
    json["imbalance"] = imbalance(run);
    json["load_balance"] = {{"rebalances", run.world.particles.balance().rebalances},
                            {"imbalance_before", run.world.particles.balance().before},
                            {"imbalance_now", run.world.particles.imbalance()}};
  }
  json["stages"] = stage_list(run.course);
  if (!run.world.model.regions.empty()) json["regions"] = region_list(run);
}

}  // namespace trackbed::model
