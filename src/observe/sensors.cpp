// Stones are found by their ids in one pass over the own stones of each rank, and sums over ranks
// are exact (observe/sums.hpp).
#include "trackbed/observe/sensors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "observe/column_writer.hpp"
#include "observe/impl.hpp"
#include "observe/sums.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::observe {

namespace {

// Sums over the stones of a sensor; each vector has three consecutive ones.
struct OfSensor {
  static constexpr std::size_t stones = 0, position = 1, displacement = 4, velocity = 7,
                               acceleration = 10, quantities = 13;
};

// From a place to a stone: to the nearest image in periodic directions; without y in a plane.
Vec3 from_place(const dem::Domain& domain, const Vec3& place, const Vec3& stone) {
  Vec3 d = stone - place;
  for (int a = 0; a < 3; ++a) {
    if (!domain.periodic[static_cast<std::size_t>(a)]) continue;
    const double period = domain.high[a] - domain.low[a];
    d[a] -= period * std::round(d[a] / period);
  }
  if (domain.dimension == Dimension::plane) d.y() = 0;
  return d;
}

Vec3 place_of(const Sensor& sensor) { return {sensor.at[0], sensor.at[1], sensor.at[2]}; }

SensorReading means_of(const double* sum) {
  SensorReading reading;
  reading.stones = sum[OfSensor::stones];
  if (reading.stones == 0) return reading;
  const auto mean = [&](std::size_t first) {
    return Vec3(Vec3(sum[first], sum[first + 1], sum[first + 2]) / reading.stones);
  };
  reading.position = mean(OfSensor::position);
  reading.displacement = mean(OfSensor::displacement);
  reading.velocity = mean(OfSensor::velocity);
  reading.acceleration = mean(OfSensor::acceleration);
  return reading;
}

}  // namespace

void Sensor::declare(input::Section& s) {
  s.text("name", name, "Name of the sensor in the results.", {}, true);
  s.choice("kind", kind, {"stones", "place", "ground"},
           "stones: moves with the stones that are near it when its stage starts; place: stays, "
           "and reads the stones that are near it at each row; ground: a point in the ground.");
  s.numbers("at", at, {.unit = "m", .required = true},
            "Place of the sensor (x, y, z); in a plane model y is not used. The top of a ground of "
            "layers is at z = 0.",
            3);
  s.number(
      "radius", radius, {.unit = "m", .at_least = 0, .usually_to = 1},
      "Radius around the sensor within which stones are averaged; 0: the nearest stone (kind = "
      "\"stones\" only).");
  s.text("stage", stage,
         "Stage at the start of which the stones are chosen (kind = \"stones\"); empty: the last "
         "passage, or the last stage if there is none.");
  s.rule("radius", kind != SensorKind::place || radius > 0,
         "must be above 0 for kind = \"place\", which reads the stones around its place",
         {.reads = {"kind", "radius"}});
  s.rule("radius", kind != SensorKind::ground || radius == 0,
         "has no effect on a sensor in the ground; leave it out", {.reads = {"kind", "radius"}});
  s.rule("stage", kind == SensorKind::stones || stage.empty(),
         "has an effect only for kind = \"stones\"; leave it out", {.reads = {"kind", "stage"}});
}

Sensors::Sensors(const par::Comm& comm, const std::vector<Sensor>& sensors, double gravity)
    : comm_(comm), sensors_(sensors), gravity_(gravity), followed_(sensors.size()) {}

void Sensors::locate(const fem::Ground& ground) {
  std::vector<Vec3> places;
  for (const Sensor& sensor : sensors_)
    if (sensor.kind == SensorKind::ground) places.push_back(place_of(sensor));
  points_ = ground.locate(places);
  std::vector<std::string> problems;
  for (std::size_t k = 0, point = 0; k < sensors_.size(); ++k) {
    if (sensors_[k].kind != SensorKind::ground || points_[point++].element >= 0) continue;
    const Vec3 at = place_of(sensors_[k]);
    problems.push_back(
        fmt::format("sensor[{}].at = [{:g}, {:g}, {:g}] m: sensor \"{}\" lies outside of the "
                    "ground; give a place within one of its elements",
                    k, at.x(), at.y(), at.z(), sensors_[k].name));
  }
  if (!problems.empty()) throw InputError(problems);
}

