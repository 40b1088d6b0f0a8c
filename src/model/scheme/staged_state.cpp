// State of a run in stages: each module has its own group; group coupling and parts of group run
// are listed here.
//
// Stored is the state that cannot be computed from the deck. Not stored are neighbour lists,
// matrices of the ground, and walls: they are built again and are bitwise identical. Nothing
// depends on the number of ranks: datasets are global, so a run can be resumed with another number.
// The layout is described in docs/checkpoint.md.
#include <fmt/format.h>

#include "model/scene/steps.hpp"
#include "model/scheme/staged.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::model {

namespace {

// Each rank contributes the values of its own nodes and zero elsewhere, so the sum is exact. Ghost
// nodes of the argument hold copies and are left out, or a node would be counted once per rank that
// has it. Cost: one reduction over all top nodes; checkpoints are rare. Collective.
std::vector<Vec3> gathered(const par::Comm& comm, const fem::Ground& ground,
                           const std::vector<Vec3>& values) {
  std::vector<Vec3> all(values.size(), Vec3::Zero());
  for (const std::int32_t own : ground.own_top())
    all[static_cast<std::size_t>(own)] = values[static_cast<std::size_t>(own)];
  if (!all.empty()) comm.sum(std::span<double>(all[0].data(), 3 * all.size()));
  return all;
}

// What ranks have of a quantity of the ground's top nodes; all of them read all. Collective.
void archive_top(io::Archive& a, const World& world, const std::string& name,
                 const io::Label& label, std::vector<Vec3>& values) {
  std::vector<Vec3> all = a.reads() ? values : gathered(world.comm, *world.ground, values);
  a.rows(name, all, label);
  if (a.reads()) values = all;
}

// Walls are built again from their height and displacement; ground, sleepers and platen have stored
// their own shape. The mean forces are state: they move the bodies in the next window. Surfaces are
// registered before, since the coupler takes the forces of surfaces that it has. Collective.
void archive_surfaces(io::Archive& a, World& world) {
  a.part("run/walls", world.walls);
  if (world.ground) {
    Surface& top = world.ground->top();
    archive_top(a, world, "run/support",
                {"N", "averaged load of the bed on the ground's top nodes"}, world.support);
    archive_top(a, world, "run/top_position",
                {"m", "ground's top nodes at the start of the last window"}, top.position);
    archive_top(a, world, "run/top_motion",
                {"m", "displacement of the ground's top nodes in the last window"}, top.motion);
  }
  if (a.reads()) world.register_surfaces();
  std::vector<World::Means> means = world.means();
  for (World::Means& of : means)
    if (a.has("coupling/" + of.surface, true))
      a.rows("coupling/" + of.surface, of.force,
             {"N", "mean force of stones on the nodes in the last window"});
  if (a.reads()) world.set_means(means);
}

// The part of the state that is the same on all ranks.
struct CommonState {
  couple::Balance balance;
  std::int64_t rows = 0;  // of the histories
  bool ground_settled = false;

  void archive(io::Archive& a) {
    a("balance/force", balance.force, {"-", "largest relative imbalance of force in the coupling"});
    a("balance/moment", balance.moment,
      {"-", "largest relative imbalance of moment in the coupling"});
    a("balance/impulse", balance.impulse,
      {"-", "largest relative imbalance of impulse in the coupling"});
    a("balance/work", balance.work, {"-", "largest relative imbalance of work in the coupling"});
    a("history_rows", rows, {"-", "rows of the histories"});
    a("ground_settled", ground_settled, {"-", "1: the ground has been in static equilibrium"});
  }
};

}  // namespace

std::int64_t history_rows_in(const io::File& file) {
  CommonState common;
  io::Archive::reader(file).part("run", common);
  return common.rows;
}

// Parts that do not exist yet are not written, and loading leaves them in their initial state. In
// the order of dependence: `CommonState` states whether the ground has moved, then the modules load
// their bodies, and surfaces come last, when all of them are at their stored positions.
void StagedScheme::archive(io::Archive& a) {
  CommonState common{world_.coupler.balance(), results_.rows(), world_.ground_settled};
  a.part("run", common);
  world_.ground_settled = common.ground_settled;
  if (a.reads()) world_.coupler.set_balance(common.balance);
  a.part("particles", world_.particles);
  if (world_.sleepers && a.has("sleepers", world_.sleepers->placed()))
    a.part("sleepers", *world_.sleepers);
  if (world_.ground && world_.ground_settled) a.part("ground", *world_.ground);
  archive_platen(a);
  if (a.has("tines", world_.tines.has_value())) {
    if (a.reads()) world_.tines.emplace(world_.make_tines());
    a.part("tines", *world_.tines);
    if (a.reads()) world_.tines->show_at_rest(begin_of_window());
  }
  if (world_.placement) {
    a.part("placed", *world_.placement);
    if (a.reads()) world_.placement->update(run_.course.clock.time(), 0);
  }
  actions_.archive(a, run_.course.steps.window);
  a.part("sensors", sensors_);
  archive_surfaces(a, world_);
  if (a.reads() && world_.platen) world_.platen->set_area(world_.walls.area());
}

void StagedScheme::archive_platen(io::Archive& a) {
  if (!a.has("platen", world_.platen.has_value())) return;
  if (a.reads()) {
    world_.platen.emplace(model_.platen, model_.container(), model_.material(model_.wall_material));
    if (run_.course.begun)
      world_.platen->set_target(model_.pressure_in(present()), present().kind == StageKind::shear);
  }
  a.part("platen", *world_.platen);
}

// Changed stiffness, damping or density may need shorter steps than those of the stage. Limits also
// change a little with the stones themselves, which wear and break.
void StagedScheme::require_still_stable() const {
  if (!model_.has_stones()) return;
  constexpr double tolerance = 1.1;
  const StonesStep now = step_of(world_);
  const double limit = now.longest / model_.dem.safety;
  const double step = run_.course.steps.window / run_.course.steps.substeps;
  if (step > tolerance * limit)
    throw InputError({fmt::format(
        "the sub-steps of stage \"{}\", {:.4g} s, are too long for the changed parameters: with "
        "dem.safety = 1 the limit is {:.4g} s ({}); resume with the former values, or start a run "
        "with these from the end of the stage before",
        present().name, step, limit, now.limit)});
}

// Histories are continued in the file beside the checkpoint, or begin again if it does not exist.
// The steps of the present stage are those of the checkpoint and are not chosen again: limits may
// have changed with the stones, and an uninterrupted run would not have chosen new ones either.
void StagedScheme::resume(const io::File& file, const std::string& histories) {
  std::vector<std::string> finished;
  for (const StageRecord& record : run_.course.done) finished.push_back(record.name);
  results_.resume(histories, history_rows_in(file), finished);
  if (!run_.course.begun) return;
  // Settings of `begin` that are not part of the stored state.
  actions_.set_contacts(present());
  require_still_stable();
  resume_extremes(file.has("ground/extremes/element"));
  // The seat forces of the window before the checkpoint, as in an uninterrupted run: the next
  // history row contains them until the sleepers move again.
  const double mid_window =
      (static_cast<double>(run_.course.clock.window()) - 0.5) * run_.course.clock.dt();
  seat_force_ =
      world_.solids ? world_.solids->seat_forces() : actions_.seat_forces(present(), mid_window);
  measured_ = measure_from(present().name, run_.timers, world_);
}

}  // namespace trackbed::model
