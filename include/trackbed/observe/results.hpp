// Results of a run besides checkpoints: histories, envelopes and snapshots in one file
// (results.h5), and field files for ParaView. Reads the model, never changes it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "trackbed/core/surface.hpp"
#include "trackbed/dem/particles.hpp"
#include "trackbed/fem/bodies.hpp"
#include "trackbed/fem/ground.hpp"
#include "trackbed/io/fields.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/observe/output_parts.hpp"
#include "trackbed/observe/regions.hpp"
#include "trackbed/observe/sensors.hpp"
#include "trackbed/par/comm.hpp"
#include "trackbed/track/on_bed.hpp"
#include "trackbed/track/sleepers.hpp"

namespace trackbed::observe {

// The observed model; a null pointer is a part that does not exist (yet).
// A surface and what it belongs to.
struct SceneSurface {
  enum class Part { wall, placed, sleeper, platen, tine };
  Part part;
  const Surface* surface;
  std::size_t number;  // as contacts name it
};

struct Scene {
  const dem::Particles& particles;
  fem::Ground* ground = nullptr;  // not changed: its top() is only read
  const track::Sleepers* sleepers = nullptr;
  const fem::Bodies* bodies = nullptr;      // solid sleepers and rails
  double gravity = 0;                       // m/s2, downward
  bool stones = true;                       // whether the model can have stones
  bool breaks = false;                      // whether their corners break
  bool bonds = false;                       // whether they can have bonds
  std::vector<SceneSurface> surfaces = {};  // all that stones touch but the ground
};

// A wall or the floor: force of the stones, N, mean of the last window; displacement since built,
// m.
struct WallState {
  std::string name;
  Vec3 force = Vec3::Zero(), displacement = Vec3::Zero();
};

// Zero while there is no platen.
struct PlatenState {
  double z = 0, pressure = 0;  // m, lower face; Pa, averaged by its servo
  Vec3 force = Vec3::Zero();   // N, of the stones, mean of the last window
};

// A run with trains: numbers of wheels, vehicles and rails, and the present train, if any.
struct TrainInstant {
  std::size_t wheels = 0, bodies = 0, rails = 1;
  const track::TrainOnBed* running = nullptr;
};

// Solid sleepers: vertical displacements since placed, m; stresses along the sleeper at its lower
// face, Pa, tension positive. Seats of the first sleeper, then of the next.
struct SolidState {
  std::vector<double> seat_displacement, rail_displacement;  // of each seat, of the rail above it
  std::vector<double> bending_stress;  // below each seat, then at the middle of a sleeper
};

// A stone that the deck places by name, and the effect of its contacts.
struct StoneInstant {
  std::string name;
  Vec3 position = Vec3::Zero(), velocity = Vec3::Zero(), spin = Vec3::Zero();
  Quat attitude = Quat::Identity();  // from the axes of its shape's description to space
  Vec3 momentum = Vec3::Zero(), angular_momentum = Vec3::Zero();  // about its centre of mass
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();  // of all contacts, without gravity
  Vec3 impulse = Vec3::Zero();                       // N s, of that force since the start
  double peak_force = 0;                             // N, largest since the start
  std::int64_t contacts = 0;
};

// A plate or box that the deck places.
struct SurfaceInstant {
  std::string name;
  Vec3 force = Vec3::Zero(), displacement = Vec3::Zero();  // mean of the last window; from time 0
  Vec3 impulse = Vec3::Zero();                             // N s, since the start
  double peak_force = 0;                                   // N, largest since the start
};

// All of them in the order of the deck; energies in J, of all stones.
struct PlacedInstant {
  std::vector<StoneInstant> stones;
  std::vector<SurfaceInstant> surfaces;
  double translational = 0, rotational = 0;
  double supplied = 0, dissipated = 0;  // work of driven bodies; the rest of the balance
  Vec3 momentum = Vec3::Zero(), angular_momentum = Vec3::Zero();  // about the origin
  std::int64_t contacts = 0;
};

// What the histories contain.
struct Recorded {
  std::vector<std::int32_t> nodes = {};  // of the ground's top, see monitored_nodes
  std::vector<double> sleeper_x = {};    // m, also before the sleepers are placed
  std::vector<std::string> stages = {};  // names, in the order of their numbers
  std::vector<Region> regions = {};
  std::vector<Sensor> sensors = {};
  std::vector<std::string> parts{history_parts.begin(), history_parts.end()};
};

// The instant of a history row.
struct Instant {
  double time = 0;                        // s
  std::int64_t stage = 0;                 // number of the stage in the deck
  std::span<const double> seat_force;     // N, downwards, per sleeper
  std::span<const WallState> walls;       // all walls of the run, always in the same order
  const PlatenState* platen = nullptr;    // null: none in this run
  double cycles = -1;                     // of load or trains up to now; below 0: not counted
  const TrainInstant* train = nullptr;    // null: none in this run
  const SolidState* solids = nullptr;     // null: none in this run
  const PlacedInstant* placed = nullptr;  // null: none in this run
  std::span<const SensorReading> sensors = {};
};

struct About {
  std::string deck;     // the effective input
  std::string version;  // of the program
  std::string build{};  // what it was built from
  // Per sieve: opening (m), specified passing, lowest and highest allowed (%).
  std::vector<double> grading{};
};

// Rows x, y, z (m): the highest point of any stone in each cell of a horizontal lattice over the
// bed, x fastest; z is NaN in empty cells. Cells are about `cell` m wide; a plane model has one row
// of them. Bitwise identical on any number of ranks. Collective.
std::vector<double> surface_of(const par::Comm& comm, const dem::Particles& particles, double cell);

// Monitored nodes of the ground's top, by x: at one face (plane) or nearest to the centre line. To
// be called while the ground is undeformed. The same list on every rank.
std::vector<std::int32_t> monitored_nodes(fem::Ground& ground, Dimension dimension);

// Opens a file of results for reading. Throws InputError if it is damaged or not a file of results.
// Collective.
io::File open_results(const par::Comm& comm, const std::string& path);
// Whether `path` can be continued after a checkpoint with `rows` history rows; true if there are
// none. Throws InputError if it is damaged, not a file of results or has fewer rows. Collective.
bool has_histories(const par::Comm& comm, const std::string& path, std::int64_t rows);

// The file is whole at any time, also if the run is killed: changes are made to a second file,
// which then takes its name.
class Results {
 public:
  // `resume` continues the file of a stopped run, cut to `rows` history rows, without snapshots of
  // stages not named in `finished`; starts a new file if there is none. `has_histories` must have
  // been called before. Collective.
  Results(const par::Comm& comm, const std::string& path, const About& about);
  ~Results();
  Results(Results&&) noexcept;
  void resume(const std::string& old_path, std::int64_t rows,
              const std::vector<std::string>& finished);

