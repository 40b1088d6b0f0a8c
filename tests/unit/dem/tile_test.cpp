// Copies of a periodic cell side by side: each has the forces of the cell and moves as the cell
// did.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "support/stones.hpp"

namespace trackbed::tile_test {
namespace {

constexpr double dt = 2e-5;      // s
constexpr double length = 0.18;  // m, of the cell
constexpr double k_n = 5e5;      // N/m
constexpr std::int64_t copies = 3;
// Rounding error of a position along three cells, m, which a contact converts to an error of force.
constexpr double place = 2.2e-16 * copies * length;

dem::ContactLaw rough() {
  dem::ContactLaw law;
  law.k_n = k_n, law.k_s = 4e5;
  law.friction = 0.5;
  law.zeta_n = law.zeta_s = 0.3;
  law.rolling_friction = 0.1, law.zeta_r = 0.5;
  return law;
}

enum class Ends { periodic, open };

// Stones on a floor between walls at the sides, periodic along x.
struct Bed {
  Surface floor = test::floor_of(3, 2);
  dem::Particles particles;

  Bed(const par::Comm& comm, double begin, double end, Ends ends = Ends::periodic)
      : particles(comm, test::one_material(rough()), {.largest_overlap = 1},
                  domain(begin, end, ends)) {}
  static dem::Domain domain(double begin, double end, Ends ends) {
    dem::Domain d = test::box({begin, -0.09, -0.05}, {end, 0.09, 0.5});
    d.periodic = {ends == Ends::periodic, true, false};
    return d;
  }
  // With a velocity along x, so that many leave the cell through its end and have unwrapped
  // positions beyond it.
  void pour(const par::Comm& comm, double begin) {
    particles.add_template(test::irregular(0.016, 0.0015, 1));
    particles.add_template(test::brick({0.015, 0.012, 0.009}, 0.0015));
    auto all = test::lattice({4, 4, 4}, 0.045, 1, 2);
    for (auto& p : all) {
      p.id = 3 * p.id + 5;                         // with gaps, as after the removal of stones
      p.position += Vec3(begin + 0.03, -0.09, 0);  // a place with contacts across the border
      p.velocity.x() += 0.7;
    }
    particles.add(test::mine(comm, all));
    connect();
  }
  void connect() { particles.set_surfaces({&floor}); }
  void run(int steps) {
    particles.advance(steps * dt, steps);
    EXPECT_EQ(particles.trouble(), "");
  }
};

struct Seen {
  double x;
  Vec3 rest, force, torque;  // rest: y, z and 0
};
std::map<Id, Seen> look(const dem::Particles& particles) {
  std::map<Id, Seen> all;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const dem::ParticleView p = particles[i];
    all[p.id] = {p.position.x(), {p.position.y(), p.position.z(), 0}, p.force, p.torque};
  }
  return all;
}

// The cell after motion has ceased to such a degree that friction holds it; its file.
class Tiling : public testing::Test {
 protected:
  static constexpr double begin = -0.07;  // m, of the cell
  // Of force: brings the stones so close to rest that rounding errors do not grow by sliding.
  static constexpr double damping = 0.7;
  par::Comm world = par::Comm::world(), self = par::Comm::self();
  Bed cell{self, begin, begin + length};

  static std::string path() {
    const par::Comm world = par::Comm::world();
    return "tile_" + std::to_string(world.size()) + "_" + std::to_string(world.rank()) + ".h5";
  }
  // Once for all tests. Every rank makes the same cell in a file of its own.
  static void SetUpTestSuite() {
    const par::Comm self = par::Comm::self();
    Bed bed(self, begin, begin + length);
    bed.pour(self, begin);
    bed.run(12000);
    bed.particles.set_local_damping(damping);
    bed.run(24000);  // after 16000 a bed of another build, with 2 contacts across, still slid
    io::File file(self, path(), io::Mode::create);
    bed.particles.save(file, "/dem");
  }
  static void TearDownTestSuite() { std::filesystem::remove(path()); }

  void SetUp() override {
    cell.particles.load(io::File(self, path(), io::Mode::read), "/dem");
    cell.connect();
  }

