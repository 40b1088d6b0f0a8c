// Whether wheels can be meant to follow a profile that was measured or made.
//
// A wheel at v m/s that meets a change of slope, or a jump, is pressed into the rail by what the
// profile departs from a straight line before either gives way: about the time sqrt(m/k) of their
// contact (m 150 kg of wheel and rail together, k 1.4 GN/m), in which it goes w = v sqrt(m/k),
//   D(x) = z(x + w) - 2 z(x) + z(x - w),   F = C_H D^1.5      m, N
// which is w times a change of slope, and all of a jump; even ramps have none, however steep.
// Rejected: slopes alone, which are those of ramps too; the force of a run, which comes too late.
#include "app/profile_doubts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "trackbed/track/wheel_rail.hpp"

namespace trackbed::app {

namespace {

constexpr double contact_time = 0.3e-3;  // s
constexpr double no_wheel_bears = 1e6;   // N, ten times what a heavy wheel carries
constexpr double as_heavy = 1e5;         // N, of a jump: as much again as a heavy wheel carries
constexpr double high = 0.1;             // m: more can only be millimetres

// Rows as wheels meet them, straight lines between: where is asked with rising x, in constant time.
class Rows {
 public:
  Rows(const track::Irregularity& of, double fade) : x_(of.rows()), z_(of.heights()), fade_(fade) {}
  double at(double x) {
    if (x <= 0) return 0;
    while (next_ < x_.size() && x_[next_] <= x) ++next_;
    return faded(x) * line(x);
  }

