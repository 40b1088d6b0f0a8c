// In each step, from t_n to t_n+1 = t_n + h, with g the mean height of the top below a sleeper, u
// the displacement of the sleeper (or ballast mass) above it, k and c of the spring between them:
//   1. ground: half a kick under the forces F_n, drift to t_n+1: g_n+1
//   2. track: implicit step with g_n+1, g'_n+1 below its ballast: u_n+1
//   3. F_n+1 = k (g_n+1 - u_n+1) + c (g'_n+1 - u'_n+1), upwards on the track, downwards on the top
//   4. ground: the other half of the kick, under F_n+1.
// g'_n+1, which only the damper uses, is the velocity at mid-step plus h/2 times the acceleration
// at the start of the step: its error is of order h^2. Both sides are therefore of second order,
// and no force is late (Belytschko, Mullen 1978, doi:10.1002/nme.1620121008: explicit nodes next to
// implicit ones).
//
// An implicit ground deflects under the forces at the end of its step. It takes the step under
// predicted forces, F_n + (F_n - F_n-1). The track has the compliance of the ground, the change of
// its heights in a step per unit force (a full matrix, computed once by a solve for each
// footprint), and solves for its own motion, the forces and the heights together; under these
// forces the ground repeats the step. The remaining difference is the tolerance of the linear
// solver.
#include "model/coupling/ground_below.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "trackbed/core/hash.hpp"
#include "trackbed/core/ratio.hpp"
#include "trackbed/core/whole_steps.hpp"
#include "trackbed/model/footing.hpp"

