// Histories of a train on a track alone: stored in memory and written once, at the end. A passage
// has a few thousand rows of a few dozen numbers.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "trackbed/fem/ground.hpp"
#include "trackbed/io/archive.hpp"
#include "trackbed/observe/column.hpp"
#include "trackbed/observe/passage_envelope.hpp"
#include "trackbed/observe/results.hpp"
#include "trackbed/observe/sensors.hpp"
#include "trackbed/par/comm.hpp"
#include "trackbed/track/passage.hpp"

namespace trackbed::observe {

// J, at one instant, of all the rails that the ground carries, and without a ground of the modelled
// ones. The springs between track and ground count to the track.
struct PassageEnergies {
  double track = 0;            // kinetic and elastic
  double given_to_ground = 0;  // work of the track on the ground up to now
  fem::GroundEnergies ground = {};
};

// What the histories contain besides wheels, vehicles, seats and energies.
struct PassageRecorded {
  std::vector<double> points;        // m, of the rail; also the sleepers nearest to them, each once
  std::size_t forces = 0;            // number of forces on the rail
  std::vector<Sensor> sensors = {};  // in the ground
};

class PassageHistories {
 public:
  PassageHistories(const track::Line& line, const track::Train& train, PassageRecorded recorded);
  // Adds a row. `readings`: of the sensors, in the same order. Local.
  void sample(const track::Passage& passage, const PassageEnergies& energies,
              std::span<const SensorReading> readings = {});
  // Updates the extremes with the present step, which has a row only if it is sampled. Local.
  void update_extremes(const track::Passage& passage);
  std::int64_t rows() const { return static_cast<std::int64_t>(times_.size()); }
  // Over all steps: lowest rail displacement at each point, m, left before right; at most 0.
  const std::vector<double>& lowest() const { return lowest_; }
  void archive(io::Archive& a);  // rows and extremes
  // Writes results.h5 at `path` and replaces an existing file. Collective; throws RunError.
  void write(const par::Comm& comm, const std::string& path, const About& about, bool compress);

 private:
  void put(std::size_t column, double value) { columns_[column].values.push_back(value); }
  void put_energies(const PassageEnergies& energies);
  bool on_ground() const;

  const track::Line& line_;
  const track::Train& train_;
  PassageRecorded recorded_;
  std::vector<std::size_t> sleepers_;
  std::vector<double> times_, lowest_;
  PassageEnvelope envelope_;
  std::vector<Column> columns_, energy_, sensor_;
};

// Where a track is in the coordinates of its field files, and sizes that shapes need but motion
// does not, m.
struct TrackShape {
  double origin = 0;                         // x of the start of the track
  double y = 0;                              // of its middle
  double width = 0, height = 0, length = 0;  // of a sleeper, which stands on z = 0
  double wheel_radius = 0;
};

// As for beds: parts ground, surfaces (sleepers) and train. Collective.
void write_fields(const par::Comm& comm, const FieldFiles& files, const track::Passage& passage,
                  const track::Train& train, const TrackShape& shape, const fem::Ground* ground);

}  // namespace trackbed::observe
