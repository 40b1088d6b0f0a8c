// All parameters of a deck as one struct.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trackbed/bed/bed.hpp"
#include "trackbed/bed/placed.hpp"
#include "trackbed/bed/tamping.hpp"
#include "trackbed/dem/particles.hpp"
#include "trackbed/fem/ground.hpp"
#include "trackbed/input/section.hpp"
#include "trackbed/model/footing.hpp"
#include "trackbed/model/handover.hpp"
#include "trackbed/model/jump.hpp"
#include "trackbed/model/pressures.hpp"
#include "trackbed/model/solid.hpp"
#include "trackbed/model/track_model.hpp"
#include "trackbed/observe/output_parts.hpp"
#include "trackbed/observe/regions.hpp"
#include "trackbed/observe/sensors.hpp"
#include "trackbed/track/on_bed.hpp"
#include "trackbed/track/sleepers.hpp"

namespace trackbed::model {

// What a stage does when it begins, in every window, and when it ends: see stages.hpp.
enum class StageKind {
  fill,
  settle,
  compact,
  release,
  sleepers,
  cribs,
  load,
  passage,
  run,
  shear,
  triaxial,
  lift_walls,
  tamp,
  jump
};
// Stages in which the platen loads the stones.
inline bool has_platen_load(StageKind kind) {
  return kind == StageKind::compact || kind == StageKind::shear || kind == StageKind::triaxial;
}

// laid: a rail without load on the sleepers as they are; kept: that of the last train, whose pads
// take up their forces gradually.
enum class RailState { laid, kept };

struct Stage {
  std::string name;
  StageKind kind = StageKind::run;
  std::string layer = {};     // fill: name of a layer of the bed; none: the uppermost
  double duration = 0;        // s; passage, tamp: 0 means as long as it takes
  double growth = 0;          // s, fill: in which stones grow in place; 0: they fall
  double growth_height = 1;   // initial height of growing stones over that of the bed
  double local_damping = -1;  // Cundall's alpha during the stage; < 0: that of the materials
  double friction = -1;       // of all contacts during the stage; < 0: that of the contact laws
  double stiffness = 1;       // of all contacts during the stage over that of the contact laws
  double until_ratio = 0;     // stop early once Totals::unbalanced is below; 0: never
  bool ground_moves = false;
  double lift = 0.01;       // m/s, release: speed of the platen, lift_walls: of the walls
  double pressure = 0;      // Pa, compact, shear: of the platen; 0: platen.pressure
  double confinement = 0;   // Pa, compact, triaxial: of the side walls; 0: they are fixed
  double displacement = 0;  // m, shear: of the lower half along x; triaxial: of the platen
  double height = 0.35;     // m, sleepers: lower face
  double profile = 0;       // m, crest: stones with centres above are removed; 0: none
  double seat_force = 0;    // N on each rail seat throughout the stage
  double load = 0;          // N, load: peak on each rail seat, above seat_force
  double ramp = 0.05;       // s, load: zero to peak, and back at the end; shear: to full speed
  std::int64_t cycles = 0;  // see `declare`
  double settlement = 0;    // m, load, passage: end early once a cycle adds less; 0: never
  bool train = false;       // passage: vehicles on a rail instead of [load]
  RailState rail = RailState::laid;
  void declare(input::Section& s);