 private:
  double line(double x) const {
    if (next_ == 0) return z_.front();
    if (next_ == x_.size()) return z_.back();
    const double share = (x - x_[next_ - 1]) / (x_[next_] - x_[next_ - 1]);
    return z_[next_ - 1] + share * (z_[next_] - z_[next_ - 1]);
  }
  double faded(double x) const {
    if (x >= fade_) return 1;
    const double t = x / fade_;
    return t * t * (3 - 2 * t);
  }
  const std::vector<double>&x_, &z_;
  double fade_;
  std::size_t next_ = 0;
};

// Places where something is larger than a bound; those nearer than `apart` are one.
struct Places {
  double bound, apart;  // m, of the size; along the track
  double worst = 0, at = 0;
  bool last_is_worst = false;  // the place seen last
  std::vector<double> found = {};
  void see(double x, double size) {
    if (size <= bound) return;
    const bool same = !found.empty() && x - found.back() <= apart;
    // Rows before a jump see it as large as the last one, right before it.
    constexpr double alike = 1e-2;
    if (size > worst || (same && last_is_worst && size > worst * (1 - alike))) {
      worst = std::max(worst, size), at = x;
      last_is_worst = true;
    } else if (!same) {
      last_is_worst = false;
    }
    if (!same) found.push_back(x);
    found.back() = x;
  }
  bool is_near(double x) const {
    const auto next = std::lower_bound(found.begin(), found.end(), x - apart);
    return next != found.end() && *next <= x + apart;
  }
  std::string others() const {
    return found.size() < 2 ? "" : fmt::format(" and at {} other places", found.size() - 1);
  }
};

// Of a rise over `reach` m the part that neither the slope before it nor that behind it has.
Places jumps_of(const std::vector<double>& rows, const std::array<Rows, 4>& made, double reach,
                Places found) {
  auto [before, here, behind, far] = made;
  for (const double x : rows) {
    const double z = here.at(x), next = behind.at(x + reach);
    const double first = next - 2 * z + before.at(x - reach);
    const double second = z - 2 * next + far.at(x + 2 * reach);
    // Bent up and down again, or the other way round.
    if (first * second < 0) found.see(x, std::min(std::abs(first), std::abs(second)));
  }
  return found;
}

Places kinks_of(const std::vector<double>& rows, const std::array<Rows, 3>& made, double reach,
                const Places& jumps, Places found) {
  auto [before, here, behind] = made;
  for (const double x : rows) {
    const double bent = std::abs(behind.at(x + reach) - 2 * here.at(x) + before.at(x - reach));
    if (bent > found.bound && !jumps.is_near(x)) found.see(x, bent);
  }
  return found;
}

// What a file says that hardly anybody means, whatever rolls over it.
void doubt_rows(const TrackModel& model, const track::Irregularity& profile,
                const track::IrregularityParameters& p, std::vector<std::string>& to) {
  const std::vector<double>& rows = profile.rows();
  const double length = model.line.track.length;
  double most = 0;
  for (const double z : profile.heights()) most = std::max(most, std::abs(z));
  if (most > high)
    to.push_back(fmt::format("{} is up to {:g} m high; are heights in millimetres?", p.file, most));
  if (rows.back() < length || rows.front() > p.fade)
    to.push_back(
        fmt::format("{} reaches from {:g} to {:g} m, the track to {:g} m; beyond its rows the rail "
                    "is level",
                    p.file, rows.front(), rows.back(), length));
}

double largest_speed(const track::TrainParameters& train) {
  double speed = train.speed;
  for (const double later : train.speeds) speed = std::max(speed, later);
  return speed;
}

// Between two places, in m.
void doubt_strikes(const TrackModel& model, const track::Irregularity& profile,
                   const track::IrregularityParameters& p, const Way& way,
                   std::vector<std::string>& to) {
  const double speed = largest_speed(model.train);
  const double w = speed * std::max(contact_time, model.passage.step);
  const track::WheelRail law(model.wheel_rail);
  const std::vector<double>& all = profile.rows();
  const auto begin = std::lower_bound(all.begin(), all.end(), way.from);
  const std::vector<double> rows(begin, std::upper_bound(begin, all.end(), way.to));
  const Rows made(profile, p.fade);
  const Places jumps = jumps_of(rows, {made, made, made, made}, w / 4,
                                {.bound = law.approach(as_heavy), .apart = 2 * w});
  if (jumps.worst > 0)
    to.push_back(fmt::format(
        "{} jumps by {:.3g} mm at x = {:.10g} m{}: wheels would strike it with about "
        "{:.3g} kN; is a row wrong?",
        p.file, 1e3 * jumps.worst, jumps.at, jumps.others(), law.force(jumps.worst) / 1e3));
  const Places kinks = kinks_of(rows, {made, made, made}, w, jumps,
                                {.bound = law.approach(no_wheel_bears), .apart = 2 * w});
  if (kinks.worst > 0)
    to.push_back(
        fmt::format("{} changes its slope by {:.3g} mrad at x = {:.10g} m{}: at {:g} m/s wheels "
                    "would strike it with about {:.3g} kN, more than any wheel bears",
                    p.file, 1e3 * kinks.worst / w, kinks.at, kinks.others(), speed,
                    law.force(kinks.worst) / 1e3));
}

}  // namespace

std::vector<std::string> doubts_of_profile(const TrackModel& model,
                                           const track::Irregularity& profile,
                                           const track::IrregularityParameters& p) {
  std::vector<std::string> doubts;
  doubt_rows(model, profile, p, doubts);
  std::optional<Way> way = way_of_wheels(model);
  if (!way) return doubts;
  way->to = std::min(way->to, model.line.track.length);
  // The rail before the track is even: what a profile has at x = 0, wheels meet within one step.
  constexpr double felt = 1e-7;      // m: a hundredth of what wheel and rail approach by
  constexpr double behind_0 = 1e-9;  // m
  const double step = way->from <= 0 ? profile.at(behind_0) : 0;
  if (std::abs(step) > felt) {
    doubts.push_back(
        fmt::format("{} begins with a step of {:.3g} mm at x = 0, where wheels come from an even "
                    "rail: let it fade in (fade), or begin at 0",
                    p.file, 1e3 * step));
    way->from = largest_speed(model.train) * 2 * std::max(contact_time, model.passage.step);
  }
  doubt_strikes(model, profile, p, *way, doubts);
  return doubts;
}

}  // namespace trackbed::app
