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

// Sums over the stones that a sensor reads, and of the motion of those that it follows; each vector
// has three consecutive ones. Sensors of stones read those that they follow.
struct OfSensor {
  static constexpr std::size_t stones = 0, position = 1, velocity = 4, acceleration = 7,
                               followed = 10, moved = 11, quantities = 14;
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

Vec3 mean(const double* sum, std::size_t first, double number) {
  return Vec3(sum[first], sum[first + 1], sum[first + 2]) / number;
}

SensorReading means_of(const double* sum) {
  SensorReading reading;
  const double followed = sum[OfSensor::followed];
  if (followed > 0) reading.displacement = mean(sum, OfSensor::moved, followed);
  reading.stones = sum[OfSensor::stones];
  if (reading.stones == 0) return reading;
  reading.position = mean(sum, OfSensor::position, reading.stones);
  reading.velocity = mean(sum, OfSensor::velocity, reading.stones);
  reading.acceleration = mean(sum, OfSensor::acceleration, reading.stones);
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
         "Stage at the start of which the stones are chosen (kind = \"stones\") or from which on "
         "displacements are summed up (kind = \"place\"); empty: the last passage, or the last "
         "stage if there is none.");
  s.rule("radius", kind != SensorKind::place || radius > 0,
         "must be above 0 for kind = \"place\", which reads the stones around its place",
         {.reads = {"kind", "radius"}});
  s.rule("radius", kind != SensorKind::ground || radius == 0,
         "has no effect on a sensor in the ground; leave it out", {.reads = {"kind", "radius"}});
  s.rule("stage", kind != SensorKind::ground || stage.empty(),
         "has no effect on a sensor in the ground; leave it out", {.reads = {"kind", "stage"}});
}

Sensors::Sensors(const par::Comm& comm, const std::vector<Sensor>& sensors, double gravity)
    : comm_(comm), sensors_(sensors), gravity_(gravity), following_(sensors.size()) {}

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
    if (sensor.kind == SensorKind::ground) continue;
    if (sensor.stage != stage && !(sensor.stage.empty() && usual)) continue;
    following_[k] = {
        .begun = true,
        .stones = sensor.radius > 0 ? within(sensor, particles) : nearest(sensor, particles)};
    if (following_[k].stones.empty() && sensor.kind == SensorKind::stones)
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
  const auto add = [&](std::size_t sensor, const dem::ParticleView& stone) {
    sums.add(sensor, OfSensor::stones, 1.0);
    sums.add(sensor, OfSensor::position, stone.position);
    sums.add(sensor, OfSensor::velocity, stone.velocity);
    sums.add(sensor, OfSensor::acceleration, stone.acceleration(gravity_));
  };
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const dem::ParticleView stone = particles[i];
    for (std::size_t k = 0; k < sensors_.size(); ++k) {
      const Sensor& sensor = sensors_[k];
      if (sensor.kind == SensorKind::ground) continue;
      const bool at_place = sensor.kind == SensorKind::place;
      if (at_place &&
          from_place(particles.domain(), place_of(sensor), stone.position).norm() < sensor.radius)
        add(k, stone);
      const auto& all = following_[k].stones;
      const auto known = std::lower_bound(all.begin(), all.end(), stone.id,
                                          [](const Followed& one, Id id) { return one.id < id; });
      if (known == all.end() || known->id != stone.id) continue;
      if (!at_place) add(k, stone);
      sums.add(k, OfSensor::followed, 1.0);
      sums.add(k, OfSensor::moved, Vec3(stone.position - known->from));
    }
  }
  return sums.over_ranks(comm_, sensors_.size());
}

// Other stones come near and leave, so that positions of the present ones state no displacement:
// from row to row the same stones are compared.
SensorReading Sensors::read_place(std::size_t sensor, SensorReading reading, const double* sum,
                                  const dem::Particles& particles) {
  Following& place = following_[sensor];
  if (!place.begun) return reading;
  if (sum[OfSensor::followed] > 0) place.moved += reading.displacement;
  place.stones = within(sensors_[sensor], particles);
  reading.displacement = place.moved;
  return reading;
}

std::vector<SensorReading> Sensors::read(const dem::Particles* particles,
                                         const fem::Ground* ground) {
  std::vector<double> of_stones;
  if (particles) of_stones = sums_over(*particles);
  std::vector<fem::GroundPointState> states;
  if (ground) states = ground->states_at(points_);
  std::vector<SensorReading> readings;
  for (std::size_t k = 0, point = 0; k < sensors_.size(); ++k) {
    if (sensors_[k].kind != SensorKind::ground) {
      const double* sum = &of_stones[k * OfSensor::quantities];
      const SensorReading reading = means_of(sum);
      readings.push_back(sensors_[k].kind == SensorKind::place
                             ? read_place(k, reading, sum, *particles)
                             : reading);
      continue;
    }
    const fem::GroundPointState& state = states.at(point++);
    readings.push_back({.displacement = state.displacement,
                        .velocity = state.velocity,
                        .acceleration = state.acceleration,
                        .stress = state.stress,
                        .stress_static = state.stress_static});
  }
  return readings;
}

void Sensors::archive(io::Archive& a) {
  for (std::size_t k = 0; k < sensors_.size(); ++k) {
    Following& sensor = following_[k];
    if (!a.has(sensors_[k].name, sensor.begun)) continue;
    sensor.begun = true;
    io::Archive own = a.group(sensors_[k].name);
    std::vector<double> ids;
    for (const Followed& one : sensor.stones) ids.push_back(static_cast<double>(one.id));
    own("id", ids, {"-", "of the stones that the sensor follows"});
    sensor.stones.resize(ids.size());
    for (std::size_t i = 0; i < ids.size(); ++i) sensor.stones[i].id = static_cast<Id>(ids[i]);
    own.rows("from", sensor.stones,
             {"m", "where they were when chosen; of a place at its last row"}, &Followed::from);
    own("moved", sensor.moved, {"m", "displacement at a place up to the last history row"});
  }
}

// Columns of the motion, x y z each.
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
    const std::string since = in_ground ? ", relative to static equilibrium"
                              : kind == SensorKind::place
                                  ? ", summed up from row to row since the start of its stage"
                                  : ", since chosen";
    to.put(group + "displacement", {"m", "x y z, " + of + since}, reading.displacement);
    to.put(group + "velocity", {"m/s", "x y z, " + of}, reading.velocity);
    to.put(group + "acceleration", {"m/s2", "x y z, " + of + ", no filter"}, reading.acceleration);
    if (!in_ground) continue;
    const std::string where = "at the centre of the element, xx yy zz xy xz yz, tension positive, ";
    to.put(group + "stress", {"Pa", where + "relative to static equilibrium"}, reading.stress);
    to.put(group + "stress_static",
           {"Pa", where + "in static equilibrium; the total stress is the sum of both"},
           reading.stress_static);
  }
}

}  // namespace trackbed::observe