// By id. Vectors of Eigen cannot be sent.
std::vector<Sensors::Followed> Sensors::of_all_ranks(const std::vector<Followed>& mine) const {
  struct Sent {
    Id id;
    std::array<double, 3> from;
  };
  std::vector<Sent> sent;
  for (const Followed& one : mine)
    sent.push_back({one.id, {one.from.x(), one.from.y(), one.from.z()}});
  std::vector<Followed> all;
  for (const Sent& one : comm_.all_gather(std::span<const Sent>(sent)))
    all.push_back({one.id, Vec3(one.from[0], one.from[1], one.from[2])});
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  return all;
}

// The one with the lower id of two at the same distance.
std::vector<Sensors::Followed> Sensors::nearest(const Sensor& sensor,
                                                const dem::Particles& particles) const {
  double least = std::numeric_limits<double>::infinity();
  Followed found{std::numeric_limits<Id>::max()};
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const dem::ParticleView stone = particles[i];
    const double square =
        from_place(particles.domain(), place_of(sensor), stone.position).squaredNorm();
    if (square > least || (square == least && stone.id > found.id)) continue;
    least = square, found = {stone.id, stone.position};
  }
  const bool candidate = comm_.min(least) == least && particles.size() > 0;
  std::vector<Followed> all =
      of_all_ranks(candidate ? std::vector<Followed>{found} : std::vector<Followed>{});
  if (all.size() > 1) all.resize(1);
  return all;
}

std::vector<Sensors::Followed> Sensors::within(const Sensor& sensor,
                                               const dem::Particles& particles) const {
  std::vector<Followed> mine;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const dem::ParticleView stone = particles[i];
    if (from_place(particles.domain(), place_of(sensor), stone.position).norm() < sensor.radius)
      mine.push_back({stone.id, stone.position});
  }
  return of_all_ranks(mine);
}

std::vector<std::string> Sensors::begin_stage(const std::string& stage, bool usual,
                                              const dem::Particles& particles) {
  std::vector<std::string> warnings;
  for (std::size_t k = 0; k < sensors_.size(); ++k) {
    const Sensor& sensor = sensors_[k];
    if (sensor.kind != SensorKind::stones) continue;
    if (sensor.stage != stage && !(sensor.stage.empty() && usual)) continue;
    followed_[k] = sensor.radius > 0 ? within(sensor, particles) : nearest(sensor, particles);
    if (followed_[k].empty())
      warnings.push_back(
          fmt::format("sensor \"{}\" reads nothing: at the start of stage \"{}\" no stone has its "
                      "centre of mass within {:g} m of [{:g}, {:g}, {:g}] m; give a larger radius",
                      sensor.name, stage, sensor.radius, sensor.at[0], sensor.at[1], sensor.at[2]));
  }
  return warnings;
}

