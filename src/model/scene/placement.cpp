// Impulses are integrated over windows by the trapezoidal rule, as in velocity Verlet: without
// local damping an impulse equals the change of momentum up to rounding.
//
// Cost: one sum over ranks of some twenty numbers per stone in each window. For experiments with a
// few stones; beds are observed by other means.
#include "model/scene/placement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "trackbed/core/error.hpp"

namespace trackbed::model {

namespace {

// Numbers per stone that are sent to all ranks.
constexpr std::size_t columns = 27;

std::array<double, columns> packed(const dem::ParticleView& p) {
  std::array<double, columns> row{};
  double* to = row.data();
  for (const Vec3& v : {p.position, p.velocity, p.spin, p.force, p.torque, p.angular_momentum})
    to = std::copy_n(v.data(), 3, to);
  to = std::copy_n(p.attitude.coeffs().data(), 4, to);
  for (const double number : {p.mass, p.held ? 1.0 : 0.0}) *to++ = number;
  return row;
}

// The sum of a number and zeros is exact, except that -0 + 0 is +0: so 0 is added on one rank, too.
dem::ParticleView unpacked(Id id, const double* row) {
  dem::ParticleView p{};
  p.id = id;
  for (Vec3* v : {&p.position, &p.velocity, &p.spin, &p.force, &p.torque, &p.angular_momentum}) {
    for (int a = 0; a < 3; ++a) (*v)[a] = *row++ + 0.0;
  }
  for (int k = 0; k < 4; ++k) p.attitude.coeffs()[k] = *row++ + 0.0;
  p.mass = *row++, p.held = *row > 0;
  return p;
}

}  // namespace

void Placement::ContactImpulse::add(const Vec3& now, double dt) {
  impulse += dt / 2 * (force + now);
  peak = std::max(peak, now.norm());
  force = now;
}

Placement::Placement(const par::Comm& comm, const Model& model)
    : comm_(comm),
      model_(model),
      surfaces_(model.placed.plates, model.placed.boxes, model.physics, model.dimension,
                model.domain().thickness),
      axes_(model.placed.stones.size(), Quat::Identity()),
      on_stones_(model.placed.stones.size()),
      on_surfaces_(surfaces_.surfaces().size()) {}

namespace {

// The first stone with the same shape, possibly the stone itself.
std::size_t first_alike(const std::vector<bed::StoneParameters>& stones, std::size_t i) {
  const bed::ShapeParameters& wanted = stones[i];
  const auto same =
      std::find_if(stones.begin(), stones.begin() + static_cast<std::ptrdiff_t>(i),
                   [&](const bed::ShapeParameters& shape) { return shape == wanted; });
  return static_cast<std::size_t>(same - stones.begin());
}

}  // namespace

// Equal shapes are made once: the computation of the sieve size takes time.
const std::vector<bed::PlacedShape>& Placement::make_shapes() {
  const auto& stones = model_.placed.stones;
  if (shapes_.size() == stones.size()) return shapes_;
  std::vector<std::string> problems;
  for (std::size_t i = 0; i < stones.size(); ++i) {
    const std::size_t first = first_alike(stones, i);
    try {
      shapes_.push_back(first < i ? shapes_[first]
                                  : bed::placed_shape(comm_, stones[i], model_.dimension));
    } catch (const InputError& error) {  // equal on all ranks
      problems.push_back(fmt::format("stone[{}].{}", i, error.what()));
      shapes_.emplace_back();
    }
  }
  if (!problems.empty()) throw InputError(problems);
  return shapes_;
}

// The root adds all stones: the first rebuild distributes them.
void Placement::place(dem::Particles& particles) {
  const auto& stones = model_.placed.stones;
  const std::vector<bed::PlacedShape>& shapes = make_shapes();
  std::vector<int> numbers(stones.size(), -1);
  for (std::size_t i = 0; i < stones.size(); ++i) {
    const std::size_t first = first_alike(stones, i);
    numbers[i] = first < i ? numbers[first] : particles.add_template(shapes[i].shape);
    axes_[i] = shapes[i].axes;
  }
  std::vector<dem::NewParticle> mine;
  for (std::size_t i = 0; comm_.root() && i < stones.size(); ++i) {
    const bed::StoneParameters& stone = stones[i];
    mine.push_back({.id = static_cast<Id>(i),
                    .shape = numbers[i],
                    .material = model_.material(stone.material),
                    .scale = shapes[i].scale,
                    .position = bed::vector_of(stone.position),
                    .attitude = bed::turn_of(stone.axis, stone.angle) * shapes[i].axes,
                    .velocity = bed::vector_of(stone.velocity),
                    .spin = bed::vector_of(stone.spin),
                    .held = stone.motion != bed::MotionKind::free});
  }
  particles.add(mine);
}

// Each stone is on one rank, all others add zeros: the sum is exact. In the order of the deck;
// parts that broke off follow.
std::vector<dem::ParticleView> Placement::stones_of(const dem::Particles& particles) const {
  Id last = static_cast<Id>(axes_.size()) - 1;
  for (std::size_t i = 0; i < particles.size(); ++i) last = std::max(last, particles[i].id);
  const auto count = static_cast<std::size_t>(comm_.max(last) + 1);
  std::vector<double> rows(columns * count, 0);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const dem::ParticleView p = particles[i];
    const std::array<double, columns> row = packed(p);
    std::copy(row.begin(), row.end(), rows.begin() + static_cast<std::ptrdiff_t>(columns) * p.id);
  }
  if (comm_.size() > 1) comm_.sum(std::span<double>(rows));
  std::vector<dem::ParticleView> stones;
  for (std::size_t i = 0; i < count; ++i)
    stones.push_back(unpacked(static_cast<Id>(i), rows.data() + columns * i));
  return stones;
}

