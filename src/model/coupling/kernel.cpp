#include "trackbed/model/kernel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>

#include "model/coupling/track_built.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/whole_steps.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/io/replace.hpp"
#include "trackbed/model/effective.hpp"

namespace trackbed::model {

namespace {

constexpr double most_numbers = 5e8;  // of a table, 4 GB

// Axles within this distance of the first one are of its bogie, as for `postproc forces`.
constexpr double longest_bogie = 4.0;  // m

// Of axles that are `behind` m behind the first one.
std::ptrdiff_t axles_of_first_bogie(const std::vector<double>& behind) {
  return std::count_if(behind.begin(), behind.end(),
                       [](double distance) { return distance <= longest_bogie; });
}

const char* name_of(std::size_t side) { return side == 0 ? "left" : "right"; }

// Reasons why a track has no Green's functions, or none of this kind.
std::vector<std::string> problems_of(const Model& model, const KernelParameters& parameters) {
  if (model.kind != ModelKind::track)
    return {"Green's functions are those of a track alone: set model = \"track\""};
  std::vector<std::string> problems;
  const track::TrackParameters& track = model.track.line.track;
  const auto refuse = [&](bool when, const std::string& why) {
    if (when) problems.push_back(why);
  };
  refuse(track.support != track::Support::sleepers,
         "track.support: there is no sleeper for the sensor; set \"sleepers\"");
  refuse(model.track.passage.loaded_by != track::LoadedBy::train,
         "passage.loaded_by: without rails there are no wheel forces; set \"train\"");
  refuse(!(parameters.sensor >= 0 && parameters.sensor <= track.length),
         fmt::format("--sensor {:g}: must be on the track, from 0 to {:g} m", parameters.sensor,
                     track.length));
  refuse(parameters.side == 1 && track.dimension != Dimension::space,
         "--side right: the track has one rail; set track.dimension = \"space\"");
  refuse(parameters.to != 0 && !(parameters.to > parameters.from),
         fmt::format("--to {:g}: must be above --from ({:g} m), or 0 for the end of the track",
                     parameters.to, parameters.from));
  refuse(!(parameters.from < track.length),
         fmt::format("--from {:g}: must be below the end of the track, {:g} m", parameters.from,
                     track.length));
  const double numbers = track.length / parameters.apart * parameters.duration * parameters.rate;
  refuse(
      numbers > most_numbers,
      fmt::format("{:.2g} numbers for each rail are too many (at most {:.0g}): reduce --duration "
                  "({:g} s) or --rate ({:g} Hz), or increase --apart ({:g} m)",
                  numbers, most_numbers, parameters.duration, parameters.rate, parameters.apart));
  return problems;
}

void refuse_stops(const track::Line& line) {
  if (line.stops().empty()) return;
  throw InputError(
      {"Green's functions are those of a linear track, but this one has gaps (track.zone.gap), "
       "bilinear pads (pad.bilinear_at) or pads that lift off (pad.uplift)"});
}

std::vector<double> positions(double from, double to, double apart) {
  std::vector<double> x;
  const auto count = static_cast<std::int64_t>(std::floor((to - from) / apart + rounding_of_steps));
  for (std::int64_t i = 0; i <= count; ++i) x.push_back(from + static_cast<double>(i) * apart);
  return x;
}

class Writer {
 public:
  Writer(const par::Comm& comm, io::File& file) : comm_(comm), file_(file) {}
  void axis(const std::string& path, const std::vector<double>& values, const io::Label& label) {
    file_.write<double>(path, mine(values.data(), values.size()), 1, label);
  }
  void table(const std::string& path, const track::Columns& values, const io::Label& label,
             const std::string& x) {
    file_.write<double>(path, mine(values.data(), static_cast<std::size_t>(values.size())),
                        static_cast<std::size_t>(values.cols()), label);
    file_.set_axis(path, 0, x);
    file_.set_axis(path, 1, "lag");
  }

