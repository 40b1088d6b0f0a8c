// Whether wheels can be meant to follow a profile that was measured or made.
//
// A wheel at v m/s that meets a change of slope, or a jump, is pressed into the rail by what the
// profile departs from a straight line before either gives way: about the time sqrt(m/k) of their
// contact (m 130 kg of wheel and rail together, k N/m under a heavy wheel), in which it goes
// w = v sqrt(m/k),
//   D(x) = z(x + w) - 2 z(x) + z(x - w)   m
// which is w times a change of slope, and all of a jump; even ramps have none, however steep. The
// contact's force at D is the most there may be, and says where to look; what a wheel has there is
// told by a short run (strike.hpp). A wheel that a rail falls away from flies over what follows. So
// only what rises, or falls less than before, counts.
// Rejected: slopes alone, which are those of ramps too; a run over all of it, which comes too late.
#include "app/profile_doubts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "trackbed/track/wheel_rail.hpp"

namespace trackbed::app {

namespace {

constexpr double no_wheel_bears = 1e6;  // N, ten times what a heavy wheel carries
constexpr double as_heavy = 1e5;        // N, of a jump: as much again as a heavy wheel carries
constexpr double high = 0.1;            // m: more can only be millimetres

// s, of a heavy wheel.
double contact_time(const track::WheelRail& law) {
  constexpr double mass = 130;  // kg, of wheel and rail that give way together
  return std::sqrt(mass / law.slope(law.approach(as_heavy)));
}

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

// Places where something is larger than a bound. One is seen from rows that lie within `span` of
// its first.
struct Places {
  double bound, span;  // m, of the size; along the track
  double worst = 0, at = 0;
  bool last_is_worst = false;  // the place seen last
  std::vector<double> found = {};
  bool is_last(double x) const { return !found.empty() && x - found.back() <= span; }
  void see(double x, double size) {
    if (size <= bound) return;
    const bool same = is_last(x);
    // Rows before a jump see it as large as the last one, right before it.
    constexpr double alike = 1e-2, rounding = 1e-9;
    if (size > worst * (1 + rounding) || (same && last_is_worst && size > worst * (1 - alike))) {
      worst = std::max(worst, size), at = x;
      last_is_worst = true;
    } else if (!same) {
      last_is_worst = false;
    }
    if (!same) found.push_back(x);
  }
  bool is_near(double x, double within) const {
    const auto next = std::lower_bound(found.begin(), found.end(), x - within);
    return next != found.end() && *next <= x + within;
  }
  std::string others() const {
    if (found.size() < 2) return "";
    return fmt::format(" and at {} other place{}", found.size() - 1, found.size() > 2 ? "s" : "");
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
    if (!found.is_last(x)) found.see(x, rises(0));
    found.see(x, rises(1));
  }
  return found;
}

Places kinks_of(const std::vector<double>& rows, const std::array<Rows, 3>& made, double reach,
                const Places& jumps, Places found) {
  auto [before, here, behind] = made;
  for (const double x : rows) {
    const double bent = behind.at(x + reach) - 2 * here.at(x) + before.at(x - reach);
    if (bent > found.bound && !jumps.is_near(x, 2 * reach)) found.see(x, bent);
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

// A rail with its number, 0 left, 1 right.
struct Rail {
  std::size_t side;
  const track::IrregularityParameters& given;
  const track::Irregularity& profile;
};

std::string words_of_strike(const TrackModel& model, const Profiles& both, const Rail& rail,
                            double x) {
  const std::optional<double> force = strike_at(model, both, rail.side, x);
  if (!force) return "wheels strike it";
  return fmt::format("at {:g} m/s a wheel strikes it with about {:.0f} kN, in steps of {:g} s",
                     largest_speed(model.train), *force / 1e3, step_of_strikes(model));
}

// Between two places, in m.
void doubt_strikes(const TrackModel& model, const Profiles& both, const Rail& rail, const Way& way,
                   std::vector<std::string>& to) {
  const track::WheelRail law(model.wheel_rail);
  const double w = largest_speed(model.train) * contact_time(law);
  const std::vector<double>& all = rail.profile.rows();
  const auto begin = std::lower_bound(all.begin(), all.end(), way.from);
  const std::vector<double> rows(begin, std::upper_bound(begin, all.end(), way.to));
  const Rows made(rail.profile);
  const double reach = w / 4;
  const Places jumps =
      jumps_of(rows, made, reach, {.bound = law.approach(as_heavy), .span = 2 * reach});
  if (jumps.worst > 0)
    to.push_back(fmt::format("{} jumps by {:.3g} mm at x = {:.10g} m{}: {}; is a row wrong?",
                             rail.given.file, 1e3 * jumps.worst, jumps.at, jumps.others(),
                             words_of_strike(model, both, rail, jumps.at)));
  const Places kinks = kinks_of(rows, {made, made, made}, w, jumps,
                                {.bound = law.approach(no_wheel_bears), .span = 2 * w});
  if (kinks.worst > 0)
    to.push_back(
        fmt::format("{} changes its slope by {:.3g} mrad at x = {:.10g} m{}: {}; is it "
                    "meant?",
                    rail.given.file, 1e3 * kinks.worst / w, kinks.at, kinks.others(),
                    words_of_strike(model, both, rail, kinks.at)));
}

std::vector<std::string> doubts_of(const TrackModel& model, const Profiles& both,
                                   const Rail& rail) {
  std::vector<std::string> doubts;
  doubt_rows(model, rail.profile, rail.given, doubts);
  std::optional<Way> way = way_of_wheels(model);
  if (!way) return doubts;
  way->to = std::min(way->to, model.line.track.length);
  // The rail before the track is even: what a profile has at x = 0, wheels meet within one step.
  constexpr double felt = 1e-7;      // m: a hundredth of what wheel and rail approach by
  constexpr double behind_0 = 1e-9;  // m
  const double step = way->from <= 0 ? rail.profile.at(behind_0) : 0;
  if (std::abs(step) > felt) {
    doubts.push_back(
        fmt::format("{} begins with a step of {:.3g} mm at x = 0, where wheels come from an even "
                    "rail: let it fade in (fade), or begin at 0",
                    rail.given.file, 1e3 * step));
    way->from = largest_speed(model.train) * 2 * contact_time(track::WheelRail(model.wheel_rail));
  }
  doubt_strikes(model, both, rail, *way, doubts);
  return doubts;
}

}  // namespace

std::vector<std::string> doubts_of_profiles(const TrackModel& model, const Profiles& profiles) {
  std::vector<std::string> doubts;
  const auto look = [&](const Rail& rail, const char* section) {
    if (rail.given.kind != track::IrregularityKind::file) return;
    for (const std::string& doubt : doubts_of(model, profiles, rail))
      doubts.push_back(fmt::format("{}.file: {}", section, doubt));
  };
  look({0, model.irregularity, profiles.left}, "irregularity");
  if (profiles.right) look({1, model.irregularity_right, *profiles.right}, "irregularity_right");
  return doubts;
}

}  // namespace trackbed::app
