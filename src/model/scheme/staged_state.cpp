// State of a run in stages: each module writes its own group; group coupling and parts of group run
// are written here.
//
// Stored is the state that cannot be computed from the deck. Not stored are neighbour lists,
// matrices of the ground, and walls: they are built again and are bitwise identical. Nothing
// depends on the number of ranks: datasets are global, so a run can be resumed with another number.
// The layout is described in docs/checkpoint.md.
#include <fmt/format.h>

#include "model/scheme/staged.hpp"

namespace trackbed::model {

namespace {

// Vectors per node as rows; rank 0 holds all of them, the argument of other ranks is ignored.
// Collective.
void write_nodes(const par::Comm& comm, io::File& file, const std::string& path,
                 const std::vector<Vec3>& all, const io::Label& label) {
  const double* first = all.empty() ? nullptr : all[0].data();
  file.write<double>(path, std::span(first, comm.root() ? 3 * all.size() : 0), 3, label);
}

// Every rank reads all nodes, since surfaces are replicated. Collective.
std::vector<Vec3> read_nodes(const io::File& file, const std::string& path) {
  const std::vector<double> values = file.read_all<double>(path);
  std::vector<Vec3> nodes(values.size() / 3);
  for (std::size_t n = 0; n < nodes.size(); ++n)
    nodes[n] = Vec3(values[3 * n], values[3 * n + 1], values[3 * n + 2]);
  return nodes;
}

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

// Walls are built again from their height and displacement; ground, sleepers and platen store their
// own shape. The mean forces are state: they move the bodies in the next window. Collective.
void save_surfaces(World& world, io::File& file) {
  const par::Comm& comm = world.comm;
  world.walls.save(file, "run", comm);
  if (world.ground) {
    const Surface& top = world.ground->top();
    write_nodes(comm, file, "run/support", gathered(comm, *world.ground, world.support),
                {"N", "averaged load of the bed on the ground's top nodes"});
    write_nodes(comm, file, "run/top_position", gathered(comm, *world.ground, top.position),
                {"m", "ground's top nodes at the start of the last window"});
    write_nodes(comm, file, "run/top_motion", gathered(comm, *world.ground, top.motion),
                {"m", "their displacement in it"});
  }
  for (const World::Means& means : world.means())
    write_nodes(comm, file, "coupling/" + means.surface, means.force,
                {"N", "mean force of stones on the nodes in the last window"});
}

// Surfaces are registered first, since the coupler needs them before it can take their forces.
void load_surfaces(World& world, const io::File& file) {
  world.walls.load(file, "run");
  if (world.ground && file.has("run/support")) {
    world.support = read_nodes(file, "run/support");
    Surface& top = world.ground->top();
    top.position = read_nodes(file, "run/top_position");
    top.motion = read_nodes(file, "run/top_motion");
  }
  world.register_surfaces();
  // A model of placed stones without plates and boxes has no surface and no such group.
  if (!file.has("coupling")) return;
  std::vector<World::Means> means;
  for (const std::string& surface : file.names("coupling"))
    means.push_back({surface, read_nodes(file, "coupling/" + surface)});
  world.set_means(means);
}

// The part of the state that is the same on all ranks.
struct CommonState {
  couple::Balance balance;
  std::int64_t rows = 0;  // of the histories
  bool ground_settled = false;

  void archive(io::Archive& a) {
    a("balance/force", balance.force, {"-", "largest relative imbalance of force in the coupling"});
    a("balance/moment", balance.moment, {"-", "the same of moment"});
    a("balance/impulse", balance.impulse, {"-", "the same of impulse"});
    a("balance/work", balance.work, {"-", "the same of work"});
    a("history_rows", rows, {"-", "rows of the histories"});
    a("ground_settled", ground_settled, {"-", "1: the ground has been in static equilibrium"});
  }
};

CommonState common_state_in(const io::File& file) {
  CommonState common;
  io::Archive archive = io::Archive::reader(file, "run");
  common.archive(archive);
  return common;
}

}  // namespace

std::int64_t history_rows_in(const io::File& file) { return common_state_in(file).rows; }

// Parts that do not exist yet are not written, and `load` leaves them in their initial state.
void StagedScheme::save(io::File& file) {
  CommonState common{world_.coupler.balance(), results_.rows(), world_.ground_settled};
  io::Archive archive = io::Archive::writer(comm_, file, "run");
  common.archive(archive);
  file.attribute("/", "particles", world_.particles.totals().particles);
  world_.particles.save(file, "particles");
  if (world_.sleepers && world_.sleepers->placed()) world_.sleepers->save(file, "sleepers", comm_);
  if (world_.ground && world_.ground_settled) world_.ground->save(file, "ground");
  if (world_.platen) world_.platen->save(file, "platen", comm_);
  if (world_.tines) world_.tines->save(file, "tines", comm_);
  if (world_.placement) world_.placement->save(file);
  actions_.save(file);
  save_surfaces(world_, file);
}

// In the order of dependence: `CommonState` states whether the ground has moved, then the modules
// load their bodies, and surfaces are registered last, when all of them are at their stored
// positions.
void StagedScheme::load(const io::File& file) {
  const CommonState common = common_state_in(file);
  world_.ground_settled = common.ground_settled;
  world_.coupler.set_balance(common.balance);
  world_.particles.load(file, "particles");
  if (world_.sleepers && file.has("sleepers")) world_.sleepers->load(file, "sleepers");
  if (world_.ground && world_.ground_settled) world_.ground->load(file, "ground");
  if (file.has("platen")) {
    world_.platen.emplace(model_.platen, model_.container(), model_.material(model_.wall_material));
    if (run_.course.begun)
      world_.platen->set_target(model_.pressure_in(present()), present().kind == StageKind::shear);
    world_.platen->load(file, "platen");
  }
  if (file.has("tines")) {
    world_.tines.emplace(world_.make_tines());
    world_.tines->load(file, "tines");
    world_.tines->show_at_rest(begin_of_window());
  }
  if (world_.placement) {
    world_.placement->load(file);
    world_.placement->update(run_.course.clock.time(), 0);
  }
  if (run_.course.begun) actions_.load(file, run_.course.steps.window);
  actions_.load_done(file);
  load_surfaces(world_, file);
  if (world_.platen) world_.platen->set_area(world_.walls.area());
}

// Histories are continued in the file beside the checkpoint, or begin again if it does not exist.
// The steps of the present stage are those of the checkpoint and are not chosen again: limits may
// have changed with the stones, and an uninterrupted run would not have chosen new ones either.
void StagedScheme::resume(const io::File& file, const std::string& histories) {
  std::vector<std::string> finished;
  for (const StageRecord& record : run_.course.done) finished.push_back(record.name);
  results_.resume(histories, history_rows_in(file), finished);
  if (!run_.course.begun) return;
  resume_extremes(file.has("ground/extremes/element"));
  // Settings of `begin` that are not part of the stored state.
  world_.particles.set_local_damping(present().local_damping);
  world_.particles.set_friction(present().friction);
  // The seat forces of the window before the checkpoint, as in an uninterrupted run: the next
  // history row contains them until the sleepers move again.
  const double mid_window =
      (static_cast<double>(run_.course.clock.window()) - 0.5) * run_.course.clock.dt();
  seat_force_ =
      world_.solids ? world_.solids->seat_forces() : actions_.seat_forces(present(), mid_window);
  measured_ = measure_from(present().name, run_.timers, world_);
}

}  // namespace trackbed::model