  void lay(const par::Comm& comm, Bed& bed, const std::map<std::string, std::string>& names = {}) {
    // All ranks of a communicator open one file: that of rank 0, which exists as long as the others
    // use it.
    const std::string name = comm.broadcast(comm.root() ? path() : "");
    const dem::Tiling tiling{copies, begin, length, {0}, names};
    bed.particles.tile(io::File(comm, name, io::Mode::read), "/dem", tiling);
    bed.particles.set_local_damping(damping);
    bed.connect();
    comm.barrier();
  }
};

TEST_F(Tiling, EveryCopyHasTheForcesAndMotionOfTheCell) {
  Bed bed(world, 1, 1 + copies * length);
  lay(world, bed);
  const std::map<Id, Seen> before = look(cell.particles);
  double force = 0;  // N, the largest
  for (const auto& [id, seen] : before) force = std::max(force, seen.force.norm());
  // Right after copying a contact has the errors of a few features' positions. Later they grow,
  // wherever a stone still slides or rolls: to 4e-10 m in 200 steps. Without histories forces are
  // wrong by up to 0.16 N at once.
  for (const auto& [steps, allowed] : {std::pair{1, 50.0}, std::pair{200, 1e7}}) {
    cell.run(steps), bed.run(steps);
    const std::map<Id, Seen> one = look(cell.particles);
    std::vector<Seen> in_order;
    for (const auto& [id, seen] : one) in_order.push_back(seen);
    for (const auto& [id, seen] : look(bed.particles)) {
      const Seen& of_cell = in_order[static_cast<std::size_t>(id) % in_order.size()];
      const double periods = (seen.x - 1 - (of_cell.x - begin)) / length;
      EXPECT_NEAR(periods, std::round(periods), allowed * place / length);
      EXPECT_LE((seen.rest - of_cell.rest).norm(), allowed * place);
      EXPECT_LE((seen.force - of_cell.force).norm(), allowed * place * k_n);
      EXPECT_LE((seen.torque - of_cell.torque).norm(), allowed * place * k_n * 0.03);
    }
    const dem::Totals many = bed.particles.totals(), few = cell.particles.totals();
    EXPECT_EQ(many.particles, copies * few.particles);
    EXPECT_EQ(many.contacts, copies * few.contacts);
    EXPECT_NEAR(many.elastic / (copies * few.elastic), 1, steps == 1 ? 1e-9 : 1e-6);
  }
  // The tolerance is meaningful: forces are many orders of magnitude above it.
  EXPECT_GT(force, 1e6 * 50 * place * k_n);
}

// Preconditions of the test: contacts across the cell's border, stones that have left it.
TEST_F(Tiling, TheCellHasContactsAcrossItsBorder) {
  cell.run(1);  // contacts are known once there are lists
  int across = 0, outside = 0;
  const std::map<Id, Seen> all = look(cell.particles);
  cell.particles.contacts([&](const dem::ContactView& c) {
    if (c.second < 0) return;
    const auto in_cell = [&](Id id) {
      const double along = (all.at(id).x - begin) / length;
      return along - std::floor(along);
    };
    across += std::abs(in_cell(c.first) - in_cell(c.second)) > 0.5;
  });
  for (const auto& [id, seen] : all) outside += seen.x > begin + length;
  EXPECT_GE(across, 2);
  EXPECT_GT(outside, 5);
}

// The springs of the floor's friction are assigned to its name in this run.
TEST_F(Tiling, AFloorMayHaveAnotherName) {
  double elastic[2];
  cell.run(1);
  for (const bool known : {false, true}) {
    Bed bed(self, 1, 1 + copies * length);
    bed.floor.name = "ground";
    lay(self, bed, {{"floor", known ? "ground" : "other"}});
    bed.run(1);
    elastic[known] = bed.particles.totals().elastic / (copies * cell.particles.totals().elastic);
  }
  EXPECT_NEAR(elastic[true], 1, 1e-9);
  EXPECT_LT(elastic[false], 1 - 1e-6);
}

TEST_F(Tiling, OneCopyIsTheCell) {
  Bed bed(world, begin, begin + length);
  const std::string name = world.broadcast(world.root() ? path() : "");
  bed.particles.tile(io::File(world, name, io::Mode::read), "/dem", {1, begin, length, {0}, {}});
  bed.particles.set_local_damping(damping);
  bed.connect();
  world.barrier();
  cell.run(1), bed.run(1);
  EXPECT_EQ(bed.particles.totals().contacts, cell.particles.totals().contacts);
  EXPECT_NEAR(bed.particles.totals().elastic / cell.particles.totals().elastic, 1, 1e-9);
}

TEST_F(Tiling, IsBitwiseIdenticalOnAnyNumberOfRanks) {
  for (const Ends ends : {Ends::periodic, Ends::open}) {
    Bed together(world, 0, copies * length, ends), alone(self, 0, copies * length, ends);
    lay(world, together), lay(self, alone);
    for (Bed* bed : {&together, &alone}) bed->run(300);
    EXPECT_EQ(together.particles.state_hash(), alone.particles.state_hash());
  }
}

// A checkpoint before the first window contains the waiting histories.
TEST_F(Tiling, ARestartIsBitwiseIdentical) {
  Bed whole(self, 0, copies * length), resumed(self, 0, copies * length);
  lay(self, whole);
  const std::string kept = path() + ".kept";
  {
    io::File file(self, kept, io::Mode::create);
    whole.particles.save(file, "/dem");
  }
  resumed.particles.load(io::File(self, kept, io::Mode::read), "/dem");
  resumed.connect();
  for (Bed* bed : {&whole, &resumed}) bed->run(300);
  EXPECT_EQ(whole.particles.state_hash(), resumed.particles.state_hash());
  std::filesystem::remove(kept);
}

}  // namespace
}  // namespace trackbed::tile_test
