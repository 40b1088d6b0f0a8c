#include "model/scheme/staged_log.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "model/coupling/train_words.hpp"

namespace trackbed::model {

namespace {

template <class... Args>
void say_values(const par::Comm& comm, fmt::format_string<Args...> text, Args&&... args) {
  say(comm, fmt::format(text, std::forward<Args>(args)...));
}

double megabytes(std::size_t bytes) { return static_cast<double>(bytes) / (1024 * 1024); }

std::string words_of_base(const fem::GroundParameters& ground) {
  if (!ground.mesh.empty()) return "mesh " + ground.mesh;
  return ground.base == fem::Base::fixed ? "base fixed" : "base viscous (dashpots)";
}

std::string words_of_springs(const fem::GroundParameters& ground) {
  if (ground.base_stiffness < 0) return " with springs (stiffness: shear modulus divided by depth)";
  return fmt::format(" with springs of {:g} Pa/m", ground.base_stiffness);
}

std::string words_of_load(const track::SeatLoadParameters& load) {
  if (load.is_table()) return "; seat loads from " + load.file;
  std::string words = fmt::format("; seat load peak {:.4g} kN at {:.2f} km/h, {} axles",
                                  load.peak_load() / 1e3, load.speed * 3.6, load.axles.size());
  if (load.wheel_load > 0)
    words += fmt::format(
        " (wheel load {:.4g} kN, with the impact factor {:.4g} {:.4g} kN; of a seat {:.4g} kN)",
        load.wheel_load / 1e3, load.impact_factor(), load.dynamic_wheel_load() / 1e3,
        load.largest_seat_load() / 1e3);
  return words;
}

}  // namespace

void say_model(World& world, const std::string& name) {
  const par::Comm& comm = world.comm;
  const Model& model = world.model;
  say_values(comm, "trackbed: {} on {}{}{}", name, ranks_in_words(comm),
             model.title.empty() ? "" : ": ", model.title);
  if (world.ground) {
    const fem::GroundTotals totals = world.ground->totals();
    std::string limit;
    const double step = world.ground->stable_step(&limit);
    say_values(comm, "  ground: {} elements, {} unknowns, {}{}, {}", totals.elements,
               totals.unknowns, words_of_base(model.ground),
               totals.springs ? words_of_springs(model.ground) : "",
               std::isinf(step) ? "one implicit step per window"
                                : fmt::format("stable step {:.4g} s ({})", step, limit));
  }
  const bool passes = model.has_stage(StageKind::passage) && !model.has_train();
  if (world.sleepers)
    say_values(comm, "  sleepers: {}, each of {:.1f} kg{}", world.sleepers->count(),
               world.sleepers->mass(), passes ? words_of_load(model.load) : "");
  if (world.solids) {
    const fem::BodiesTotals totals = world.solids->bodies().totals();
    say_values(comm, "  solids: {} elements, {} unknowns on every rank; {}", totals.elements,
               totals.unknowns, model.solid.rails ? "with rails on pads" : "sleepers alone");
  }
  if (!model.has_train()) return;
  const track::TrackParameters& track = model.track.line.track;
  const track::Train train(model.track.train, model.track.vehicles, track.rails,
                           track.wheel_gauge());
  for (const std::string& line : lines_of_vehicles(train, track.dimension == Dimension::space))
    say(comm, line);
  say_values(comm,
             "  train: {} at {:.2f} km/h{}, largest static wheel load {:.2f} kN; {:g} m of "
             "rail; {} sleepers on springs before the "
             "bed; the sleepers of the bed carry {:g} rail{}",
             fmt::join(model.track.train.vehicles, ", "), model.track.train.speed * 3.6,
             model.track.train.times.empty() ? "" : " at first", train.largest_static_load() / 1e3,
             track.length, model.seat.before, model.seat.rails, model.seat.rails == 1 ? "" : "s");
}

// Memory is the largest of all ranks, since that rank fails first.
void say_stage_begins(RunContext& run, World& world, const Stage& stage) {
  const par::Comm& comm = run.comm;
  const Course& course = run.course;
  const dem::Totals totals = world.particles.totals();
  const double bytes = comm.max(megabytes(world.memory()));
  const bool stones = world.model.has_stones();
  const std::string step =
      fmt::format("window {:.4g} s{}", course.clock.dt(),
                  stones ? fmt::format(" in {} sub-step{}", course.steps.substeps,
                                       plural_ending(course.steps.substeps))
                         : "");
  const std::string cause = fmt::format(" (determined by {})", course.steps.limit);
  say_values(comm, "stage {}: {}{}{}, at most {:.4g} s in {} windows; memory {:.2g} MB per rank",
             stage.name,
             stones ? fmt::format("{} stone{} ({} piece{}), ", totals.particles,
                                  plural_ending(totals.particles), totals.pieces,
                                  plural_ending(totals.pieces))
                    : "",
             step, run.log.is_new_step(step + cause) ? cause : " as before",
             static_cast<double>(course.clock.windows()) * course.clock.dt(),
             course.clock.windows(), bytes);
  if (world.model.breakage.of_clumps())
    if (const std::int64_t weak = world.particles.weak_pebbles(); weak >= 0)
      say_values(comm, "  breakage: {} of {} pebbles can break off{}", weak, totals.pieces,
                 weak > 0 ? ""
                          : "; none is smaller than breakage.threshold allows: give a higher "
                            "threshold, or clumps of more spheres");
  for (std::size_t kind = 0; kind < world.model.bonds.size(); ++kind) {
    const dem::BondParameters& bond = world.model.bonds[kind];
    const std::int64_t count = world.particles.bonds_of(kind);
    const bool now = bond.present && world.model.bonds_from(kind) == course.stage;
    if (now || count > 0)
      say_values(comm, "  bonds: {} of \"{}\"{}", count, bond.name,
                 now && count == 0 ? "; no stones of its material touch within its box: check "
                                     "bond.low, bond.high and bond.material; balls may have a "
                                     "bond.gap"
                                   : "");
  }
  run.log.mark(course.clock.time());
}

Status status_of(const World& world) {
  if (!world.model.has_stones()) {
    const fem::GroundTotals ground = world.ground->totals();
    return {
        .words = fmt::format("E_kin {:.3g} J, elastic {:.3g} J of the ground", ground.kinetic,
                             ground.elastic),
        .figures = {{"ground_kinetic_j", ground.kinetic}, {"ground_elastic_j", ground.elastic}}};
  }
  const dem::Totals totals = world.particles.totals();
  const std::int64_t deep = world.particles.core_overlaps();
  Status status;
  status.figures = {{"kinetic_j", totals.kinetic},
                    {"largest_overlap_m", totals.largest_overlap},
                    {"unbalanced", totals.unbalanced},
                    {"contacts", totals.contacts},
                    {"core_overlaps", deep}};
  if (world.platen)
    status.figures["platen_pressure_pa"] = world.platen->pressure(),
    status.figures["platen_height_m"] = world.platen->z();
  status.words = fmt::format(
      "E_kin {:.3g} J | largest overlap {:.3g} um | unbalanced {:.2g} | {} contacts{}{}",
      totals.kinetic, totals.largest_overlap * 1e6, totals.unbalanced, totals.contacts,
      deep > 0 ? fmt::format(" | overlaps above the rounding radii up to now: {}", deep) : "",
      world.platen ? fmt::format(" | platen {:.1f} kPa at {:.4f} m", world.platen->pressure() / 1e3,
                                 world.platen->z())
                   : "");
  return status;
}

std::unique_ptr<Waiting> say_equilibrium(const World& world) {
  const par::Comm& comm = world.comm;
  const fem::GroundTotals totals = world.ground->totals();
  const std::string what =
      fmt::format("  static equilibrium of the ground, {} unknowns", totals.unknowns);
  say(comm, what);
  if (!comm.root()) return nullptr;
  return std::make_unique<Waiting>(what, seconds_between_lines,
                                   [&comm](const std::string& line) { say(comm, line); });
}

void say_stage_ends(const par::Comm& comm, const StageRecord& record) {
  std::string stones;
  if (record.bulk_density > 0)
    stones = fmt::format("bulk density {:.0f} kg/m3, ", record.bulk_density);
  if (record.platen_pressure >= 0)
    stones += fmt::format("mean platen pressure {:.1f} kPa, ", record.platen_pressure / 1e3);
  say_values(comm, "  {} done at {:.6g} s: {}{:.1f} s of wall time", record.name, record.time,
             stones, record.wall_time);
  if (record.settlement >= 0)
    say_values(comm, "    largest settlement of a sleeper in the last cycle: {:.3g} mm",
               1e3 * record.settlement);
}

}  // namespace trackbed::model