// Of the stones of each sensor, in the order of `OfSensor`.
std::vector<double> Sensors::sums_over(const dem::Particles& particles) const {
  Sums sums(OfSensor::quantities);
  const auto add = [&](std::size_t sensor, const dem::ParticleView& stone, const Vec3& from) {
    const Vec3 moved = stone.position - from;
    sums.add(sensor, OfSensor::stones, 1.0);
    sums.add(sensor, OfSensor::position, stone.position);
    sums.add(sensor, OfSensor::displacement, moved);
    sums.add(sensor, OfSensor::velocity, stone.velocity);
    sums.add(sensor, OfSensor::acceleration, stone.acceleration(gravity_));
  };
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const dem::ParticleView stone = particles[i];
    for (std::size_t k = 0; k < sensors_.size(); ++k) {
      const Sensor& sensor = sensors_[k];
      if (sensor.kind == SensorKind::place) {
        const Vec3 d = from_place(particles.domain(), place_of(sensor), stone.position);
        if (d.norm() < sensor.radius) add(k, stone, stone.position);
      } else if (sensor.kind == SensorKind::stones) {
        const auto& all = followed_[k];
        const auto known = std::lower_bound(all.begin(), all.end(), stone.id,
                                            [](const Followed& one, Id id) { return one.id < id; });
        if (known != all.end() && known->id == stone.id) add(k, stone, known->from);
      }
    }
  }
  return sums.over_ranks(comm_, sensors_.size());
}

std::vector<SensorReading> Sensors::read(const dem::Particles* particles,
                                         const fem::Ground* ground) const {
  std::vector<double> of_stones;
  if (particles) of_stones = sums_over(*particles);
  std::vector<fem::GroundPointState> states;
  if (ground) states = ground->states_at(points_);
  std::vector<SensorReading> readings;
  for (std::size_t k = 0, point = 0; k < sensors_.size(); ++k) {
    if (sensors_[k].kind != SensorKind::ground) {
      readings.push_back(means_of(&of_stones[k * OfSensor::quantities]));
      continue;
    }
    const fem::GroundPointState& state = states.at(point++);
    readings.push_back({.displacement = state.displacement,
                        .velocity = state.velocity,
                        .acceleration = state.acceleration,
                        .stress = state.stress});
  }
  return readings;
}

void Sensors::archive(io::Archive& a) {
  for (std::size_t k = 0; k < sensors_.size(); ++k) {
    const std::string group = sensors_[k].name;
    if (!a.has(group, !followed_[k].empty())) continue;
    io::Archive own = a.group(group);
    std::vector<double> ids;
    for (const Followed& one : followed_[k]) ids.push_back(static_cast<double>(one.id));
    own("id", ids, {"-", "of the stones that the sensor follows"});
    followed_[k].resize(ids.size());
    for (std::size_t i = 0; i < ids.size(); ++i) followed_[k][i].id = static_cast<Id>(ids[i]);
    own.rows("from", followed_[k], {"m", "where they were when chosen"}, &Followed::from);
  }
}

// Columns of the motion, x y z each; of a sensor that stays no displacement.
void put_readings(const std::vector<Sensor>& sensors, std::span<const SensorReading> readings,
                  std::vector<Column>& columns) {
  ColumnWriter to(columns);
  for (std::size_t k = 0; k < readings.size(); ++k) {
    const SensorKind kind = sensors[k].kind;
    const SensorReading& reading = readings[k];
    const std::string group = "history/sensor/" + sensors[k].name + "/";
    const bool in_ground = kind == SensorKind::ground;
    const std::string of = in_ground ? "of the ground" : "mean of the stones of the sensor";
    if (!in_ground) {
      to.put(group + "stones", {"-", "number of stones that the sensor reads"}, reading.stones);
      to.put(group + "position", {"m", "x y z, mean of the stones' centres of mass"},
             reading.position);
    }
    if (kind != SensorKind::place)
      to.put(group + "displacement",
             {"m",
              "x y z, " + of + (in_ground ? ", relative to static equilibrium" : ", since chosen")},
             reading.displacement);
    to.put(group + "velocity", {"m/s", "x y z, " + of}, reading.velocity);
    to.put(group + "acceleration", {"m/s2", "x y z, " + of + ", no filter"}, reading.acceleration);
    if (in_ground)
      to.put(group + "stress",
             {"Pa",
              "at the centre of the element, xx yy zz xy xz yz, tension positive, relative "
              "to static equilibrium"},
             reading.stress);
  }
}

}  // namespace trackbed::observe