// A driven surface supplies -F v, F the force of stones on it. The drive of a stone balances its
// contact forces F, its torques T and its weight: (m g - F) v - T w.
double Placement::power(const std::vector<dem::ParticleView>& stones,
                        std::span<const Vec3> on_surfaces) const {
  const Vec3 up(0, 0, model_.dem.gravity);
  double sum = 0;
  for (std::size_t k = 0; k < on_surfaces.size(); ++k)
    sum -= on_surfaces[k].dot(surfaces_.velocity(k));
  for (const dem::ParticleView& p : stones)
    if (p.held) sum += (p.mass * up - p.force).dot(p.velocity) - p.torque.dot(p.spin);
  return sum;
}

double Placement::energy(const dem::Particles& particles) const {
  const dem::Totals totals = particles.totals();
  return totals.kinetic + totals.potential + totals.elastic;
}

void Placement::begin(const dem::Particles& particles, std::span<const Vec3> on_surfaces) {
  const std::vector<dem::ParticleView> stones = stones_of(particles);
  for (std::size_t i = 0; i < axes_.size(); ++i) on_stones_[i].add(stones[i].force, 0);
  for (std::size_t k = 0; k < on_surfaces.size(); ++k) on_surfaces_[k].add(on_surfaces[k], 0);
  energy_at_begin_ = energy(particles);
  power_ = power(stones, on_surfaces);
}

void Placement::watch(const dem::Particles& particles, std::span<const Vec3> on_surfaces,
                      double dt) {
  const std::vector<dem::ParticleView> stones = stones_of(particles);
  for (std::size_t i = 0; i < axes_.size(); ++i) on_stones_[i].add(stones[i].force, dt);
  for (std::size_t k = 0; k < on_surfaces.size(); ++k) on_surfaces_[k].add(on_surfaces[k], dt);
  const double now = power(stones, on_surfaces);
  supplied_ += dt / 2 * (power_ + now);
  power_ = now;
}

observe::PlacedInstant Placement::instant(const dem::Particles& particles, double time) const {
  observe::PlacedInstant instant;
  const std::vector<dem::ParticleView> stones = stones_of(particles);
  std::vector<std::int64_t> contacts(stones.size() + 1, 0);  // of each stone, then all
  particles.contacts([&](const dem::ContactView& contact) {
    ++contacts[static_cast<std::size_t>(contact.first)];
    if (contact.second >= 0) ++contacts[static_cast<std::size_t>(contact.second)];
    ++contacts.back();
  });
  comm_.sum(std::span<std::int64_t>(contacts));
  for (std::size_t i = 0; i < stones.size(); ++i) {
    const dem::ParticleView& p = stones[i];
    const Vec3 momentum = p.mass * p.velocity;
    instant.translational += 0.5 * momentum.dot(p.velocity);
    instant.rotational += 0.5 * p.angular_momentum.dot(p.spin);
    instant.momentum += momentum;
    instant.angular_momentum += p.angular_momentum + p.position.cross(momentum);
    if (i >= axes_.size()) continue;  // a part without a name
    instant.stones.push_back({.name = model_.placed.stones[i].name,
                              .position = p.position,
                              .velocity = p.velocity,
                              .spin = p.spin,
                              .attitude = p.attitude * axes_[i].conjugate(),
                              .momentum = momentum,
                              .angular_momentum = p.angular_momentum,
                              .force = p.force,
                              .torque = p.torque,
                              .impulse = on_stones_[i].impulse,
                              .peak_force = on_stones_[i].peak,
                              .contacts = contacts[i]});
  }
  for (std::size_t k = 0; k < on_surfaces_.size(); ++k)
    instant.surfaces.push_back({.name = surfaces_.surfaces()[k].name,
                                .force = on_surfaces_[k].force,
                                .displacement = time * surfaces_.velocity(k),
                                .impulse = on_surfaces_[k].impulse,
                                .peak_force = on_surfaces_[k].peak});
  instant.contacts = contacts.back();
  instant.supplied = supplied_;
  instant.dissipated = energy_at_begin_ + supplied_ - energy(particles);
  return instant;
}

void Placement::archive(io::Archive& a) {
  const auto contacts = [&](const std::string& group, std::vector<ContactImpulse>& all) {
    io::Archive of = a.group(group);
    of.rows("impulse", all, {"N s", "of all contacts up to now"}, &ContactImpulse::impulse);
    of.rows("peak_force", all, {"N", "largest up to now"}, &ContactImpulse::peak);
    of.rows("force", all, {"N", "at the end of the last window"}, &ContactImpulse::force);
  };
  contacts("stones", on_stones_);
  contacts("surfaces", on_surfaces_);
  a.rows("axes", axes_,
         {"-",
          "of each stone: quaternion x y z w from principal axes to the axes of its description"});
  a("energy_at_start", energy_at_begin_, {"J", "of the stones"});
  a("supplied", supplied_, {"J", "work of driven bodies up to now"});
  a("power", power_, {"W", "of driven bodies at the end of the last window"});
}

}  // namespace trackbed::model
