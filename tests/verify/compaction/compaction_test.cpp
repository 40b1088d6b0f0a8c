// A short bed of pebbles is filled, falls under gravity, and is compacted by the platen to 200 kPa
// through the coupler: pressure and porosity reach their targets, balances are closed, and results
// do not depend on the number of ranks.
#include <gtest/gtest.h>

#include "support/verified.hpp"
#include "trackbed/bed/bed.hpp"
#include "trackbed/couple/coupler.hpp"

namespace trackbed::compaction_test {
namespace {

// Stone on stone as in a main-line ballast model: k = 5e8 N/m, friction 0.7, damping 0.25.
dem::Physics physics() {
  dem::Physics p;
  p.materials.push_back({.name = "wall"});
  p.materials.push_back({.name = "ballast"});
  for (const char* other : {"wall", "ballast"}) {
    dem::ContactLaw law;
    law.first = "ballast", law.second = other;
    law.k_n = law.k_s = 5e8;
    law.friction = 0.7;
    law.zeta_n = law.zeta_s = 0.25;
    p.laws.push_back(law);
  }
  return p;
}

dem::Domain domain() {
  dem::Domain d;
  d.dimension = Dimension::plane;
  d.thickness = 1.3;
  d.low = {0, -0.65, -0.2};
  d.high = {0.6, 0.65, 3};
  return d;
}

class Compaction {
 public:
  explicit Compaction(const par::Comm& comm, const bed::PlatenParameters& platen = {},
                      std::int64_t seed = 1)
      : particles_(comm, physics(), {}, domain()), coupler_(comm), platen_(platen, domain(), 0) {
    parameters_.x = {0, 0.6};
    parameters_.height = 0.2;
    parameters_.porosity = 0.27;
    parameters_.seed = seed;
    walls_ = bed::walls(domain(), bed::fill(particles_, comm, parameters_, 1), 0, true);
    particles_.set_local_damping(0.3);
    set_surfaces(false);
    dt_ = particles_.stable_step();
    for (double t = 0; t < 0.35; t += substeps * dt_) window();
    double top = 0;
    for (std::size_t i = 0; i < particles_.size(); ++i)
      particles_.pieces(i, [&](const Vec3& x, double r) { top = std::max(top, x.z() + r); });
    platen_.place(comm.max(top) + 1e-3);
    set_surfaces(true);
  }
  // Until the servo is steady, for one second at most.
  void compress() { compress(1, true); }
  void compress(double longest, bool until_steady) {
    double sum = 0, since = 0;
    for (double t = 0; t < longest && !(until_steady && platen_.steady()); t += substeps * dt_) {
      double force = 0;
      for (const Vec3& node : coupler_.mean_force(number_)) force += node.z();
      platen_.advance(substeps * dt_, force);
      window();
      if (t > longest / 2) sum += force, since += 1;
      peak_ = std::max(peak_, platen_.pressure());
    }
    late_ = since > 0 ? sum / since / (0.6 * 1.3) : 0;
  }
  // Continues with another servo, with the plate at its present position.
  void drive(const bed::PlatenParameters& platen) {
    const double z = platen_.z();
    platen_ = bed::Platen(platen, domain(), 0);
    platen_.place(z);
    set_surfaces(true);
  }
  double porosity() const {
    return 1 - parameters_.height * (1 - parameters_.porosity) / platen_.z();
  }
  const bed::Platen& platen() const { return platen_; }
  const couple::Balance& balance() const { return coupler_.balance(); }
  double peak() const { return peak_; }
  double late() const { return late_; }  // Pa, mean over the second half of the time
  dem::Particles& particles() { return particles_; }

 private:
  static constexpr int substeps = 20;
  void set_surfaces(bool platen) {
    std::vector<Surface*> surfaces;
    for (Surface& wall : walls_) surfaces.push_back(&wall);
    if (platen) surfaces.push_back(&platen_.surface());
    particles_.set_surfaces(surfaces);
    coupler_.clear();
    for (Surface* surface : surfaces) number_ = coupler_.add(*surface);
    coupler_.connect(
        [&](const Vec3& low, const Vec3& high) { return particles_.reaches(low, high); });
  }
  void window() {
    coupler_.publish();
    particles_.advance(substeps * dt_, substeps);
    const dem::SurfaceAction& did = particles_.surface_action();
    coupler_.collect(substeps, substeps * dt_, {did.force, did.moment, did.work});
  }