  // Creates the file (unless resumed) and defines the columns of the histories.
  void begin(const Scene& scene, const Recorded& recorded);
  void sample(const Scene& scene, const Instant& instant);
  std::int64_t rows() const;
  // Present contact network, stones and surface of the bed (cells of `cell` m; 0: no bed), in the
  // groups /chains/<stage>, /stones/<stage> and /surface/<stage>.
  void snapshot(const std::string& stage, const Scene& scene, double cell);
  // Extremes over the history rows of stage number `stage`, relative to its first row.
  void envelope(std::int64_t stage);
  void flush();
  // At the end of a run: replaces the file by a compressed one with the same contents. Returns why
  // that failed, or nothing; the file is complete in either case.
  std::string compress();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Where and when fields are written, and which (output_parts.hpp).
struct FieldFiles {
  std::string folder, name;
  double time = 0;  // s, of the run
  std::span<const std::string> parts;
  io::Origin origin{};
};

// A train over the sleepers of a scene; places in the coordinates of the bed.
struct TrainView {
  const track::TrainOnBed& running;
  std::size_t rails;    // 1 or 2
  double wheel_radius;  // m
  double sleeper_top;   // m, z of the bed's sleepers as placed
  double gauge;         // m, between the rails; 0: one rail
};

// Writes <name>_<part>.hdf for each part that the model has, and enters the file with its time
// into <part>.hdf.series, which ParaView opens as one series. Collective.
void write_fields(const par::Comm& comm, const FieldFiles& files, const Scene& scene,
                  const TrainView* train);

}  // namespace trackbed::observe
