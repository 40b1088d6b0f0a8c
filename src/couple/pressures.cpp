// What a rectangle presses on follows from the top as it was at rest: displacements are small, and
// a shape that moved would take the even pressure apart (footprints.cpp). A rectangle that reaches
// beyond the top presses with what of it lies there.
//
// Those that move get their weights anew in every window: rectangles times faces, far less than the
// zones below them cost.
#include "trackbed/couple/pressures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "trackbed/core/error.hpp"
#include "trackbed/input/table.hpp"

namespace trackbed::couple {

namespace {

double area_of(const Rectangle& r) { return (r.x[1] - r.x[0]) * (r.y[1] - r.y[0]); }

}  // namespace

void PressureParameters::declare(input::Section& s) {
  constexpr double usual = 1e7;  // Pa
  s.text("name", name, "Name of the pressure, in sentences and overrides.", {}, true);
  s.numbers("x", x, {.unit = "m"}, "From and to, along the track, at 0 s.", 2);
  s.numbers("y", y, {.unit = "m"},
            "From and to, across the track (space); none: all of the ground's width.");
  s.number("pressure", pressure, {.unit = "Pa", .usually_from = -usual, .usually_to = usual},
           "Downwards.");
  s.number("along", along, {.unit = "Pa", .usually_from = -usual, .usually_to = usual},
           "Along x, as friction does.");
  s.number("across", across, {.unit = "Pa", .usually_from = -usual, .usually_to = usual},
           "Along y (space).");
  s.choice("course", course, {"dead", "rise", "pulse", "harmonic", "table"},
           "dead: always, and the ground is at rest below it when it is let go; rise: up as half a "
           "cosine within the duration, then constant (0: at once); pulse: a haversine of that "
           "length; harmonic: a sine; table: as the file says.");
  s.number("begin", begin, {.unit = "s", .at_least = 0},
           "When rise, pulse and harmonic begin. Times count from when the ground is let go.");
  s.number("duration", duration, {.unit = "s", .at_least = 0}, "Of rise and pulse.");
  s.number("frequency", frequency, {.unit = "Hz", .at_least = 0, .usually_to = 1000},
           "Of harmonic.");
  s.file("file", file,
         "Of table: CSV with the columns time_s and factor, linear between rows, the first and the "
         "last row hold before and behind.");
  s.number("speed", speed, {.unit = "m/s", .usually_from = -200, .usually_to = 200},
           "Along x, from 0 s on.");
  const auto range = [&](const char* key, const std::vector<double>& values) {
    s.rule(key, values.size() == 2 && values[0] < values[1], "must be two numbers, from and to",
           {.reads = {key}});
  };
  range("x", x);
  if (!y.empty()) range("y", y);
  s.rule("pressure", pressure != 0 || along != 0 || across != 0,
         "nothing presses: give pressure, along or across",
         {.reads = {"pressure", "along", "across"}});
  s.rule("duration", course != Course::pulse || duration > 0, "must be above 0 s for a pulse",
         {.reads = {"course", "duration"}});
  s.rule("frequency", course != Course::harmonic || frequency > 0,
         "must be above 0 Hz for a harmonic pressure", {.reads = {"course", "frequency"}});
  s.rule("file", course != Course::table || !file.empty(), "must be given for course = \"table\"",
         {.reads = {"course", "file"}});
  s.rule("speed", course != Course::dead || speed == 0,
         "must be 0 m/s for a dead load, below which the ground is at rest",
         {.reads = {"course", "speed"}});
  const auto idle = [&](const char* key, bool given, bool used) {
    s.rule(key, used || !given, "has no effect on this course",
           {.weight = input::Weight::warning, .reads = {"course", key}});
  };
  const bool runs = course == Course::rise || course == Course::pulse;
  idle("begin", begin != 0, runs || course == Course::harmonic);
  idle("duration", duration != 0, runs);
  idle("frequency", frequency != 0, course == Course::harmonic);
  idle("file", !file.empty(), course == Course::table);
}

PressureParameters::Table PressureParameters::table() const {
  if (course != Course::table) return {};
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
  if (around) {
    const auto [begin, end] =
        std::minmax_element(top.position.begin(), top.position.end(),
                            [](const Vec3& a, const Vec3& b) { return a.x() < b.x(); });
    low_ = begin->x(), length_ = end->x() - begin->x();
  }
  for (const PressureParameters& given : parameters) {
    One one;
    one.given = given, one.table = given.table();
    one.rectangle = {.x = {given.x.at(0), given.x.at(1)}, .y = {low->y(), high->y()}};
    if (!given.y.empty()) one.rectangle.y = {given.y.at(0), given.y.at(1)};
    if (given.speed == 0) one.standing = shares(one.rectangle);
    if (given.speed == 0 && one.standing.empty())
      throw InputError(
          {fmt::format("pressure \"{}\" (x = {:g} to {:g} m, y = {:g} to {:g} m) lies beside the "
                       "top of the ground",
                       given.name, one.rectangle.x[0], one.rectangle.x[1], one.rectangle.y[0],
                       one.rectangle.y[1])});
    all_.push_back(std::move(one));
  }
}

// Footprints' means need own nodes; here nothing is asked back.
std::vector<Footprints::Share> Pressures::shares(const Rectangle& rectangle) const {
  return Footprints(comm_, top_, {}, {rectangle}).shares(0);
}

double Pressures::factor(const One& one, double time) const {
  const PressureParameters& p = one.given;
  const double since = time - p.begin, turn = since / p.duration;
  switch (p.course) {
    case Course::dead:
      return 1;
    case Course::rise:
      if (since < 0) return 0;
      return since >= p.duration ? 1 : (1 - std::cos(std::numbers::pi * turn)) / 2;
    case Course::pulse:
      return since <= 0 || turn >= 1 ? 0 : (1 - std::cos(2 * std::numbers::pi * turn)) / 2;
    case Course::harmonic:
      return since <= 0 ? 0 : std::sin(2 * std::numbers::pi * p.frequency * since);
    case Course::table:
      break;
  }
  const auto& [times, factors] = one.table;
  if (time <= times.front()) return factors.front();
  if (time >= times.back()) return factors.back();
  const auto next =
      static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  const double share = (time - times[next - 1]) / (times[next] - times[next - 1]);
  return factors[next - 1] + share * (factors[next] - factors[next - 1]);
}

// Weights are shares of the rectangle's whole force, also where a part of it lies beside the top.
void Pressures::press(const One& one, double time, double factor, std::vector<Vec3>& nodes) const {
  if (factor == 0) return;
  const PressureParameters& p = one.given;
  const Vec3 force = factor * area_of(one.rectangle) * Vec3(p.along, p.across, -p.pressure);  // N
  const auto add = [&](const std::vector<Footprints::Share>& shares) {
    for (const Footprints::Share& share : shares)
      nodes.at(static_cast<std::size_t>(share.node)) += share.weight * force;
  };
  if (p.speed == 0) return add(one.standing);
  for (const Rectangle& now : after(one.rectangle, p.speed * time)) add(shares(now));
}

// Where it is, and its images in the lengths before as far as they reach the top.
std::vector<Rectangle> Pressures::after(const Rectangle& rectangle, double way) const {
  Rectangle now = rectangle;
  for (double& x : now.x) x += way;
  if (length_ == 0) return {now};
  const double turns = std::floor((now.x[0] - low_) / length_) * length_;
  for (double& x : now.x) x -= turns;
  std::vector<Rectangle> images{now};
  for (Rectangle image = now; image.x[1] > low_ + length_; images.push_back(image))
    for (double& x : image.x) x -= length_;
  return images;
}

void Pressures::add(double time, std::vector<Vec3>& nodes) const {
  for (const One& one : all_) press(one, time, factor(one, time), nodes);
}

void Pressures::add_dead(std::vector<Vec3>& nodes) const {
  for (const One& one : all_)
    if (one.given.course == Course::dead) press(one, 0, 1, nodes);
}

}  // namespace trackbed::couple
