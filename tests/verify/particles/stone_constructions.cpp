// Study: comparison of contact models of rounded polyhedra. Prints the table of
// docs/decisions/stone-contact.md: relative energy error of elastic collisions, smoothness, cost.
//   stone_constructions [collisions]      (default 300; about a minute)
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "constructions.hpp"

namespace trackbed::study {
namespace {

constexpr double density = 2600, k = 1e7, size = 0.04;  // kg/m^3, N/m, m

Vec3 draw(std::uint64_t seed, std::uint64_t key) {
  return Vec3(uniform(seed, key), uniform(seed + 1, key), uniform(seed + 2, key)) -
         Vec3::Constant(0.5);
}

struct Pair {
  Body i, j;
};

Pair placed(const dem::Template& a, const dem::NewParticle& pa, const dem::Template& b,
            dem::NewParticle pb, const Vec3& direction) {
  test::bring_near(a, pa, b, pb, 1e-6, direction);
  return {Body(a, pa, density), Body(b, pb, density)};
}

Pair random_stones(std::uint64_t key) {
  const dem::Template a = test::stone(key % 40), b = test::stone(100 + key % 37);
  dem::NewParticle pa, pb;
  pa.scale = pb.scale = size;
  const auto turn = [&](std::uint64_t seed) {
    const Vec3 v = draw(seed, key);
    return Quat(uniform(seed + 3, key) - 0.5, v.x(), v.y(), v.z()).normalized();
  };
  pa.attitude = turn(1), pb.attitude = turn(5);
  const Vec3 along = draw(10, key).normalized();
  pb.position = 0.1 * along;
  pb.velocity = -along + 0.8 * draw(13, key);
  pa.spin = 60 * draw(16, key), pb.spin = 60 * draw(19, key);
  return placed(a, pa, b, pb, -along);
}

Pair faces(std::uint64_t key) {
  static const dem::Template box = test::cuboid({0.5, 0.45, 0.4});
  dem::NewParticle pa, pb;
  pa.scale = pb.scale = size;
  const Vec3 v = draw(1, key), tilt = 1e-3 * draw(4, key);
  pb.position = Vec3(0.02 * v.x(), 0.02 * v.y(), 0.06);
  pb.velocity = Vec3(0.1 * draw(7, key).x(), 0.1 * draw(7, key).y(), -1);
  pb.attitude = Quat(1, tilt.x(), tilt.y(), uniform(9, key)).normalized();
  return placed(box, pa, box, pb, -Vec3::UnitZ());
}

// Relative energy error of one collision; negative: no collision.
double energy_error(Pair pair, const Construction& respond, double fraction) {
  const double dt = fraction * std::sqrt(std::min(pair.i.mass, pair.j.mass) / k);
  const double before = pair.i.kinetic() + pair.j.kinetic();
  Memory memory;
  bool collided = false;
  Response r;
  for (int apart = 0; apart < (collided ? 100 : 3000);) {
    for (const bool second : {false, true}) {
      pair.i.kick(r.force, r.turn_i, 0.5 * dt), pair.j.kick(-r.force, r.turn_j, 0.5 * dt);
      if (second) break;
      pair.i.drift(dt), pair.j.drift(dt);
      const Vec3 gap = pair.j.x - pair.i.x;
      if (gap.norm() > 2 * size)
        return collided ? std::abs((pair.i.kinetic() + pair.j.kinetic()) / before - 1) : -1;
      r = respond(pair.i, pair.j, k, memory);
    }
    const bool touching = !r.force.isZero();
    collided |= touching;
    apart = touching ? 0 : apart + 1;
  }
  return collided ? std::abs((pair.i.kinetic() + pair.j.kinetic()) / before - 1) : -1;
}

// Largest change of force, and of torque over the size, between poses along a sideways path of one
// rounding radius.
double largest_jump(Pair pair, const Construction& respond, int count) {
  const Vec3 along = (pair.j.x - pair.i.x).normalized(), side = along.unitOrthogonal();
  constexpr double radius = test::rounding * size;
  const Vec3 from = pair.j.x - 0.1 * radius * along;
  const Quat q = pair.j.q;
  Memory memory;
  double jump = 0;
  Response last;
  for (int s = 0; s <= count; ++s) {
    const double t = static_cast<double>(s) / count;
    pair.j.x = from + radius * t * side;
    pair.j.q = Quat(Eigen::AngleAxisd(0.1 * t, side)) * q;
    pair.j.place();
    const Response r = respond(pair.i, pair.j, k, memory);
    if (s > 0)
      jump =
          std::max({jump, (r.force - last.force).norm(), (r.turn_i - last.turn_i).norm() / size});
    last = r;
  }
  return jump;
}

double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Errors {
  double median, largest;
};

Errors errors_of(Pair (*make)(std::uint64_t), int count, const Construction& c, double fraction) {
  std::vector<double> all;
  for (int n = 0; n < count; ++n) {
    const double error = energy_error(make(static_cast<std::uint64_t>(n)), c, fraction);
    if (error >= 0) all.push_back(error);
  }
  if (all.empty()) return {-1, -1};  // no collision
  std::sort(all.begin(), all.end());
  return {all[all.size() / 2], all.back()};
}

void accuracy(int collisions) {
  printf("relative energy error, median / largest; dt over sqrt(m/k)\n");
  printf("| %-24s | stones, 0.1 | stones, 0.025 | faces, 0.1 | faces, 0.025 | jumps |\n", "");
  for (const NamedConstruction& c : constructions()) {
    printf("| %-24s ", c.name);
    for (auto* make : {&random_stones, &faces})
      for (const double fraction : {0.1, 0.025}) {
        const Errors e =
            errors_of(*make, collisions / (make == &faces ? 3 : 1), c.respond, fraction);
        printf("| %.0e / %.0e ", e.median, e.largest);
      }
    int jumps = 0;
    for (std::uint64_t n = 0; n < 60; ++n) {
      const Pair pair = n % 2 ? random_stones(n) : faces(n);
      const double coarse = largest_jump(pair, c.respond, 100);
      jumps += largest_jump(pair, c.respond, 800) > 0.5 * coarse && coarse > 0;
    }
    printf("| %d of 60 |\n", jumps);
    fflush(stdout);
  }
}

// Least CPU time of one call in ns per pair, since other processes may be running.
template <class Work>
double nanoseconds(std::size_t pairs, Work&& work) {
  double best = 1e300;
  for (int turn = 0; turn < 15; ++turn) {
    const double begin = cpu_seconds();
    work();
    best = std::min(best, cpu_seconds() - begin);
  }
  return best / static_cast<double>(pairs) * 1e9;
}

// Cost of a sub-step of the program with these pairs, which are far from each other; the bodies of
// a pair are displaced apart by `apart`, m.
double substep(const std::vector<Pair>& pairs, const std::vector<dem::Template>& shapes,
               double apart) {
  constexpr int steps = 20;
  constexpr double spacing = 0.2;  // m
  dem::ContactLaw law;
  law.k_n = law.k_s = k;
  dem::Parameters parameters;
  parameters.gravity = 0, parameters.largest_overlap = 1e3, parameters.skin = 0.005;
  dem::Particles p(par::Comm::self(), test::one_material(law, density), parameters,
                   test::box(Vec3::Constant(-1), Vec3(spacing * pairs.size() + 1, 1, 1)));
  for (const dem::Template& shape : shapes) p.add_template(shape);
  std::vector<dem::NewParticle> all;
  for (std::size_t n = 0; n < pairs.size(); ++n)
    for (const Body* b : {&pairs[n].i, &pairs[n].j}) {
      dem::NewParticle one;
      one.id = static_cast<Id>(all.size());
      one.shape = static_cast<int>(all.size());
      one.scale = size;
      one.position = b->x + Vec3(spacing * static_cast<double>(n), 0, 0);
      if (b == &pairs[n].j) one.position += apart * (pairs[n].j.x - pairs[n].i.x).normalized();
      one.attitude = b->q;
      all.push_back(one);
    }
  p.add(all);
  p.advance(1e-12, steps);
  const std::int64_t touching = p.totals().contacts,
                     wanted = apart > 0 ? 0 : static_cast<std::int64_t>(pairs.size());
  if (touching != wanted)
    printf("(%lld pairs touch, not %lld)\n", static_cast<long long>(touching),
           static_cast<long long>(wanted));
  return nanoseconds(pairs.size() * steps, [&] { p.advance(1e-12, steps); });
}

void cost_of(const char* name, Pair (*make)(std::uint64_t), bool box) {
  constexpr std::size_t count = 200;
  std::vector<Pair> pairs;
  std::vector<dem::Template> shapes;
  for (std::uint64_t n = 0; n < count; ++n) {
    pairs.push_back(make(n));
    pairs.back().j.x -= 4e-5 * (pairs.back().j.x - pairs.back().i.x).normalized();
    shapes.push_back(box ? test::cuboid({0.5, 0.45, 0.4}) : test::stone(n % 40));
    shapes.push_back(box ? shapes.back() : test::stone(100 + n % 37));
  }
  const double touching = substep(pairs, shapes, 0), apart = substep(pairs, shapes, 2e-3);
  std::vector<Memory> memory(count);
  std::vector<Feature> found;
  double sum = 0;  // prevents removal by the optimiser
  const double clipped = nanoseconds(count, [&] {
    for (std::size_t n = 0; n < count; ++n) {
      clipped_manifold(pairs[n].i, pairs[n].j, memory[n], found);
      sum += found.empty() ? 0 : found[0].delta;
    }
  });
  const double closest = nanoseconds(count, [&] {
    for (std::size_t n = 0; n < count; ++n) {
      const dem::Placed i = pairs[n].i.placed(pairs[n].i.x), j = pairs[n].j.placed(pairs[n].i.x);
      const dem::Slab slab = dem::widest_slab(i, j, memory[n].normal, 1e-9 * size);
      memory[n].normal = slab.normal, sum += slab.width;
    }
  });
  printf("| %-7s | %6.0f | %6.0f | %6.0f | %6.0f |\n", name, touching - apart, touching, clipped,
         closest);
  if (sum == 0) printf("\n");
}

void cost() {
  printf(
      "cost in ns per touching pair and sub-step, best of 15 (CPU time)\n"
      "| pairs   | smooth maximum: contact | whole sub-step | clipped manifold | closest point "
      "(distance only) |\n");
  cost_of("stones", &random_stones, false);
  cost_of("faces", &faces, true);
}

}  // namespace

void run(int collisions) {
  accuracy(collisions);
  cost();
}

}  // namespace trackbed::study

int main(int argc, char** argv) {
  trackbed::par::Environment environment(argc, argv);
  trackbed::study::run(argc > 1 ? std::atoi(argv[1]) : 300);
}
