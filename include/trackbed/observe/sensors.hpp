// Sensors that the deck places in the bed and in the ground, read at each row of the histories.
#pragma once

#include <array>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "trackbed/core/types.hpp"
#include "trackbed/dem/particles.hpp"
#include "trackbed/fem/ground.hpp"
#include "trackbed/input/section.hpp"
#include "trackbed/io/archive.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::observe {

// stones: moves with the stones that are near it when its stage begins; place: stays where it is
// and reads the stones that pass; ground: a point of the ground.
enum class SensorKind { stones, place, ground };

struct Sensor {
  std::string name;
  SensorKind kind = SensorKind::stones;
  std::vector<double> at = {0, 0, 0};  // m; y is not used in a plane
  double radius = 0;                   // m; 0: of the nearest stone only
  // At whose start stones are chosen or the displacement at a place is zero; empty: the last
  // passage, or the last stage without passages.
  std::string stage;
  void declare(input::Section& s);
};

// Of stones: means over them; not numbers without any, as before they are chosen.
struct SensorReading {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  double stones = 0;                     // their number, of a sensor in the bed
  Vec3 position = Vec3::Constant(none);  // m, of their centres of mass; of the ground: unused
  // m; of stones since they were chosen, of the ground since equilibrium. At a place it grows from
  // row to row, since its stage began, by the mean motion of the stones near it at the former row.
  Vec3 displacement = Vec3::Constant(none);
  Vec3 velocity = Vec3::Constant(none);      // m/s
  Vec3 acceleration = Vec3::Constant(none);  // m/s^2
  // Pa, of the ground: xx yy zz xy xz yz, tension positive; since static equilibrium, and in it.
  std::array<double, 6> stress{}, stress_static{};
};

// Numbers of a sensor in each row of the histories: motion, and in the ground both stresses, in the
// bed number and place of the stones.
constexpr int numbers_of_reading(SensorKind kind) { return kind == SensorKind::ground ? 21 : 13; }

// The same on all ranks; readings are bitwise identical on any number of ranks (with an implicit
// ground as its state is), but `stress_static` in an elastic ground only to the tolerance of the
// static solution, which is iterative. It is part of each row, although constant, because a stage
// may compute the equilibrium at any time.
class Sensors {
 public:
  Sensors(const par::Comm& comm, const std::vector<Sensor>& sensors, double gravity);

  // Finds the points in the ground. Throws InputError with a sentence for each that is outside of
  // it. Collective, as all below.
  void locate(const fem::Ground& ground);
  // Chooses the stones of all sensors of this stage and begins the displacements at places;
  // `usual`: it is that of sensors without one. Returns a warning for each sensor that follows no
  // stone.
  std::vector<std::string> begin_stage(const std::string& stage, bool usual,
                                       const dem::Particles& particles);
  // Once for each row. A null pointer is a part that the model does not have. In the order of the
  // deck.
  std::vector<SensorReading> read(const dem::Particles* particles, const fem::Ground* ground);
  bool empty() const { return sensors_.empty(); }
  void archive(io::Archive& a);  // stones chosen

 private:
  // A stone that a sensor follows, and where it was when chosen, m.
  struct Followed {
    Id id = 0;
    Vec3 from = Vec3::Zero();
  };
  // Of one sensor of stones or of a place, from its stage on.
  struct Following {
    bool begun = false;
    std::vector<Followed> stones;  // by id; of a place those near it at the last row
    Vec3 moved = Vec3::Zero();     // m, at a place, up to the last row
  };
  std::vector<double> sums_over(const dem::Particles& particles) const;
  SensorReading read_place(std::size_t sensor, SensorReading reading, const double* sum,
                           const dem::Particles& particles);
  std::vector<Followed> of_all_ranks(const std::vector<Followed>& mine) const;
  std::vector<Followed> nearest(const Sensor& sensor, const dem::Particles& particles) const;
  std::vector<Followed> within(const Sensor& sensor, const dem::Particles& particles) const;

  par::Comm comm_;
  const std::vector<Sensor>& sensors_;
  double gravity_;                        // m/s^2, of stones
  std::vector<Following> following_;      // of each sensor
  std::vector<fem::GroundPoint> points_;  // of those of the ground, in the order of the deck
};

}  // namespace trackbed::observe