namespace trackbed::model {

namespace {

using Json = nlohmann::ordered_json;

// Ranges of exact sums, beyond any physical value.
constexpr double largest_height = 1e3, largest_rate = 1e5;  // m, m/s
constexpr double largest_work = 1e8;                        // J

}  // namespace

track::LineParameters line_on_ground(const Model& model) {
  track::LineParameters line = model.track.line;
  line.first_moved = static_cast<std::size_t>(model.footing.before);
  line.moved = static_cast<std::size_t>(model.footing.count);
  line.moves = track::MovedPart::ground;
  line.pads = model.track.passage.loaded_by == track::LoadedBy::train;
  return line;
}

GroundBelow::GroundBelow(const par::Comm& comm, const Model& model)
    : comm_(comm),
      ground_(comm, model.ground, model.dimension, model.thickness),
      own_(ground_.own_top()),
      footprints_(comm, ground_.top(), own_, footprints_of(model)),
      home_(ground_.top().position),
      first_(static_cast<std::size_t>(model.footing.before)),
      sides_(model.track.line.track.dimension == Dimension::space ? 2 : 1),
      rails_(model.footing.rails / static_cast<double>(sides_)),
      expected_(footprints_.count(), 0.0),
      force_before_(expected_),
      force_(footprints_.count(), 0.0),
      load_(ground_.top().nodes(), Vec3::Zero()),
      mean_(footprints_.count(), 0.0),
      height_(own_.size(), 0.0),
      mean_increment_(mean_),
      increment_(height_),
      node_work_(largest_work) {
  const double arm = model.track.line.track.bearing_arm();
  for (const couple::Rectangle& r : footprints_of(model))
    centre_.push_back(
        {(r.x[0] + r.x[1]) / 2, r.middle_y() + (centre_.size() % 2 == 0 ? arm : -arm)});
  const double longest = model.track.passage.step;
  const double stable = implicit() ? longest : stable_step(model);
  step_ = longest / static_cast<double>(steps_covering(longest, stable));
}

// The ground alone is stable up to h_c; springs and dampers of stiffness k and damping c on its top
// add
//   h^2 k L/4 + h c L,   L = largest eigenvalue of W' M^-1 W
// to a sum that must stay below 1 (W the weights w_in of node n in footprint i, m_n kg; the damper
// uses the velocity of the last half step, hence twice its half). The ground itself contributes at
// most h/h_c, since its part is convex in h. The same on any number of ranks.
double GroundBelow::stable_step(const Model& model) {
  std::vector<double> mass(ground_.top().nodes(), 0.0);
  for (const std::int32_t node : own_)
    mass[static_cast<std::size_t>(node)] = ground_.top_mass(node);
  comm_.max(std::span(mass));
  const track::Line line(line_on_ground(model));
  double k = 0, c = 0;
  for (std::size_t i = 0; i < footprints_.count(); ++i) {
    const auto [stiffness, damping] = line.ground_spring(sleeper(i), i % sides_);
    k = std::max(k, rails_ * stiffness), c = std::max(c, rails_ * damping);
  }
  const double most = largest_coupling(mass);
  const double safety = model.ground.safety, alone = ground_.stable_step(&limit_) / safety;
  const double b = 1 / alone + c * most;
  if (c * most > 1 / alone)
    limit_ = fmt::format("ballast dampers on the ground's top (the ground alone is limited by {})",
                         limit_);
  return 2 * safety / (b + std::sqrt(b * b + k * most * safety));
}

// 1/kg: L is at most the largest row sum, max_i sum_j |sum_n w_in w_jn / m_n|. For the two
// footprints of a sleeper on two rails, whose weights differ in sign, entries nearly cancel, while
// sums of magnitudes would double L.
double GroundBelow::largest_coupling(const std::vector<double>& mass) const {
  std::vector<std::vector<std::pair<std::size_t, double>>> on(mass.size());  // footprint, weight
  for (std::size_t i = 0; i < footprints_.count(); ++i)
    for (const auto& nodal : footprints_.weights(i))
      on[static_cast<std::size_t>(nodal.node)].emplace_back(i, nodal.weight);
  double most = 0;
  for (std::size_t i = 0; i < footprints_.count(); ++i) {
    std::map<std::size_t, double> row;
    for (const auto& nodal : footprints_.weights(i)) {
      const auto node = static_cast<std::size_t>(nodal.node);
      for (const auto& [j, weight] : on[node]) row[j] += nodal.weight * weight / mass[node];
    }
    double sum = 0;
    for (const auto& [j, entry] : row) sum += std::abs(entry);
    most = std::max(most, sum);
  }
  return most;
}

void GroundBelow::advance(track::Passage& passage) {
  const std::vector<Vec3> load_before = load_;
  {
    const auto timing = timers_->scope(Phase::ground);
    if (implicit() && !has_compliance_) compute_compliance(passage);
    begin_step();
  }
  std::vector<double> heights = set_seat_motion(passage);
  {
    const auto timing = timers_->scope(Phase::track);
    passage.advance();
  }
  apply_ballast_forces(passage);
  {
    const auto timing = timers_->scope(Phase::ground);
    ground_.end_step(load_);
  }
  if (implicit()) heights = heights_below();
  update_increments(heights);
  if (implicit()) compare_heights(passage);
  update_balance(load_before);
  ++steps_here_;
}

// Computes the compliance: by how much a force on one footprint lowers all of them by the end of a
// step. Displacements under unit forces are below the resolution of the exact sums of heights, so
// these sums have ranges of their own.
void GroundBelow::compute_compliance(track::Passage& passage) {
  constexpr double margin = 100;  // for sums of weights, which have both signs below two rails
  const auto count = static_cast<Eigen::Index>(footprints_.count());
  Eigen::MatrixXd give(count, count);
  for (Eigen::Index j = 0; j < count; ++j) {
    std::vector<double> one(footprints_.count(), 0.0);
    one[static_cast<std::size_t>(j)] = 1;
    std::vector<Vec3> load(load_.size(), Vec3::Zero());
    footprints_.add_forces(one, load);
    std::vector<couple::Footprints::Values> values{{{}, 0}};
    for (const Vec3& increment : ground_.deflection(step_, load)) {
      values[0].own.push_back(-increment.z());
      values[0].largest = std::max(values[0].largest, margin * std::abs(increment.z()));
    }
    values[0].largest = comm_.max(values[0].largest);
    const std::vector<double> lower = footprints_.means(values)[0];
    for (Eigen::Index i = 0; i < count; ++i)
      give(i, j) = rails_ * lower[static_cast<std::size_t>(i)];
  }
  passage.set_ground_compliance(give);
  has_compliance_ = true;
}

void GroundBelow::begin_step() {
  if (!implicit()) return ground_.begin_step(step_);
  for (std::size_t i = 0; i < force_.size(); ++i) expected_[i] = 2 * force_[i] - force_before_[i];
  std::vector<Vec3> load(load_.size(), Vec3::Zero());
  footprints_.add_forces(expected_, load);
  ground_.begin_step(step_, load);
}

// Sets the motion of the ground below the ballast at the end of the step. Returns the heights.
std::vector<double> GroundBelow::set_seat_motion(track::Passage& passage) {
  const auto timing = timers_->scope(Phase::coupling);
  const double ahead = implicit() ? 0 : 0.5 * step_;
  std::vector<couple::Footprints::Values> values{{{}, largest_height}, {{}, largest_rate}};
  for (const std::int32_t node : own_) {
    const fem::Ground::TopMotion motion = ground_.top_motion(node);
    values[0].own.push_back(motion.displacement.z());
    values[1].own.push_back(motion.velocity.z() + ahead * motion.acceleration.z());
  }
  const auto means = footprints_.means(values);
  std::vector<track::Seat> seats(footprints_.count());
  for (std::size_t i = 0; i < seats.size(); ++i)
    seats[i] = {.height = means[0][i], .rate = means[1][i]};
  if (implicit())
    passage.place_seats(seats, Eigen::Map<const track::Vector>(
                                   expected_.data(), static_cast<Eigen::Index>(expected_.size())) /
                                   rails_);
  else
    passage.place_seats(seats);
  return means[0];
}

// Applies the present forces of the ballast to the nodes.
void GroundBelow::apply_ballast_forces(const track::Passage& passage) {
  const auto timing = timers_->scope(Phase::coupling);
  force_before_ = force_;
  for (std::size_t i = 0; i < force_.size(); ++i)
    force_[i] = rails_ * passage.ground_force(sleeper(i), i % sides_);
  std::fill(load_.begin(), load_.end(), Vec3::Zero());
  footprints_.add_forces(force_, load_);
}

std::vector<double> GroundBelow::heights_below() const {
  const auto timing = timers_->scope(Phase::coupling);
  std::vector<couple::Footprints::Values> values{{{}, largest_height}};
  for (const std::int32_t node : own_)
    values[0].own.push_back(ground_.top_motion(node).displacement.z());
  return footprints_.means(values)[0];
}

// Displacement increments of nodes and footprints, now at these heights, in the step.
void GroundBelow::update_increments(const std::vector<double>& mean) {
  for (std::size_t n = 0; n < own_.size(); ++n) {
    const double height = ground_.top_motion(own_[n]).displacement.z();
    increment_[n] = height - height_[n];
    height_[n] = height;
  }
  for (std::size_t i = 0; i < mean.size(); ++i) mean_increment_[i] = mean[i] - mean_[i];
  mean_ = mean;
}

void GroundBelow::compare_heights(const track::Passage& passage) {
  for (std::size_t i = 0; i < mean_.size(); ++i) {
    const double of_track = passage.seat(i / sides_, i % sides_).height;
    height_off_ = std::max(height_off_, std::abs(of_track - mean_[i]));
    most_height_ = std::max(most_height_, std::abs(mean_[i]));
  }
}

// Compares force and moments of both sides about the middle of the first sleeper's footprint, and
// their work in the step, by the mean of the forces at its ends: of second order for leapfrog on a
// ground without dampers, exact for average acceleration. Forces below one rail have no arm across
// the track.
void GroundBelow::update_balance(const std::vector<Vec3>& load_before) {
  const auto timing = timers_->scope(Phase::coupling);
  double force = 0, all = 0;
  std::array<double, 2> moment{}, all_moment{};
  const std::array origin = {centre_[0][0], (centre_[0][1] + centre_[sides_ - 1][1]) / 2};
  for (std::size_t i = 0; i < force_.size(); ++i) {
    const double given = (force_before_[i] + force_[i]) / 2;
    force += force_[i], all += std::abs(force_[i]);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double turns = force_[i] * (centre_[i][axis] - origin[axis]);
      moment[axis] += turns, all_moment[axis] += std::abs(turns);
    }
    work_ -= given * mean_increment_[i];
    all_work_ += std::abs(given * mean_increment_[i]);
  }
  for (std::size_t n = 0; n < load_.size(); ++n) {
    force += load_[n].z();
    for (std::size_t axis = 0; axis < 2; ++axis)
      moment[axis] += load_[n].z() * (home_[n][static_cast<Eigen::Index>(axis)] - origin[axis]);
  }
  force_off_ = std::max(force_off_, ratio(std::abs(force), all));
  for (std::size_t axis = 0; axis < 2; ++axis)
    moment_off_[axis] =
        std::max(moment_off_[axis], ratio(std::abs(moment[axis]), all_moment[axis]));
  for (std::size_t n = 0; n < own_.size(); ++n) {
    const auto node = static_cast<std::size_t>(own_[n]);
    node_work_.add((load_before[node].z() + load_[node].z()) / 2 * increment_[n]);
  }
}

