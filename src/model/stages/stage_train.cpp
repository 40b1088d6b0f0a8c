// Small and the same on all ranks, as sleepers are: no communication.
#include "model/stages/stage_train.hpp"

#include "trackbed/track/motion.hpp"

namespace trackbed::model {

namespace {

track::Train train_over(const TrackModel& t) {
  return {t.train, t.vehicles, t.line.track.rails, t.line.track.wheel_gauge()};
}

std::optional<track::IrregularityParameters> right_of(const TrackModel& t) {
  if (t.irregularity_right.kind == track::IrregularityKind::same) return {};
  return t.irregularity_right;
}

}  // namespace

// The numbers of wheels and bodies are widths of the histories, needed before the train starts.
StageTrain::StageTrain(World& world, const Model& model) : world_(world), model_(model) {
  if (!model.has_train()) return;
  const TrackModel& t = model.track;
  // Their files are read, and refused, at the start and not in the stage of the train.
  const track::Irregularity left(t.irregularity, t.line.track.length);
  if (const auto of_right = right_of(t))
    const track::Irregularity right(*of_right, t.line.track.length);
  const track::Train train = train_over(t);
  wheels_ = train.wheels().size();
  bodies_ = train.vehicles().size();
}

// The same as for a track alone.
double StageTrain::duration() const {
  const TrackModel& t = model_.track;
  const track::Train train = train_over(t);
  return track::Motion(t.train).time_at(t.line.track.length + train.axle_distance());
}

std::size_t StageTrain::rails() const {
  return model_.track.line.track.dimension == Dimension::space ? 2 : 1;
}

// For one rail those of the sleepers' centres.
std::vector<track::Seat> StageTrain::seats() const {
  const double aside = model_.sleepers.gauge / 2;
  std::vector<track::Seat> all;
  for (std::size_t i = 0; i < world_.sleepers->count(); ++i)
    for (std::size_t side = 0; side < rails(); ++side)
      all.push_back(track::seat_of(*world_.sleepers, i, side == 0 ? aside : -aside));
  return all;
}

// For solid sleepers those of the seats, for rigid ones as `seats`.
std::vector<double> StageTrain::levels() const {
  if (world_.solids) return world_.solids->seat_levels(step_);
  std::vector<double> all;
  for (const track::Seat& seat : seats()) all.push_back(seat.height);
  return all;
}

std::vector<double> StageTrain::rates() const {
  if (world_.solids) return world_.solids->seat_rates();
  std::vector<double> all;
  for (const track::Seat& seat : seats()) all.push_back(seat.rate);
  return all;
}

// Loads other than the train's are distributed equally to both seats.
std::vector<double> StageTrain::on_seats(const std::vector<double>& sums) const {
  if (!train_ || rails() == 1) return sums;
  std::vector<double> all;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double more = (train_->seat_force(i, 0) - train_->seat_force(i, 1)) / 2;
    all.insert(all.end(), {sums[i] / 2 + more, sums[i] / 2 - more});
  }
  return all;
}

// Solid sleepers have been advanced without the pads' forces at the end of the window.
void StageTrain::apply_pad_forces() {
  std::vector<double> forces;
  for (std::size_t i = 0; i < world_.sleepers->count(); ++i)
    for (std::size_t side = 0; side < rails(); ++side)
      forces.push_back(train_->seat_force(i, side));
  world_.solids->add_pad_forces(forces);
}

void StageTrain::take_away() {
  if (!train_) return;
  rail_ = train_->levels_without_load();
  train_.reset();
}

void StageTrain::send(double step, RailState rail, double ramp) {
  const TrackModel& t = model_.track;
  forces_ = {}, ends_ = {};
  step_ = step;
  track::TrainOnBedParameters parameters{.line = t.line,
                                         .vehicles = t.vehicles,
                                         .train = t.train,
                                         .wheel_rail = t.wheel_rail,
                                         .irregularity = t.irregularity,
                                         .seat = model_.seat,
                                         .sleepers = world_.sleepers->count(),
                                         .first = model_.sleepers.first,
                                         .step = step,
                                         .tolerance = t.passage.tolerance};
  parameters.irregularity_right = right_of(t);
  if (world_.solids) parameters.mobility = world_.solids->seat_mobility(step);
  if (rail == RailState::kept) parameters.kept = std::move(rail_), parameters.ramp = ramp;
  rail_.clear();
  train_.emplace(parameters, levels());
}

// Only wheels on the bed count: the others are on springs.
void StageTrain::record_wheels() {
  const track::SleeperParameters& bed = model_.sleepers;
  for (std::size_t i = 0; i < wheels_; ++i)
    if (const double x = train_->wheel_x(i);
        x >= bed.first - bed.spacing / 2 && x <= bed.last() + bed.spacing / 2)
      forces_.add(train_->passage().wheel_force(i));
}

// The next train starts at the end of a cycle; cycles are counted as for the settlement.
void StageTrain::move(std::int64_t trains, const Clock& clock) {
  if (!train_) return;
  train_->advance(levels(), rates());
  if (world_.solids) apply_pad_forces();
  record_wheels();
  ends_.observe(*train_, world_.sleepers->count());
  const std::int64_t window = clock.window(), windows = clock.windows();
  const auto number = [&](std::int64_t done) { return done * trains / windows; };
  if (window + 1 < windows && number(window + 1) > number(window)) train_->restart_train();
}

observe::TrainInstant StageTrain::instant() const {
  return {.wheels = wheels_,
          .bodies = bodies_,
          .rails = rails(),
          .running = train_ ? &*train_ : nullptr};
}

// A train is sent first, and takes over the stored state.
void StageTrain::archive(io::Archive& a, double step) {
  if (a.has("train", there())) {
    if (a.reads()) send(step, RailState::laid);
    a.part("train", *train_);
  }
  if (a.has("run/rail", !rail_.empty()))
    a.group("run/rail")(
        "levels", rail_,
        {"m",
         "heights of the rail seats at which the pads of the last train's rail carry no load"});
  a.part("run/wheels", forces_);
  a.part("run/rail_ends", ends_);
}

}  // namespace trackbed::model
