// Tamping as by the machines: tines vibrate at about 35 Hz (Shi et al. 2020,
// doi:10.1016/j.compgeo.2020.103574), are inserted, squeeze, and are withdrawn while they open.
//
// Insertion and squeeze yield to the resistance of stones; the vibration does not, since an
// eccentric shaft drives it. A tine is a box long enough to keep its upper end out of the bed;
// shank and plate are not distinguished. Rejected: prescribed displacements, with which pebbles
// jammed between a tine and a sleeper overlapped them without limit.
//
// Cost: 8 nodes and 12 triangles for each tine. All sleepers are tamped at once; one after the
// other as in the field would take as many times as long.
#include "trackbed/bed/tamping.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace trackbed::bed {

namespace {

// m: of the tips above the highest stone initially, and of the upper ends at the lowest position.
constexpr double clear = 0.05;

// Increases from 0 to 1 without a jump of speed.
double eased(double fraction) {
  return (1 - std::cos(std::numbers::pi * std::clamp(fraction, 0.0, 1.0))) / 2;
}

// Corners as bits: x, y, z. Triangles are counter-clockwise seen from outside.
constexpr std::array<std::array<std::int32_t, 3>, 12> faces = {{{0, 2, 3},
                                                                {0, 3, 1},
                                                                {4, 5, 7},
                                                                {4, 7, 6},
                                                                {0, 1, 5},
                                                                {0, 5, 4},
                                                                {2, 6, 7},
                                                                {2, 7, 3},
                                                                {0, 4, 6},
                                                                {0, 6, 2},
                                                                {1, 3, 7},
                                                                {1, 7, 5}}};

constexpr std::size_t corners = 8;

void add_box(Surface& surface, const Vec3& low, const Vec3& size) {
  const auto first = static_cast<std::int32_t>(surface.nodes());
  for (int corner = 0; corner < static_cast<int>(corners); ++corner)
    surface.position.push_back(
        low + size.cwiseProduct(Vec3(corner & 1, (corner >> 1) & 1, (corner >> 2) & 1)));
  for (const auto& [a, b, c] : faces)
    surface.triangles.push_back({first + a, first + b, first + c});
}

}  // namespace

void TampingParameters::declare(input::Section& s) {
  s.number("lift", lift, {.unit = "m", .at_least = 0, .usually_to = 0.1},
           "Lift of the sleepers during the first insertion of the tines; the sleepers are held "
           "there until the stage ends.");
  s.number("depth", depth, {.unit = "m", .above = 0, .usually_to = 0.3},
           "Depth of the tips of the tines below the lower faces of the lifted sleepers.");
  s.number("gap", gap, {.unit = "m", .above = 0, .usually_to = 0.3},
           "Distance from a sleeper's face to the open tines beside it.");
  s.number("closing", closing, {.unit = "m", .at_least = 0, .usually_to = 0.2},
           "Displacement of each tine towards the sleeper during squeezing.");
  s.number("thickness", thickness, {.unit = "m", .at_least = 5e-3, .usually_to = 0.1},
           "Thickness of a tine along the track.");
  s.number("width", width, {.unit = "m", .above = 0, .usually_to = 0.3},
           "Width of a tine across the track (space).");
  s.numbers("y", y, {.unit = "m"}, "y of the centres of the tines beside a sleeper (space).");
  s.number("amplitude", amplitude, {.unit = "m", .at_least = 0, .usually_to = 0.02},
           "Amplitude of the vibration of the tines along the track.");
  s.number("frequency", frequency, {.unit = "Hz", .above = 0, .usually_to = 200},
           "Frequency of the vibration of the tines.");
  s.number("insertion", insertion, {.unit = "s", .above = 0, .usually_to = 5},
           "Duration of the insertion of the tines.");
  s.number("squeeze", squeeze, {.unit = "s", .above = 0, .usually_to = 5},
           "Duration of the closing of the tines.");
  s.number("withdrawal", withdrawal, {.unit = "s", .above = 0, .usually_to = 5},
           "Duration of the withdrawal and opening of the tines.");
  s.number("force", force, {.unit = "N", .above = 0, .usually_from = 100, .usually_to = 1e5},
           "Resistance of the stones at which the insertion or closing of one tine stops; below it "
           "the speed of the tine decreases linearly with the resistance.");
  s.rule("closing", closing + amplitude <= gap,
         fmt::format("closing plus amplitude, {:g} m, exceeds the gap of {:g} m: the tines would "
                     "hit the sleeper",
                     closing + amplitude, gap),
         {.reads = {"closing", "amplitude", "gap"}});
}

Tines::Tines(const TampingParameters& parameters, const TampedSleepers& sleepers,
             Dimension dimension, double thickness, int material)
    : parameters_(parameters),
      rows_(dimension == Dimension::plane ? 1 : parameters.y.size()),
      frames_(sleepers.x.size()) {
  const TampingParameters& p = parameters_;
  const bool plane = dimension == Dimension::plane;
  const double width = plane ? thickness : p.width;
  const std::vector<double> rows = plane ? std::vector{0.0} : p.y;
  for (std::size_t side = 0; side < 2; ++side) {
    Surface& surface = surfaces_[side];
    surface.name = names()[side];
    surface.material = material;
    for (const double x : sleepers.x)
      for (const double y : rows) {
        const double inner = sleepers.width / 2 + p.gap;
        const double low = side == 0 ? x - inner - p.thickness : x + inner;
        add_box(surface, Vec3(low, y - width / 2, 0), Vec3(p.thickness, width, 1));
      }
    surface.motion.assign(surface.nodes(), Vec3::Zero());
    surface.clear_load();
    initial_[side] = surface.position;
  }
}

