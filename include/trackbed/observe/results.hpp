// What a run leaves behind besides checkpoints: histories, envelopes and snapshots in one file
// (results.h5), and pictures for ParaView. Looks at the model, never changes it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "trackbed/dem/particles.hpp"
#include "trackbed/fem/bodies.hpp"
#include "trackbed/fem/ground.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/observe/regions.hpp"
#include "trackbed/par/comm.hpp"
#include "trackbed/track/on_bed.hpp"
#include "trackbed/track/sleepers.hpp"

namespace trackbed::observe {

// What there is to look at; a null pointer is a part the model does not have (yet).
struct Scene {
  const dem::Particles& particles;
  fem::Ground* ground = nullptr;  // const in spirit: its top() is only read
  const track::Sleepers* sleepers = nullptr;
  const fem::Bodies* bodies = nullptr;  // sleepers and rails that are solids
  bool stones = true;                   // whether the model can have any
};

// A wall or the floor: N from stones, mean of the last window; m, from where it was built.
struct WallState {
  std::string name;
  Vec3 force = Vec3::Zero(), displacement = Vec3::Zero();
};

// Zero while there is none.
struct PlatenState {
  double z = 0, pressure = 0;  // m, lower face; Pa, averaged by its servo
  Vec3 force = Vec3::Zero();   // N, from stones, mean of the last window
};

// A run with trains: numbers of wheels, vehicles and rails, and the one that is there now, if any.
struct TrainInstant {
  std::size_t wheels = 0, bodies = 0, rails = 1;
  const track::TrainOnBed* running = nullptr;
};

// Of sleepers that are solids: m, upwards, from where they were placed; Pa, tension positive, along
// the sleeper at its lower face. Seats of the first sleeper, then of the next.
struct SolidState {
  std::vector<double> seat_displacement, rail_displacement;  // of each seat, of a rail above it
  std::vector<double> bending_stress;                        // below each seat, then amid a sleeper
};

// A stone that the deck places by name, and what contacts did to it.
struct StoneInstant {
  std::string name;
  Vec3 position = Vec3::Zero(), velocity = Vec3::Zero(), spin = Vec3::Zero();
  Quat attitude = Quat::Identity();  // from the axes that its shape was described in to space
  Vec3 momentum = Vec3::Zero(), angular_momentum = Vec3::Zero();  // about its centre of mass
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();  // of all contacts, without gravity
  Vec3 impulse = Vec3::Zero();                       // N s, of that force since the begin
  double peak_force = 0;                             // N, largest since the begin
  std::int64_t contacts = 0;
};

// A plate or box that the deck places.
struct SurfaceInstant {
  std::string name;
  Vec3 force = Vec3::Zero(), displacement = Vec3::Zero();  // mean of the last window; from time 0
  Vec3 impulse = Vec3::Zero();                             // N s, since the begin
  double peak_force = 0;                                   // N, largest since the begin
};

// All of them in the order of the deck; energies in J, of all stones.
struct PlacedInstant {
  std::vector<StoneInstant> stones;
  std::vector<SurfaceInstant> surfaces;
  double translational = 0, rotational = 0;
  double supplied = 0, dissipated = 0;  // by what is driven; the rest of the balance
  Vec3 momentum = Vec3::Zero(), angular_momentum = Vec3::Zero();  // about the origin
  std::int64_t contacts = 0;
};

// The instant of a history row.
struct Instant {
  double time = 0;                        // s
  std::int64_t stage = 0;                 // number of the stage in the deck
  std::span<const double> seat_force;     // N, downwards, per sleeper
  std::span<const WallState> walls;       // all that the run ever has, in the same order
  const PlatenState* platen = nullptr;    // null: never one in this run
  const TrainInstant* train = nullptr;    // null: never one in this run
  const SolidState* solids = nullptr;     // null: never any in this run
  const PlacedInstant* placed = nullptr;  // null: never any in this run
};

struct About {
  std::string deck;     // the effective input
  std::string version;  // of the program
  // Per sieve: opening (m), passing as asked, lowest and highest allowed (%).
  std::vector<double> grading{};
};

// Rows x, y, z (m): the highest point of any stone in each cell of a lattice over the bed seen from
// above, x fastest; z is not a number where there is none. Cells are about `cell` m wide; a plane
// model has one row of them. The same bits on any number of ranks. Collective.
std::vector<double> surface_of(const par::Comm& comm, const dem::Particles& particles, double cell);

// Ground nodes that are watched: along the top, at one face (plane) or nearest the centre line,
// by x. To be asked while the ground is as built. The same list on every rank.
std::vector<std::int32_t> watched_nodes(fem::Ground& ground, Dimension dimension);

// Opens a file of results to read. Throws InputError if it is damaged or another's. Collective.
io::File open_results(const par::Comm& comm, const std::string& path);
// Whether `path` is there to go on with after a checkpoint that counts `rows` history rows; true if
// it counts none. Throws InputError if it is damaged, another's or has fewer rows. Collective.
bool has_histories(const par::Comm& comm, const std::string& path, std::int64_t rows);

// The file is replaced as a whole at every flush (copy, append, rename), so that a run killed at
// any instant leaves a file that opens.
class Results {
 public:
  // Goes on with the file of a stopped run, cut to `rows` history rows; snapshots of stages not
  // named in `finished` are left out; begins anew if it is not there. `has_histories` has been
  // asked before. Collective.
  Results(const par::Comm& comm, const std::string& path, const About& about);
  ~Results();
  Results(Results&&) noexcept;
  void resume(const std::string& old_path, std::int64_t rows,
              const std::vector<std::string>& finished);

  // Begins the file (unless it goes on) and fixes the columns of the histories. `nodes`: of the
  // ground's top, see watched_nodes; `sleeper_x`: m, also before the sleepers are placed.
  void watch(const Scene& scene, const std::vector<std::int32_t>& nodes,
             std::span<const double> sleeper_x, const std::vector<Region>& regions);
  void sample(const Scene& scene, const Instant& instant);
  std::int64_t rows() const;
  // Contact network, stones and surface of the bed (cells of `cell` m; 0: no bed) as they are,
  // under /chains/<stage>, /stones/<stage> and /surface/<stage>.
  void snapshot(const std::string& stage, const Scene& scene, double cell);
  // Extremes over the history rows of stage number `stage`, from the values of its first row.
  void envelope(std::int64_t stage);
  void flush();

 private:
  struct Room;
  std::unique_ptr<Room> room_;
};

// fields/<name>_{stones,ground,contacts,solids}.vtkhdf in `folder`. Collective.
void write_pictures(const par::Comm& comm, const std::string& folder, const std::string& name,
                    const Scene& scene);

}  // namespace trackbed::observe
