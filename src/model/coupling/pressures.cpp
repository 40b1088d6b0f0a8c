// The loaded nodes follow from the undeformed top: displacements are small, and on deformed faces a
// uniform pressure would not give tributary areas (footprints.cpp). Of a rectangle that extends
// beyond the top only the part on it acts.
//
// The weights of moving rectangles are computed again in every window: cost rectangles times faces,
// far less than that of the elements below.
#include "trackbed/model/pressures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "trackbed/core/error.hpp"
#include "trackbed/input/table.hpp"

namespace trackbed::model {

namespace {

const std::vector<std::string_view> course_words = {"dead", "rise", "pulse", "harmonic", "table"};

double area_of(const couple::Rectangle& r) { return (r.x[1] - r.x[0]) * (r.y[1] - r.y[0]); }

}  // namespace

void PressureParameters::declare(input::Section& s) {
  constexpr double usual = 1e7;  // Pa
  s.text("name", name, "Name of the pressure, in messages and overrides.", {}, true);
  // Dead pressures too: they are part of the equilibrium.
  const auto fixed = s.fixed_by(input::state::moved_ground);
  s.numbers("x", x, {.unit = "m"}, "Ends of the rectangle along the track, at 0 s.", 2);
  s.numbers("y", y, {.unit = "m"},
            "Ends of the rectangle across the track (space); none: the whole width of the ground.");
  s.number("pressure", pressure, {.unit = "Pa", .usually_from = -usual, .usually_to = usual},
           "Pressure, positive downwards.");
  s.number("along", along, {.unit = "Pa", .usually_from = -usual, .usually_to = usual},
           "Shear stress along x, as from friction.");
  s.number("across", across, {.unit = "Pa", .usually_from = -usual, .usually_to = usual},
           "Shear stress along y (space).");
  s.choice("course", course, course_words,
           "Course over time; dead: constant, included in the static equilibrium at the start; "
           "rise: half a cosine over the duration, then constant (duration 0: a step); pulse: a "
           "haversine of that duration; harmonic: a sine; table: from the file.");
  s.number("begin", begin, {.unit = "s", .at_least = 0},
           "Start time of rise, pulse and harmonic. Times count from the start of the ground's "
           "motion.");
  s.number("duration", duration, {.unit = "s", .at_least = 0}, "Duration of rise and pulse.");
  s.number("frequency", frequency, {.unit = "Hz", .at_least = 0, .usually_to = 1000},
           "Frequency of the sine (harmonic).");
  s.file("file", file,
         "CSV with columns time_s and factor (table): linear between rows, constant before the "
         "first and after the last row.");
  s.number("speed", speed, {.unit = "m/s", .usually_from = -200, .usually_to = 200},
           "Speed of the rectangle along x, from 0 s on.");
  const auto range = [&](const char* key, const std::vector<double>& values) {
    s.rule(key, values.size() == 2 && values[0] < values[1], "must be two increasing numbers",
           {.reads = {key}});
  };
  range("x", x);
  if (!y.empty()) range("y", y);
  s.rule("pressure", pressure != 0 || along != 0 || across != 0,
         "the load is zero: set pressure, along or across",
         {.reads = {"pressure", "along", "across"}});
  s.rule("duration", course != PressureCourse::pulse || duration > 0,
         "must be above 0 s for a pulse", {.reads = {"course", "duration"}});
  s.rule("frequency", course != PressureCourse::harmonic || frequency > 0,
         "must be above 0 Hz for a harmonic pressure", {.reads = {"course", "frequency"}});
  s.rule("file", course != PressureCourse::table || !file.empty(),
         "must be given for course = \"table\"", {.reads = {"course", "file"}});
  s.rule("speed", course != PressureCourse::dead || speed == 0,
         "must be 0 m/s for a dead load, which is part of the static equilibrium",
         {.reads = {"course", "speed"}});
  const auto idle = [&](const char* key, bool given, bool used) {
    s.rule(key, used || !given,
           fmt::format("has no effect with course = \"{}\"",
                       course_words[static_cast<std::size_t>(course)]),
           {.severity = input::Severity::warning, .reads = {"course", key}});
  };
  const bool runs = course == PressureCourse::rise || course == PressureCourse::pulse;
  idle("begin", begin != 0, runs || course == PressureCourse::harmonic);
  idle("duration", duration != 0, runs);
  idle("frequency", frequency != 0, course == PressureCourse::harmonic);
  idle("file", !file.empty(), course == PressureCourse::table);
}

PressureParameters::Table PressureParameters::table() const {
  if (course != PressureCourse::table) return {};
  const auto columns = input::read_table(file, {"time_s", "factor"}, "time_s");
  if (columns[0].empty()) throw InputError({file + ": needs at least one row"});
  return {columns[0], columns[1]};
}

Pressures::Pressures(const par::Comm& comm, const Surface& top, bool around,
                     const std::vector<PressureParameters>& parameters)
    : comm_(comm), top_(top) {
  const auto [low, high] =
      std::minmax_element(top.position.begin(), top.position.end(),
                          [](const Vec3& a, const Vec3& b) { return a.y() < b.y(); });
  const auto [begin, end] =
      std::minmax_element(top.position.begin(), top.position.end(),
                          [](const Vec3& a, const Vec3& b) { return a.x() < b.x(); });
  if (around) low_ = begin->x(), length_ = end->x() - begin->x();
  for (const PressureParameters& given : parameters) {
    One one;
    one.given = given, one.table = given.table();
    one.rectangle = {.x = {given.x.at(0), given.x.at(1)}, .y = {low->y(), high->y()}};
    if (!given.y.empty()) one.rectangle.y = {given.y.at(0), given.y.at(1)};
    if (given.speed == 0) one.fixed = weights(one.rectangle);
    if (given.speed == 0 && one.fixed.empty())
      throw InputError({fmt::format(
          "pressure \"{}\" (x = {:g} to {:g} m, y = {:g} to {:g} m) is outside of the top of the "
          "ground (x = {:g} to {:g} m, y = {:g} to {:g} m); move it onto the top",
          given.name, one.rectangle.x[0], one.rectangle.x[1], one.rectangle.y[0],
          one.rectangle.y[1], begin->x(), end->x(), low->y(), high->y())});
    all_.push_back(std::move(one));
  }
}

// No own nodes: they are needed for means only.
std::vector<couple::Footprints::NodeWeight> Pressures::weights(
    const couple::Rectangle& rectangle) const {
  return couple::Footprints(comm_, top_, {}, {rectangle}).weights(0);
}

double Pressures::factor(const One& one, double time) const {
  const PressureParameters& p = one.given;
  const double since = time - p.begin, turn = since / p.duration;
  switch (p.course) {
    case PressureCourse::dead:
      return 1;
    case PressureCourse::rise:
      if (since < 0) return 0;
      return since >= p.duration ? 1 : (1 - std::cos(std::numbers::pi * turn)) / 2;
    case PressureCourse::pulse:
      return since <= 0 || turn >= 1 ? 0 : (1 - std::cos(2 * std::numbers::pi * turn)) / 2;
    case PressureCourse::harmonic:
      return since <= 0 ? 0 : std::sin(2 * std::numbers::pi * p.frequency * since);
    case PressureCourse::table:
      break;
  }
  const auto& [times, factors] = one.table;
  if (time <= times.front()) return factors.front();
  if (time >= times.back()) return factors.back();
  const auto next =
      static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  const double fraction = (time - times[next - 1]) / (times[next] - times[next - 1]);
  return factors[next - 1] + fraction * (factors[next] - factors[next - 1]);
}

// Weights are fractions of the rectangle's whole force, also if a part of it is outside of the top.
void Pressures::add_force(const One& one, double time, double factor,
                          std::vector<Vec3>& nodes) const {
  if (factor == 0) return;
  const PressureParameters& p = one.given;
  const Vec3 force = factor * area_of(one.rectangle) * Vec3(p.along, p.across, -p.pressure);  // N
  const auto add = [&](const std::vector<couple::Footprints::NodeWeight>& all) {
    for (const couple::Footprints::NodeWeight& of : all)
      nodes.at(static_cast<std::size_t>(of.node)) += of.weight * force;
  };
  if (p.speed == 0) return add(one.fixed);
  for (const couple::Rectangle& now : moved(one.rectangle, p.speed * time)) add(weights(now));
}

// The moved rectangle, and on a periodic top its periodic images that overlap the top.
std::vector<couple::Rectangle> Pressures::moved(const couple::Rectangle& rectangle,
                                                double travel) const {
  couple::Rectangle now = rectangle;
  for (double& x : now.x) x += travel;
  if (length_ == 0) return {now};
  const double turns = std::floor((now.x[0] - low_) / length_) * length_;
  for (double& x : now.x) x -= turns;
  std::vector<couple::Rectangle> images{now};
  for (couple::Rectangle image = now; image.x[1] > low_ + length_; images.push_back(image))
    for (double& x : image.x) x -= length_;
  return images;
}

void Pressures::add(double time, std::vector<Vec3>& nodes) const {
  for (const One& one : all_) add_force(one, time, factor(one, time), nodes);
}

void Pressures::add_dead(std::vector<Vec3>& nodes) const {
  for (const One& one : all_)
    if (one.given.course == PressureCourse::dead) add_force(one, 0, 1, nodes);
}

}  // namespace trackbed::model