// Upper nodes, at 1 m, are moved to the length of the tines.
void Tines::set_heights(double top, double underside) {
  highest_ = top, underside_ = underside;
  top_ = top + clear, foot_ = underside - parameters_.depth;
  const double length = top_ - foot_ + clear;
  for (std::vector<Vec3>& nodes : initial_)
    for (Vec3& node : nodes)
      if (node.z() > 0) node.z() = length;
  show_at_rest(0);
}

// m, towards the sleeper: a sine whose amplitude increases in its first period, to avoid an impact.
double Tines::vibration(double time) const {
  const double turns = parameters_.frequency * time;
  return parameters_.amplitude * std::min(1.0, turns) * std::sin(2 * std::numbers::pi * turns);
}

// Cycles follow each other. During the withdrawal the displacements decrease to zero in proportion
// from whatever values they reached: with s the completed fraction of the withdrawal, by the factor
// (1 - s(t + dt))/(1 - s(t)).
void Tines::move(Frame& frame, double time, double dt,
                 const std::array<Vec3, 2>& resistance) const {
  const TampingParameters& p = parameters_;
  const double t = std::fmod(time, p.cycle());
  const auto grown = [&](double begin, double length) {
    return eased((t + dt - begin) / length) - eased((t - begin) / length);
  };
  // Negative speed if the resistance exceeds the capacity of the drive.
  const double most = p.force * static_cast<double>(rows_);
  const auto speed_factor = [](double ratio) { return 1 - std::clamp(ratio, 0.0, 2.0); };
  frame.down += (top_ - foot_) * grown(0, p.insertion) *
                speed_factor((resistance[0].z() + resistance[1].z()) / (2 * most));
  for (std::size_t side = 0; side < 2; ++side) {
    const double outwards = (side == 0 ? -1 : 1) * resistance[side].x();
    frame.in[side] += p.closing * grown(p.insertion, p.squeeze) * speed_factor(outwards / most);
  }
  const double out = p.insertion + p.squeeze, left = 1 - eased((t - out) / p.withdrawal);
  const double shrunk = left > 0 ? (1 - eased((t + dt - out) / p.withdrawal)) / left : 0;
  frame.down *= shrunk, frame.in[0] *= shrunk, frame.in[1] *= shrunk;
}

Vec3 Tines::displacement_of(const Frame& frame, std::size_t side, double vibration) const {
  const double in = frame.in[side] + vibration;
  return {side == 0 ? in : -in, 0, top_ - frame.down};
}

// Sets the tines of one sleeper for a window between two positions of frame and vibration.
void Tines::place(std::size_t sleeper, const Frame& begin, const Frame& end,
                  const std::array<double, 2>& vibration) {
  const std::size_t each = corners * rows_;
  for (std::size_t side = 0; side < 2; ++side) {
    Surface& surface = surfaces_[side];
    const Vec3 from = displacement_of(begin, side, vibration[0]),
               to = displacement_of(end, side, vibration[1]);
    for (std::size_t n = sleeper * each; n < (sleeper + 1) * each; ++n)
      surface.position[n] = initial_[side][n] + from, surface.motion[n] = to - from;
  }
}

void Tines::advance(double time, double dt, const std::array<std::span<const Vec3>, 2>& force) {
  const std::size_t each = corners * rows_;
  for (std::size_t s = 0; s < frames_.size(); ++s) {
    std::array<Vec3, 2> resistance{Vec3::Zero(), Vec3::Zero()};
    for (std::size_t side = 0; side < 2; ++side)
      for (const Vec3& node : force[side].subspan(s * each, each)) resistance[side] += node;
    const Frame begin = frames_[s];
    move(frames_[s], time, dt, resistance);
    place(s, begin, frames_[s], {vibration(time), vibration(time + dt)});
  }
}

void Tines::show_at_rest(double time) {
  for (std::size_t s = 0; s < frames_.size(); ++s)
    place(s, frames_[s], frames_[s], {vibration(time), vibration(time)});
}

double Tines::lift(double time) const {
  return parameters_.lift * eased(time / parameters_.insertion);
}

Vec3 Tines::displacement(const std::string& name) const {
  const std::size_t side = name == names()[0] ? 0 : 1;
  Vec3 sum = Vec3::Zero();
  for (const Frame& frame : frames_) sum += displacement_of(frame, side, 0) - Vec3(0, 0, top_);
  return sum / static_cast<double>(frames_.size());
}

void Tines::archive(io::Archive& a) {
  a("top", highest_, {"m", "height of the highest stone before the first insertion"});
  a("underside", underside_, {"m", "height of the lower faces of the lifted sleepers"});
  if (a.reads()) set_heights(highest_, underside_);
  a.rows("down", frames_, {"m", "displacement of each sleeper's tines downwards"}, &Frame::down);
  a.rows("in_left", frames_, {"m", "displacement of the tines left of each sleeper towards it"},
         [](Frame& frame) -> double& { return frame.in[0]; });
  a.rows("in_right", frames_, {"m", "displacement of the tines right of each sleeper towards it"},
         [](Frame& frame) -> double& { return frame.in[1]; });
}

}  // namespace trackbed::bed