 private:
  std::span<const double> mine(const double* values, std::size_t count) const {
    return {values, comm_.root() ? count : 0};
  }
  const par::Comm& comm_;
  io::File& file_;
};

// The wheels of the train on one rail.
struct Wheels {
  std::vector<double> behind, load, mass;
};

Wheels wheels_of(const BuiltTrack& built, std::size_t side) {
  Wheels found;
  for (std::size_t i = 0; i < built.train.wheels().size(); ++i) {
    const track::Train::Wheel& wheel = built.train.wheels()[i];
    if (wheel.side != side) continue;
    found.behind.push_back(wheel.behind);
    found.load.push_back(built.passage.wheel_force(i));
    const double mass =
        wheel.unknown < 0 ? 0 : built.train.system().mass.coeff(wheel.unknown, wheel.unknown);
    found.mass.push_back(mass / static_cast<double>(built.line.sides()));
  }
  return found;
}

void write_train(Writer& writer, io::File& file, const Model& model, const BuiltTrack& built,
                 const Wheels& wheels) {
  const auto put = [&](const char* name, const std::vector<double>& values,
                       const io::Label& label) {
    writer.axis(std::string("train/") + name, values, label);
  };
  put("behind", wheels.behind, {"m", "distance of each wheel behind the first one"});
  put("load", wheels.load, {"N", "static force of each wheel"});
  put("mass", wheels.mass, {"kg", "of each wheel with half its axle; 0: constant force"});
  file.attribute("train", "contact_constant", built.law.constant());
  const bool hertz = model.track.wheel_rail.law == track::WheelRailLaw::hertz;
  file.attribute("train", "contact_exponent", hertz ? 1.5 : 1.0);
}

void write_fixed(Writer& writer, const track::Line& line, const track::GreensFunctions& greens,
                 const std::vector<double>& x) {
  writer.axis("fixed/x", x, {"m", "position of the force"});
  for (std::size_t side = 0; side < line.sides(); ++side) {
    const std::string group = std::string("fixed/") + name_of(side);
    const track::GreensFunctions::Fixed found = greens.fixed(x, side);
    writer.table(group + "/displacement", found.displacement,
                 {"m/N", "of the sleeper with the sensor, due to a force on this rail"}, "fixed/x");
    writer.table(group + "/acceleration", found.acceleration,
                 {"m/s2/N", "of the sleeper with the sensor, due to a force on this rail"},
                 "fixed/x");
  }
}

void write_moving(Writer& writer, const track::Line& line, const track::GreensFunctions& greens,
                  const KernelParameters& parameters) {
  const double end = parameters.to > 0 ? std::min(parameters.to, line.length()) : line.length();
  const std::vector<double> x = positions(std::max(parameters.from, 0.0), end, parameters.apart);
  writer.axis("moving/x", x, {"m", "position of the force"});
  for (std::size_t side = 0; side < line.sides(); ++side)
    for (std::size_t axle = 0; axle < parameters.axles.size(); ++axle)
      writer.table(
          fmt::format("moving/{}/axle_{}", name_of(side), axle + 1), greens.moving(x, axle, side),
          {"m/N", "of the rail below the first wheel, due to the force of this axle"}, "moving/x");
}

}  // namespace

std::string write_kernel(const par::Comm& comm, const Model& model, KernelParameters parameters,
                         const std::string& path) {
  parameters.side = parameters.rail == "right" ? 1 : 0;
  parameters.step = model.track.passage.step;
  if (const std::vector<std::string> problems = problems_of(model, parameters); !problems.empty())
    throw InputError(problems);
  const TrackAssembly whole(comm, model);
  const BuiltTrack built(whole.track, whole.line);
  const track::Line& line = built.line;
  refuse_stops(line);
  const Wheels wheels = wheels_of(built, parameters.side);
  const auto bogie = parameters.bogie == 0
                         ? axles_of_first_bogie(wheels.behind)
                         : std::min<std::ptrdiff_t>(std::ssize(wheels.behind), parameters.bogie);
  if (bogie > 0) parameters.axles.assign(wheels.behind.begin(), wheels.behind.begin() + bogie);
  const track::GreensFunctions greens(line, parameters);
  const double sensor = line.sleeper_x(line.nearest_sleeper(parameters.sensor));
  if (comm.broadcast(std::filesystem::is_directory(path) ? "yes" : "") == "yes")
    throw InputError({path + " is a folder: give the name of a file (-o)"});
  if (const auto folder = std::filesystem::path(path).parent_path(); comm.root()) {
    std::error_code ignored;  // the file cannot be created then, which is reported
    std::filesystem::create_directories(folder, ignored);
  }
  io::replace_file(comm, path, [&](const std::string& part) {
    io::File file(comm, part, io::Mode::create);
    Writer writer(comm, file);
    std::vector<double> lag;
    for (std::size_t n = 0; n < greens.samples(); ++n)
      lag.push_back(static_cast<double>(n) / parameters.rate);
    writer.axis("lag", lag, {"s", "time since the force"});
    writer.axis("axles", parameters.axles, {"m", "distance of each axle behind the first one"});
    if (!wheels.behind.empty()) write_train(writer, file, model, built, wheels);
    write_fixed(writer, line, greens, positions(0, line.length(), parameters.apart));
    if (parameters.speed > 0) write_moving(writer, line, greens, parameters);
    file.attribute("/", "kind", std::string("trackbed Green's functions"));
    file.attribute("/", "version", version());
    file.attribute("/", "deck", effective_deck(model));
    file.attribute("/", "rate", parameters.rate);
    file.attribute("/", "sensor_x", sensor);
    file.attribute("/", "side", std::string(name_of(parameters.side)));
    file.attribute("/", "speed", parameters.speed);
    file.close();
  });
  return fmt::format(
      "{}: Green's functions of the sleeper at {:g} m, {} samples at {:g} Hz, forces {:g} m "
      "apart{}",
      path, sensor, greens.samples(), parameters.rate, parameters.apart,
      parameters.speed > 0
          ? fmt::format("; of the rail below a wheel at {:g} m/s", parameters.speed)
          : "");
}

}  // namespace trackbed::model