Json GroundBelow::figures() const {
  const fem::GroundTotals totals = ground_.totals();
  const double seconds = comm_.max(totals.seconds);
  const auto done = static_cast<double>(totals.elements) * static_cast<double>(steps_here_);
  Json of{{"elements", totals.elements},
          {"unknowns", totals.unknowns},
          {"steps", totals.steps},
          {"step_s", step_},
          {"element_steps_per_second_per_core", ratio(done, seconds) / comm_.size()},
          {"state_hash", fmt::format("{:016x}", state_hash())}};
  if (implicit()) of["iterations_mean"] = totals.iterations_mean;
  return of;
}

// Of all ranks.
FineSum GroundBelow::work_of_nodes() const {
  FineSum nodes = node_work_;
  comm_.sum(std::span<std::int64_t>(nodes.counts()));
  nodes.carry();
  return nodes;
}

// Difference of the work of nodes and of footprints over the sum of magnitudes of the work.
Json GroundBelow::balance() const {
  Json of{{"force", force_off_}, {"moment", moment_off_[0]}};
  if (sides_ == 2) of["roll_moment"] = moment_off_[1];
  of["work"] = ratio(std::abs(work_of_nodes().value() - work_), all_work_);
  if (implicit()) of["height"] = ratio(height_off_, most_height_);
  return of;
}