 private:
  void declare_course(input::Section& s);
  void declare_bodies(input::Section& s);
  void declare_loads(input::Section& s);
};

// Of every run. None of these changes the motion: a run may be resumed with others, a passage only
// with the same history_interval.
struct RunOutput {
  double history_interval = 1e-3;  // s of simulated time between history rows; 0: every window
  double checkpoint_interval = 0;  // s of simulated time; 0: none
  double checkpoint_wall_interval = 1800;  // s of wall time; 0: none
  double wall_time = 0;                    // s of wall time after which the run stops; 0: none
  std::int64_t stop_after = 0;             // windows after which the run stops; 0: none
  bool compress = true;                    // results.h5, at the end of the run
  void declare(input::Section& s);
};

// Of a run with fields for ParaView.
struct FieldOutput : RunOutput {
  bool fields = false;         // write them at the end of each stage
  double fields_interval = 0;  // s between them within a stage; 0: only at its end
  std::vector<std::string> fields_parts{observe::field_parts.begin(), observe::field_parts.end()};
  void declare(input::Section& s);
};

// Of a run in stages.
struct Output : FieldOutput {
  std::vector<std::string> histories{observe::history_parts.begin(), observe::history_parts.end()};
  bool ground_extremes = false;  // keep extremes of the ground's stress over each stage
  double surface_cell = 0.05;    // m, of the heights of the bed at the end of each stage
  std::vector<std::string> fields_stages = {};  // with fields; empty: all
  bool has_fields(const Stage& stage) const;
  void declare(input::Section& s);
};

// Time steps; 0: chosen by the program.
struct TimeParameters {
  double window = 0;          // s, of the coupling
  double step = 0;            // s, sub-step of the stones
  std::int64_t substeps = 1;  // in a window that the program chooses
  // Known from the rest of the deck before anything is built, so that a grossly wrong step is
  // reported with all other problems; the exact limits are checked when a stage begins.
  double rough_window = 0, rough_step = 0;  // s, set before `declare`
  void declare(input::Section& s);
};

// bed: stones, ground, sleepers and seat loads; track: a train on a rail and springs alone;
// track_on_ground: the same with a ground below the springs of some sleepers, without stones;
// ground: a ground alone under given pressures, in stages like those of a bed; stones: single
// stones and surfaces, each placed by the deck, in stages as well.
enum class ModelKind { bed, track, track_on_ground, ground, stones };

// Domain of the stones; empty: chosen by the program.
struct DomainParameters {
  std::vector<double> low, high;  // m
  void declare(input::Section& s);
};

// The contents of a model of kind stones.
struct PlacedParameters {
  std::vector<bed::StoneParameters> stones;
  std::vector<bed::PlateParameters> plates;
  std::vector<bed::BoxParameters> boxes;
  DomainParameters domain;
  void declare(input::Section& s);
};

// Constant after reading: the state of a run is in World and Course.
struct Model {
  std::string title;
  ModelKind kind = ModelKind::bed;
  Dimension dimension = Dimension::plane;
  double thickness = 1.3;             // m, plane models
  std::vector<std::string> periodic;  // "x", "y"
  std::string start;                  // checkpoint, written at the end of a stage
  std::string wall_material = "ballast", ground_material = "ballast";
  double settle_average = 5e-3;  // s, of the load on the ground before it starts to move
  dem::Physics physics;
  dem::Parameters dem;
  bed::BedParameters bed;
  fem::GroundParameters ground;
  std::vector<PressureParameters> pressures;  // of a ground alone
  PlacedParameters placed;                    // of stones alone
  track::SleeperParameters sleepers;
  SolidParameters solid;
  track::SeatLoadParameters load;
  track::SeatParameters seat;
  bed::PlatenParameters platen;
  bed::TampingParameters tamping;
  dem::BreakageParameters breakage;
  std::vector<dem::BondParameters> bonds;
  Output output;
  std::vector<observe::Region> regions;
  std::vector<observe::Sensor> sensors;
  TimeParameters time;
  std::vector<Stage> stages;
  TrackModel track;
  FootingParameters footing;    // of track_on_ground
  HandoverParameters handover;  // for jobs/handover.py
  JumpParameters jump;
  void declare(input::Section& s);

  bool periodic_in(const std::string& axis) const;
  double duration() const;  // s, of all stages
  bool has_stage(StageKind kind) const;
  bool has_one_grading() const;  // all stones are poured by this deck, by one stage
  bool uses_platen() const;
  bool has_train() const;  // in any stage
  // The stage from which on cycles are counted; null: none is.
  const Stage* counts_from() const;
  bool has_stages() const { return has_stones() || kind == ModelKind::ground; }
  bool has_stones() const { return has_bed() || is_placed(); }
  bool has_bed() const { return kind == ModelKind::bed; }
  bool is_placed() const { return kind == ModelKind::stones; }                  // stone by stone
  const char* stones_section() const { return is_placed() ? "stone" : "bed"; }  // of the deck
  bool uses_walls() const;  // or the platen, which has their material
  bool has_solid_rails() const;
  bool uses_sleepers() const;  // places them, or has them in the checkpoint it starts from
  int material(const std::string& name) const { return physics.material(name); }
  dem::Domain domain() const;
  bed::Container container() const;
  double pressure_in(const Stage& stage) const;  // Pa, of the platen
  // Numbers of the stages with which breakage begins and bonds are made, or of all stages.
  std::size_t breaks_from() const;
  std::size_t bonds_from(std::size_t kind) const;

 private:
  void declare_space(input::Section& s);
  void declare_bed(input::Section& s);
  void declare_time(input::Section& s);
  void declare_passage(input::Section& s);
  void declare_on_ground(input::Section& s);
  void declare_ground_alone(input::Section& s);
  void declare_placed(input::Section& s);
  void declare_dem(input::Section& s);
  // By name; none: the first one of kind load or passage, of placed stones the first one.
  std::size_t stage_of(const std::string& from) const;
};

}  // namespace trackbed::model
