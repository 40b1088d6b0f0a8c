// Checks whether wheels can follow a given profile, or whether the file is likely to be wrong.
//
// At a change of slope, or a jump, a wheel of speed v m/s approaches the rail by the deviation of
// the profile from a straight line before wheel and rail deflect: in about the time sqrt(m/k) of
// their contact (m 130 kg of wheel and rail together, k N/m under a heavy wheel), in which it
// travels w = v sqrt(m/k),
//   D(x) = z(x + w) - 2 z(x) + z(x - w)   m
// which is w times a change of slope, and the whole height of a jump; on ramps it is zero, however
// steep. The contact force at the approach D is an upper bound and locates the place; the force
// there is computed by a short run (strike.hpp). Where the rail falls away the wheel loses contact
// and flies. So only profiles that bend upwards count. Rejected: slopes alone, since ramps have
// them too; a run over the whole profile, which would be the run itself.
#include "model/track_rules/profile_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "trackbed/track/wheel_rail.hpp"

namespace trackbed::model {

namespace {

constexpr double excessive = 1e6;   // N, ten times the load of a heavy wheel
constexpr double wheel_load = 1e5;  // N, static load of a heavy wheel
constexpr double high = 0.1;        // m: larger heights are most likely given in millimetres

// s, of a heavy wheel.
double contact_time(const track::WheelRail& law) {
  constexpr double mass = 130;  // kg, effective mass of wheel and rail together
  return std::sqrt(mass / law.slope(law.approach(wheel_load)));
}

// Heights of the profile as below wheels; `at` must be called with rising x and takes constant
// time.
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

// Places where a quantity exceeds a bound. Rows within `span` of the first row of a place belong to
// it.
struct Places {
  double bound, span;  // m, of the size; along the track
  double worst = 0, at = 0;
  bool last_is_worst = false;  // whether the last place is the worst
  std::vector<double> found = {};
  bool is_last(double x) const { return !found.empty() && x - found.back() <= span; }
  void see(double x, double size) {
    if (size <= bound) return;
    const bool same = is_last(x);
    // All rows shortly before a jump give its height; the last of them is its position.
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

// Jumps: the rise over `reach` m from a row, or up to it, in excess of the slopes before and
// behind.
Places jumps_of(const std::vector<double>& rows, const Rows& made, double reach, Places found) {
  std::array<Rows, 5> around = {made, made, made, made, made};
  for (const double x : rows) {
    std::array<double, 5> z;
    for (std::size_t k = 0; k < z.size(); ++k)
      z[k] = around[k].at(x + (static_cast<double>(k) - 2) * reach);
    std::array<double, 3> bent;
    for (std::size_t k = 0; k < bent.size(); ++k) bent[k] = z[k] - 2 * z[k + 1] + z[k + 2];
    // Bent up and down again; a rise up to a row counts only if no earlier row has found it: a
    // peak.
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

// Warnings of heights and extents that are most likely wrong, independent of the train.
void warning_rows(const TrackModel& model, const track::Irregularity& profile,
                  const track::IrregularityParameters& p, std::vector<std::string>& to) {
  const std::vector<double>& rows = profile.rows();
  const double length = model.line.track.length;
  // A profile that begins and ends at height 0 continues evenly: a dip between even rails.
  const bool beyond = rows.back() < length && profile.heights().back() != 0;
  const bool before = rows.front() > p.fade && profile.heights().front() != 0;
  double most = 0;
  for (const double z : profile.heights()) most = std::max(most, std::abs(z));
  if (most > high)
    to.push_back(
        fmt::format("heights of {} are up to {:g} m (usual: at most {:g} m); are they given in mm "
                    "instead of m?",
                    p.file, most, high));
  if (beyond || before)
    to.push_back(fmt::format(
        "{} has rows from {:g} to {:g} m, but the track reaches from 0 to {:g} m; "
        "before the first and after the last row the profile keeps the height of that row",
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
  if (!force) return "wheels strike the rail there";
  return fmt::format(
      "at {:g} m/s the wheel force reaches about {:.0f} kN (computed with steps of {:g} s)",
      largest_speed(model.train), *force / 1e3, step_of_strikes(model));
}

// Warnings of jumps and changes of slope in a range of x.
void warning_strikes(const TrackModel& model, const Profiles& both, const Rail& rail,
                     const Range& range, std::vector<std::string>& to) {
  const track::WheelRail law(model.wheel_rail);
  const double w = largest_speed(model.train) * contact_time(law);
  const std::vector<double>& all = rail.profile.rows();
  const auto begin = std::lower_bound(all.begin(), all.end(), range.from);
  const std::vector<double> rows(begin, std::upper_bound(begin, all.end(), range.to));
  const Rows made(rail.profile);
  const double reach = w / 4;
  const Places jumps =
      jumps_of(rows, made, reach, {.bound = law.approach(wheel_load), .span = 2 * reach});
  if (jumps.worst > 0)
    to.push_back(fmt::format(
        "{} jumps by {:.3g} mm at x = {:.10g} m{} (limit {:.3g} mm): {}; is a row wrong?",
        rail.given.file, 1e3 * jumps.worst, jumps.at, jumps.others(), 1e3 * jumps.bound,
        words_of_strike(model, both, rail, jumps.at)));
  const Places kinks = kinks_of(rows, {made, made, made}, w, jumps,
                                {.bound = law.approach(excessive), .span = 2 * w});
  if (kinks.worst > 0)
    to.push_back(
        fmt::format("{} changes its slope by {:.3g} mrad at x = {:.10g} m{} (limit {:.3g} mrad): "
                    "{}; is this intended?",
                    rail.given.file, 1e3 * kinks.worst / w, kinks.at, kinks.others(),
                    1e3 * kinks.bound / w, words_of_strike(model, both, rail, kinks.at)));
}

std::vector<std::string> warnings_of(const TrackModel& model, const Profiles& both,
                                     const Rail& rail) {
  std::vector<std::string> warnings;
  warning_rows(model, rail.profile, rail.given, warnings);
  std::optional<Range> range = range_of_wheels(model);
  if (!range) return warnings;
  range->to = std::min(range->to, model.line.track.length);
  // The rail before the track is level: wheels pass a height of the profile at x = 0 in one step.
  constexpr double relevant = 1e-7;  // m: a hundredth of the approach of wheel and rail
  constexpr double behind_0 = 1e-9;  // m
  const double step = range->from <= 0 ? rail.profile.at(behind_0) : 0;
  if (std::abs(step) > relevant) {
    warnings.push_back(
        fmt::format("{} begins with a step of {:.3g} mm at x = 0, where wheels come from a level "
                    "rail: let the profile fade in (fade), or begin with height 0",
                    rail.given.file, 1e3 * step));
    range->from = largest_speed(model.train) * 2 * contact_time(track::WheelRail(model.wheel_rail));
  }
  warning_strikes(model, both, rail, *range, warnings);
  return warnings;
}

}  // namespace

std::vector<std::string> warnings_of_profiles(const TrackModel& model, const Profiles& profiles) {
  std::vector<std::string> warnings;
  const auto look = [&](const Rail& rail, const char* section) {
    if (rail.given.kind != track::IrregularityKind::file) return;
    for (const std::string& warning : warnings_of(model, profiles, rail))
      warnings.push_back(fmt::format("{}.file: {}", section, warning));
  };
  look({0, model.irregularity, profiles.left}, "irregularity");
  if (profiles.right) look({1, model.irregularity_right, *profiles.right}, "irregularity_right");
  return warnings;
}

}  // namespace trackbed::model
