// Whether wheels can be meant to follow a profile that was measured or made.
//
// A wheel at v m/s that meets a change of slope, or a jump, is pressed into the rail by what the
// profile departs from a straight line before either gives way: about the time sqrt(m/k) of their
// contact (m 150 kg of wheel and rail together, k 1.4 GN/m), in which it goes w = v sqrt(m/k),
//   D(x) = z(x + w) - 2 z(x) + z(x - w),   F = C_H D^1.5      m, N
// which is w times a change of slope, and all of a jump; even ramps have none, however steep. It is
// the most there may be: runs have a third to a half of it at a V, and a wheel that a rail falls
// away from flies over what follows. So only what rises, or falls less than before, counts.
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

// Heights as wheels meet them: where is asked with rising x, in constant time.
class Rows {
 public:
  explicit Rows(const track::Irregularity& of) : of_(of) {}
  double at(double x) {
    while (next_ < of_.rows().size() && of_.rows()[next_] <= x) ++next_;
    return of_.before_row(next_, x);
  }

 private:
  const track::Irregularity& of_;
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

// Of a rise over `reach` m, from a row or up to it, the part that neither the slope before it nor
// that behind it has.
Places jumps_of(const std::vector<double>& rows, const Rows& made, double reach, Places found) {
  std::array<Rows, 5> around = {made, made, made, made, made};
  for (const double x : rows) {
    std::array<double, 5> z;
    for (std::size_t k = 0; k < z.size(); ++k)
      z[k] = around[k].at(x + (static_cast<double>(k) - 2) * reach);
    std::array<double, 3> bent;
    for (std::size_t k = 0; k < bent.size(); ++k) bent[k] = z[k] - 2 * z[k + 1] + z[k + 2];
    // Bent up and down again; up to a row only what no row before it has seen: a peak.
    const auto rises = [&](std::size_t k) { return std::min(bent[k], -bent[k + 1]); };
    const bool is_seen = !found.found.empty() && x - found.found.back() <= found.apart;
    if (!is_seen) found.see(x, rises(0));
    found.see(x, rises(1));
  }
  return found;
}

Places kinks_of(const std::vector<double>& rows, const std::array<Rows, 3>& made, double reach,
                const Places& jumps, Places found) {
  auto [before, here, behind] = made;
  for (const double x : rows) {
    const double bent = behind.at(x + reach) - 2 * here.at(x) + before.at(x - reach);
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
  const double w = speed * contact_time;
  const track::WheelRail law(model.wheel_rail);
  const std::vector<double>& all = profile.rows();
  const auto begin = std::lower_bound(all.begin(), all.end(), way.from);
  const std::vector<double> rows(begin, std::upper_bound(begin, all.end(), way.to));
  const Rows made(profile);
  const Places jumps =
      jumps_of(rows, made, w / 4, {.bound = law.approach(as_heavy), .apart = 2 * w});
  if (jumps.worst > 0)
    to.push_back(fmt::format(
        "{} jumps by {:.3g} mm at x = {:.10g} m{}: wheels would strike it with up to "
        "{:.3g} kN; is a row wrong?",
        p.file, 1e3 * jumps.worst, jumps.at, jumps.others(), law.force(jumps.worst) / 1e3));
  const Places kinks = kinks_of(rows, {made, made, made}, w, jumps,
                                {.bound = law.approach(no_wheel_bears), .apart = 2 * w});
  if (kinks.worst > 0)
    to.push_back(
        fmt::format("{} changes its slope by {:.3g} mrad at x = {:.10g} m{}: at {:g} m/s wheels "
                    "that follow it would strike with up to {:.3g} kN, more than any wheel bears",
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
    way->from = largest_speed(model.train) * 2 * contact_time;
  }
  doubt_strikes(model, profile, p, *way, doubts);
  return doubts;
}

}  // namespace trackbed::app