// Passage::track_energy assumes a rigid ground: k u^2/2 of a spring instead of k (u - g)^2/2, which
// is larger by g (k (g - u) - k g/2). Stops include the motion of the ground.
observe::PassageEnergies GroundBelow::energies(const track::Passage& passage) const {
  const track::Newmark& motion = passage.line_motion();
  const track::Vector still = track::Vector::Zero(motion.velocity.size());
  const track::Line& line = passage.line();
  double track = passage.track_energy();
  for (std::size_t i = 0; i < mean_.size(); ++i) {
    const std::size_t side = i % sides_;
    if (line.ground_stop(sleeper(i), side) >= 0) continue;
    const double spring =
        line.ground_force(sleeper(i), motion.displacement, still, {.height = mean_[i]}, side);
    track += mean_[i] * (spring - line.ground_spring(sleeper(i), side)[0] * mean_[i] / 2);
  }
  return {.track = rails_ * track, .given_to_ground = work_, .ground = ground_.energies()};
}

// Hashes of nodes are added, so that order and ranks do not matter; 40 bits each, so that no sum
// overflows.
std::uint64_t GroundBelow::state_hash() const {
  std::int64_t sum = 0;
  for (const std::int32_t node : own_) {
    const fem::Ground::TopMotion motion = ground_.top_motion(node);
    std::uint64_t hash = static_cast<std::uint64_t>(node);
    for (const Vec3* of : {&motion.displacement, &motion.velocity, &motion.acceleration})
      hash = mix(hash + hash_bytes(of->data(), 3 * sizeof(double)));
    sum += static_cast<std::int64_t>(hash >> 24);
  }
  return static_cast<std::uint64_t>(comm_.sum(sum));
}

// In addition to the ground's own state: the last forces, which the next step needs, and the sums
// up to now. Each rank continues its part of the nodes' work from 0, rank 0 from the whole sum.
void GroundBelow::archive(io::Archive& a) {
  a.part("ground", ground_);
  io::Archive own = a.group("footing");
  own.rows(
      "force", force_,
      {"N",
       "force of the ballast of each sleeper on the ground, down positive; with two rails: for "
       "each sleeper end, left first"});
  if (implicit())
    own.rows("force_before", force_before_, {"N", "force of the ballast one step earlier"});
  own("work", work_, {"J", "work done on the ground up to now"});
  own("work_magnitude", all_work_, {"J", "sum of the magnitudes of the work of all steps"});
  FineSum nodes = work_of_nodes();
  own("node_work/quanta", nodes.counts()[0],
      {"-",
       "work done on the ground up to now, summed exactly over its nodes, as a multiple of an "
       "internal unit of energy, which only a resume needs"});
  own("node_work/fine_quanta", nodes.counts()[1],
      {"-", "remainder of node_work/quanta, as a multiple of 2^-32 of its unit"});
  own("balance/force", force_off_, {"-", "largest relative imbalance of force"});
  own("balance/moment", moment_off_[0], {"-", "largest relative imbalance of the moment about y"});
  own("balance/roll_moment", moment_off_[1],
      {"-", "largest relative imbalance of the moment about x (only with two rails)"});
  own("balance/height", height_off_,
      {"m",
       "largest difference of the ground displacement below a sleeper between the solutions of "
       "track and ground (only with implicit steps)"});
  own("largest_height", most_height_,
      {"m", "largest displacement of the ground below a sleeper (only with implicit steps)"});
  if (!a.reads()) return;
  node_work_ = comm_.root() ? nodes : FineSum(largest_work);
  footprints_.add_forces(force_, load_);
  update_increments(heights_below());
}

}  // namespace trackbed::model