  bed::BedParameters parameters_;
  dem::Particles particles_;
  couple::Coupler coupler_;
  std::vector<Surface> walls_;
  bed::Platen platen_;
  std::size_t number_ = 0;
  double dt_ = 0, peak_ = 0, late_ = 0;
};

TEST(CompactionOfABed, ReachesThePressureOnAnyNumberOfRanks) {
  const par::Comm world = par::Comm::world();
  Compaction shared(world);
  shared.compress();
  EXPECT_EQ(world.sum(std::int64_t{shared.particles().trouble().empty() ? 0 : 1}), 0);
  constexpr double target = 200e3;  // Pa
  EXPECT_TRUE(shared.platen().steady());
  verified::near("pressure of the platen", "Pa", shared.platen().pressure(), target,
                 {0.02 * target, "tolerance of the servo"});
  verified::below("largest pressure during compaction", "Pa", shared.peak(),
                  {1.1 * target, "separates: the servo does not overshoot"});
  const verified::Limit closed{
      1e-10, "rounding of loads to quanta, 1e-18 of the largest one; a lost load gives 1"};
  verified::below("imbalance of force", "-", shared.balance().force, closed);
  verified::below("imbalance of moment", "-", shared.balance().moment, closed);
  verified::below("imbalance of work", "-", shared.balance().work, closed);
  verified::below("imbalance of impulse", "-", shared.balance().impulse, closed);
  if (world.size() == 1) return;
  Compaction alone(par::Comm::self());
  alone.compress();
  EXPECT_EQ(shared.platen().z(), alone.platen().z());
  EXPECT_EQ(shared.particles().state_hash(), alone.particles().state_hash());
}

// The packing of forty stones is random: the mean over several beds is tested. On one rank, since
// results do not depend on the number of ranks.
constexpr std::int64_t beds = 8;

// A long bed has a porosity of 0.27 with friction 0.7; below a flat plate the voids between the
// highest stones are included, half a stone of 50 mm on 0.2 m: 1 - 0.73 * 0.2 / 0.225.
TEST(CompactionOfABed, HasThePorosityOfFrictionAndAFlatPlate) {
  if (par::Comm::world().size() > 1) return;
  double mean = 0;
  for (std::int64_t seed = 1; seed <= beds; ++seed) {
    Compaction bed(par::Comm::self(), {}, seed);
    bed.compress();
    EXPECT_TRUE(bed.platen().steady()) << "seed " << seed;
    mean += bed.porosity() / beds;
  }
  verified::near("porosity", "-", mean, 0.351,
                 {0.068, "scatter of beds, 0.064: three times that of the mean of eight"});
}

// With a tenth of the pressure the static load of the plate moves few stones; vibration moves more.
// Each bed is compacted until it is steady before the vibration, and compared with its own height.
TEST(CompactionOfABed, SettlesMoreUnderAVibratingPlate) {
  if (par::Comm::world().size() > 1) return;
  bed::PlatenParameters still;
  still.pressure = 20e3;
  still.average = 0.1;
  bed::PlatenParameters vibrating = still;
  vibrating.vibration = 5e-4;
  double settlement = 0, pressure = 0;
  for (std::int64_t seed = 1; seed <= beds; ++seed) {
    Compaction bed(par::Comm::self(), still, seed);
    bed.compress();
    const double steady = bed.platen().z();
    bed.drive(vibrating);
    bed.compress(1, false);
    EXPECT_TRUE(bed.particles().trouble().empty());
    settlement += (steady - bed.platen().z()) / beds, pressure += bed.late() / beds;
  }
  // Single beds settle by -2 to 50 mm, five of eight by more than 10 mm.
  verified::above("mean settlement", "m", settlement,
                  {2 * vibrating.vibration, "separates from the plate's travel in a period"});
  // The servo is slower than the impacts, and the bed settles below it.
  verified::near(
      "mean pressure", "Pa", pressure, still.pressure,
      {0.25 * still.pressure, "scatter of beds, 23 %: three times that of the mean of eight"});
}

}  // namespace
}  // namespace trackbed::compaction_test
