// Implementation of Results: columns of the histories and their file.
#pragma once

#include <array>
#include <functional>

#include "trackbed/observe/column.hpp"
#include "trackbed/observe/results.hpp"

namespace trackbed::observe {

inline constexpr const char* results_kind = "trackbed results";

// The origin of a file of results; the deck is the effective one. Collective.
void put_origin(const par::Comm& comm, io::File& file, const About& about);

// Adds a row of the readings of `sensors`, which is one reading each, or none.
void put_readings(const std::vector<Sensor>& sensors, std::span<const SensorReading> readings,
                  std::vector<Column>& columns);

// All ranks hold the same columns; rank 0 writes them.
struct Results::Impl {
  Impl(const par::Comm& comm, std::string path, About about);
  ~Impl();  // removes the twin
  Impl(const Impl&) = delete;
  void begin_file(const std::function<void(io::File&)>& write_positions);
  void put_head(io::File& file);
  std::string twin_path() const { return path + ".part"; }
  void take_name(const std::string& part);  // `part` replaces the results. Collective.
  // Changes a copy of the file, which then replaces it. Collective, as the following.
  void replace(const std::function<void(io::File&)>& change);
  void flush();
  void prepare_twin();
  void change_twin(const std::function<void(io::File&)>& change);
  // Columns of all groups; `impl` is an Impl or a constant one.
  template <class Self>
  static auto groups_of(Self& impl) {
    return std::array{&impl.energy, &impl.sleeper, &impl.traffic, &impl.ground,
                      &impl.region, &impl.wall,    &impl.platen,  &impl.train,
                      &impl.solid,  &impl.placed,  &impl.sensor};
  }
  void append_to(io::File& file);  // the rows in memory
  void append_last_to(io::File& file) const;
  void sample_energies(const Scene& scene, bool placed_stones);
  void sample_sleepers(const track::Sleepers* sleepers, std::span<const double> seat_force);
  bool records(std::string_view part) const;
  void set_ground_columns(Dimension dimension);
  void sample_ground(const fem::Ground& ground);
  void sample_walls(std::span<const WallState> walls);
  void sample_solids(const SolidState& state);
  void sample_platen(const PlatenState& state);
  void sample_placed(const PlacedInstant& instant);
  void sample_train(const TrainInstant& instant, std::size_t sleepers);
  void sample_regions(const dem::Particles& particles);

  par::Comm comm;
  std::string path;
  About about;
  bool resumed = false;                   // continues the file of a stopped run
  std::int64_t rows = 0;                  // in file and memory
  bool has_twin = false;                  // a file that has all but the rows of the last flush
  std::vector<double> times, last_times;  // s, as `values` and `last` of columns
  std::vector<std::int64_t> stages, last_stages;
  Recorded recorded;
  std::vector<int> axes;  // of their motion, the vertical first
  std::vector<Column> energy, sleeper, traffic, ground;
  std::vector<Column> platen, train, solid;
  std::vector<Column> placed;  // totals of all stones and surfaces, then those of each
  std::vector<Column> wall;    // force and displacement of the first, then those of the next
  std::vector<Column> sensor;  // as region
  std::vector<Column> region;  // those of the first region, then those of the next
};

}  // namespace trackbed::observe
