// A deck that cannot be computed is an error. Parameters without effect or with unlikely values
// give a warning: decks are often varied by overrides on the command line, which may leave other
// parameters without effect.
#include "model/track_rules/track_rules.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/track_rules/coarse_steps.hpp"
#include "model/track_rules/profile_warnings.hpp"

namespace trackbed::model {

namespace {

using Kind = track::IrregularityKind;

// m, x of all sleepers, or of the middles of all elements of a rail.
std::vector<double> sleepers_of(const track::TrackParameters& track) {
  std::vector<double> x{0};
  for (const track::EvenPart& part : track.even_parts())
    for (std::int64_t k = 1; k <= part.count; ++k)
      x.push_back(part.from + static_cast<double>(k) * part.spacing());
  return x;
}

std::vector<double> element_middles(const track::TrackParameters& track) {
  std::vector<double> x;
  for (const track::EvenPart& part : track.even_parts()) {
    const double length = part.spacing() / static_cast<double>(track.elements);
    for (std::int64_t e = 0; e < part.count * track.elements; ++e)
      x.push_back(part.from + (static_cast<double>(e) + 0.5) * length);
  }
  return x;
}

bool holds(const track::TrackZone& zone, double x, double length) {
  return zone.covers(x, 0, length) || zone.covers(x, 1, length);
}

// Whether the zone contains any of the places x, m.
bool holds_place(const track::TrackZone& zone, double length, const std::vector<double>& places) {
  return std::any_of(places.begin(), places.end(),
                     [&](double x) { return holds(zone, x, length); });
}

// What a factor of zones needs: without it the factor has no effect.
struct ZoneNeeds {
  const char* name;
  double track::TrackZone::*factor;
  bool met;
  const char* lacking;
};

bool holds_pad_below(const track::LineParameters& line, const track::TrackZone& zone) {
  const std::vector<double> places = sleepers_of(line.track);
  return std::any_of(places.begin(), places.end(), [&](double x) {
    return line.under_sleeper.lie_at(x, line.track.length) && holds(zone, x, line.track.length);
  });
}

void declare_idle_factors(const TrackModel& model, std::size_t i, input::Section& s) {
  using Zone = track::TrackZone;
  const Zone& zone = model.line.track.zones[i];
  const bool sleepers = model.line.track.support == track::Support::sleepers;
  const bool pads = sleepers && model.passage.loaded_by != track::LoadedBy::seats;
  const char* none = "there are no sleepers (track.support)";
  for (const ZoneNeeds& of :
       {ZoneNeeds{"pad", &Zone::pad, pads, sleepers ? "there are no pads with seat loads" : none},
        {"sleeper", &Zone::sleeper, sleepers, none},
        {"under_sleeper_pad", &Zone::under_sleeper_pad, holds_pad_below(model.line, zone),
         "no sleeper of the zone has an under-sleeper pad (under_sleeper_pad.stiffness, from, to)"},
        {"footprint", &Zone::footprint, model.on_ground,
         "there are no footprints: these are for model = \"track_on_ground\""}})
    s.rule(fmt::format("track.zone[{}].{}", i, of.name), of.met || zone.*of.factor == 1,
           fmt::format("has no effect: {}", of.lacking),
           {.severity = input::Severity::warning,
            .reads = {"track", "under_sleeper_pad", "passage.loaded_by", "model"}});
}

void declare_zone(const track::TrackParameters& track, std::size_t i, input::Section& s) {
  const track::TrackZone& zone = track.zones[i];
  const input::About about{.severity = input::Severity::warning, .reads = {"track"}};
  const std::string from = fmt::format("track.zone[{}].from", i);
  const bool on = zone.to > 0 && zone.from < track.length;
  s.rule(from, on,
         fmt::format("begins a zone outside of the track, which reaches from 0 to {:g} m",
                     track.length),
         about);
  if (!on) return;
  const bool of_sleepers =
      zone.pad != 1 || zone.sleeper != 1 || zone.under_sleeper_pad != 1 || zone.footprint != 1;
  s.rule(from, zone.rail != 1 || zone.bed != 1 || zone.gap > 0 || zone.spacing > 0 || of_sleepers,
         "begins a zone without effect: all its factors are 1, and `gap` and `spacing` are 0",
         about);
  const bool elements = holds_place(zone, track.length, element_middles(track));
  s.rule(from, zone.rail == 1 || elements,
         "begins a zone that does not contain the middle of any rail element: its factor `rail` "
         "has no effect",
         about);
  const bool bears = track.support == track::Support::sleepers
                         ? holds_place(zone, track.length, sleepers_of(track))
                         : track.support == track::Support::continuous && elements;
  s.rule(
      from, (zone.bed == 1 && zone.gap == 0 && !of_sleepers) || bears,
      "begins a zone without a sleeper or another support of the rail: only `rail` has an effect",
      about);
}

// With seat loads there are no pads: sleepers need support from below.
void declare_seat_zones(const TrackModel& model, input::Section& s) {
  const track::TrackParameters& track = model.line.track;
  if (model.passage.loaded_by != track::LoadedBy::seats) return;
  const input::About about{.reads = {"track", "passage.loaded_by"}};
  for (std::size_t i = 0; i < track.zones.size(); ++i) {
    const track::TrackZone& zone = track.zones[i];
    s.rule(
        fmt::format("track.zone[{}].spacing", i),
        zone.spacing == 0 || model.load.kind == track::SeatLoadKind::seats,
        "must be 0 with seat loads (passage.loaded_by) that are equal for all seats: the load of "
        "a seat changes with the spacing; give each sleeper its own (load.kind = \"seats\")",
        about);
    const bool over = holds_place(zone, track.length, sleepers_of(track));
    s.rule(fmt::format("track.zone[{}].gap", i), zone.gap == 0 || !over,
           "must be 0 with seat loads (passage.loaded_by): hanging sleepers need pads and a rail, "
           "which do not exist",
           about);
    s.rule(
        fmt::format("track.zone[{}].bed", i), zone.bed > 0 || !over,
        "must be above 0 with seat loads (passage.loaded_by): the sleepers have no other support",
        about);
  }
}

// Number of sleepers, or of elements of a continuous bed, of this side that are supported in the
// unloaded track.
std::int64_t carried(const track::TrackParameters& track, std::size_t side) {
  const bool sleepers = track.support == track::Support::sleepers;
  std::int64_t count = 0;
  for (const double x : sleepers ? sleepers_of(track) : element_middles(track))
    count += std::none_of(track.zones.begin(), track.zones.end(), [&](const auto& zone) {
      return zone.covers(x, side, track.length) && (zone.bed == 0 || zone.gap > 0);
    });
  return count;
}

// A rail with free ends needs two supported sleepers, or it rotates about the only one, or one
// element of a continuous bed; a rail with pinned ends needs none.
void declare_support(const track::TrackParameters& track, input::Section& s) {
  if (track.support == track::Support::none || track.zones.empty()) return;
  const std::size_t sides = track.dimension == Dimension::space ? 2 : 1;
  std::int64_t least = carried(track, 0);
  if (sides == 2) least = std::min(least, carried(track, 1));
  const int needed = track.support == track::Support::sleepers ? 2 : 1;
  if (track.ends == track::RailEnds::free)
    s.rule("track.zone", least >= needed,
           fmt::format("leaves {} support{} of the rail, but a rail with free ends needs at least "
                       "{}; all other supports have bed = 0 or a gap",
                       least, least == 1 ? "" : "s", needed),
           {.reads = {"track"}});
  else
    s.rule(
        "track.zone", least > 0,
        "leaves no support of the rail between its pinned ends: all supports have bed = 0 or a gap",
        {.severity = input::Severity::warning, .reads = {"track"}});
}

void declare_under_sleeper(const track::LineParameters& line, input::Section& s) {
  const track::UnderSleeperPadParameters& pad = line.under_sleeper;
  const track::TrackParameters& track = line.track;
  if (pad.stiffness == 0 || track.support != track::Support::sleepers) return;
  s.rule(
      "under_sleeper_pad.from", holds_pad_below(line, {.from = 0, .to = track.length}),
      fmt::format("no sleeper has a pad: no sleeper of the track (0 to {:g} m) lies between `from` "
                  "and `to`",
                  track.length),
      {.severity = input::Severity::warning, .reads = {"under_sleeper_pad", "track"}});
}

// Values of one rail that its kind does not use.
void declare_unused(const track::IrregularityParameters& p, const std::string& section,
                    input::Section& s) {
  const track::IrregularityParameters none;
  const bool one = p.kind == Kind::versine || p.kind == Kind::vee || p.kind == Kind::joint;
  const bool closed = one || p.kind == Kind::waves, random = p.kind == Kind::spectrum;
  const auto unused = [&](const char* name, bool given, bool used) {
    s.rule(fmt::format("{}.{}", section, name), !given || used,
           fmt::format("has no effect with {}.kind = \"{}\"", section, track::word_of(p.kind)),
           {.severity = input::Severity::warning, .reads = {section}});
  };
  unused("at", p.at != none.at, closed);
  unused("depth", p.depth != none.depth, closed);
  unused("length", p.length != none.length, closed);
  unused("waves", p.waves != none.waves, p.kind == Kind::waves);
  unused("spectrum", p.spectrum != none.spectrum, random);
  unused("shortest", p.shortest != none.shortest, random);
  unused("longest", p.longest != none.longest, random);
  unused("seed", p.seed != none.seed, random);
  unused("fade", p.fade != none.fade, random || p.kind == Kind::file);
  unused("file", !p.file.empty(), p.kind == Kind::file);
}

// For a profile from `begin` to `end`, m, on the track: in a run-in the rail is nearly rigid, and
// impacts there are not realistic.
void declare_run_in(const track::TrackParameters& track, const std::string& at, double begin,
                    double end, input::Section& s) {
  const Range open = between_run_ins(track);
  const double from = std::max(begin, 0.0), to = std::min(end, track.length);
  const double over = std::max(std::min(to, open.to) - std::max(from, open.from), 0.0);
  s.rule(at, 2 * over >= to - from,
         fmt::format("puts {} of the irregularity into a run-in or run-out (track.run_in: up to "
                     "{:g} m and from {:g} m on), where rail and supports are up to {:g} times as "
                     "stiff: forces there are not realistic, and the summary contains only wheel "
                     "forces between run-in and run-out",
                     over > 0 ? "most" : "all", open.from, open.to, track.run_in_factor),
         {.severity = input::Severity::warning, .reads = {at.substr(0, at.find('.')), "track"}});
}

void declare_irregularity(const TrackModel& model, const track::IrregularityParameters& p,
                          const std::string& section, input::Section& s) {
  const double length = model.line.track.length;
  declare_unused(p, section, s);
  const std::vector<std::string> reads = {section, "track.length"};
  const bool waves = p.kind == Kind::waves;
  const bool closed =
      waves || p.kind == Kind::versine || p.kind == Kind::vee || p.kind == Kind::joint;
  const double begin = waves ? p.at : p.at - p.length / 2;
  const double end = waves ? p.at + static_cast<double>(p.waves) * p.length : p.at + p.length / 2;
  s.rule(section + ".at", !closed || (begin < length && end > 0),
         fmt::format("puts the irregularity outside of the track, which is {:g} m long", length),
         {.severity = input::Severity::warning, .reads = reads});
  if (closed && begin < length && end > 0)
    declare_run_in(model.line.track, section + ".at", begin, end, s);
  // Tracks without rolling wheels are reported elsewhere.
  if (const std::optional<Range> range = range_of_wheels(model);
      range && closed && begin < length && end > 0)
    s.rule(section + ".at",
           end > range->from && begin<range->to, end> range->from
               ? fmt::format("puts the irregularity where no wheel rolls: wheels roll up to {:g} m",
                             range->to)
               : fmt::format("puts the irregularity where no wheel rolls: wheels roll from {:g} m "
                             "on (train.start)",
                             range->from),
           {.severity = input::Severity::warning,
            .reads = {section, "track.length", "train", "vehicle", "passage.duration"}});
  s.rule(section + ".fade", p.kind != Kind::spectrum || p.fade > 0,
         "the random profile begins with a step at x = 0; give a length over which it fades in",
         {.severity = input::Severity::warning, .reads = reads});
  const double samples = track::Irregularity::samples_for(p.shortest, length);
  constexpr double most = 1e6;
  s.rule(section + ".shortest", p.kind != Kind::spectrum || samples <= most,
         fmt::format("gives {:.3g} samples over {:g} m of track; at most {:g} are possible: give "
                     "{:.2g} m or more",
                     samples, length, most, p.shortest * samples / most),
         {.reads = reads});
}

// Two rails with the same spectrum and seed have equal profiles and cause no roll.
void declare_alike(const TrackModel& model, input::Section& s) {
  const track::IrregularityParameters &left = model.irregularity, &right = model.irregularity_right;
  const bool alike = left.kind == Kind::spectrum && right.kind == Kind::spectrum &&
                     left.seed == right.seed && left.spectrum == right.spectrum &&
                     left.shortest == right.shortest && left.longest == right.longest;
  s.rule(
      "irregularity_right.seed", !alike,
      fmt::format("is that of the left rail ({}): both profiles are equal; give another seed, or "
                  "kind = \"same\"",
                  left.seed),
      {.severity = input::Severity::warning, .reads = {"irregularity", "irregularity_right"}});
}

}  // namespace

Range between_run_ins(const track::TrackParameters& track) {
  const double run_in = track.support == track::Support::none ? 0 : track.run_in;
  return {run_in, track.length - run_in};
}

void declare_ballast_mass(const TrackModel& model, std::int64_t first, std::int64_t count,
                          input::Section& s) {
  const track::TrackParameters& track = model.line.track;
  if (model.line.ballast.mass == 0 || track.support != track::Support::sleepers) return;
  std::vector<double> on_springs = sleepers_of(track);
  const auto of_bed = [&](std::int64_t k) {
    return on_springs.begin() + std::min(k, static_cast<std::int64_t>(on_springs.size()));
  };
  on_springs.erase(of_bed(first), of_bed(first + count));
  for (std::size_t i = 0; i < track.zones.size(); ++i)
    s.rule(fmt::format("track.zone[{}].bed", i),
           track.zones[i].bed > 0 || !holds_place(track.zones[i], track.length, on_springs),
           "must be above 0 with a mass of the ballast (ballast.mass), which has no other support",
           {.reads = {"track", "ballast", "sleepers", "seat"}});
}

void declare_track_rules(const TrackModel& model, input::Section& s) {
  const track::TrackParameters& track = model.line.track;
  for (std::size_t i = 0; i < track.zones.size(); ++i) {
    declare_zone(track, i, s);
    declare_idle_factors(model, i, s);
  }
  if (!model.on_bed) declare_support(track, s);
  declare_seat_zones(model, s);
  if (!model.on_bed) declare_ballast_mass(model, 0, 0, s);
  declare_under_sleeper(model.line, s);
  declare_irregularity(model, model.irregularity, "irregularity", s);
  declare_irregularity(model, model.irregularity_right, "irregularity_right", s);
  declare_alike(model, s);
  // On a ground the step is known when the model is built, on a bed with its other parameters.
  if (!model.on_bed && !model.on_ground) declare_coarse_steps(model, model.passage.step, s);
}

std::vector<std::string> warnings_of_files(const TrackModel& model) {
  const auto read = [&](const track::IrregularityParameters& p) {
    return track::Irregularity(p, model.line.track.length);
  };
  std::optional<track::Irregularity> right;
  if (model.irregularity_right.kind != Kind::same) right = read(model.irregularity_right);
  return warnings_of_profiles(model, {read(model.irregularity), right});
}

}  // namespace trackbed::model
