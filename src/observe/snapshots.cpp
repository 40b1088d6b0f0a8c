// The contact network and the stones at one instant, as tables for plots.
// Every rank writes its own stones and contacts, so the order of rows depends on the ranks.
#include "observe/impl.hpp"
#include "observe/layout.hpp"

namespace trackbed::observe {

namespace {

// Plots are in the plane of the track, x and z, also for a bed in space.
struct Network {
  std::vector<double> segments, force;  // x0 z0 x1 z1 of the two centres; |F|
};

// N and m, on this rank. A contact between two ranks is included on one of them only.
Network network_of(const dem::Particles& particles) {
  Network network;
  particles.contacts([&](const dem::ContactView& contact) {
    network.segments.insert(network.segments.end(),
                            {contact.from.x(), contact.from.z(), contact.to.x(), contact.to.z()});
    network.force.push_back(contact.force.norm());
  });
  return network;
}

// Bonds of this rank, whole ones and broken ones.
struct Bonds {
  std::vector<double> whole, broken;
};

Bonds bonds_of(const dem::Particles& particles) {
  Bonds bonds;
  particles.bonds([&](const dem::BondView& b) {
    bonds.whole.insert(
        bonds.whole.end(),
        {static_cast<double>(b.first), static_cast<double>(b.second), static_cast<double>(b.kind),
         b.point.x(), b.point.y(), b.point.z(), b.force.norm(), b.utilisation, b.damage});
  });
  for (const dem::BondBreak& b : particles.bond_breaks())
    bonds.broken.insert(bonds.broken.end(),
                        {b.time, static_cast<double>(b.first), static_cast<double>(b.second),
                         static_cast<double>(b.kind), b.by_shear ? 1.0 : 0.0, b.position.x(),
                         b.position.y(), b.position.z(), b.normal, b.shear, b.energy});
  return bonds;
}

// Pebbles, m, since plots show disks; for polyhedra the bounding spheres of their pieces.
struct Stones {
  std::vector<double> centre, radius;
};

Stones stones_of(const dem::Particles& particles) {
  Stones stones;
  for (std::size_t i = 0; i < particles.size(); ++i)
    particles.pieces(i, [&](const Vec3& centre, double radius) {
      stones.centre.insert(stones.centre.end(), {centre.x(), centre.z()});
      stones.radius.push_back(radius);
    });
  return stones;
}

}  // namespace

// Collective.
void Results::snapshot(const std::string& stage, const Scene& scene, double cell) {
  const Network network = network_of(scene.particles);
  const Stones stones = stones_of(scene.particles);
  std::vector<double> sieved;
  for (std::size_t i = 0; i < scene.particles.size(); ++i) {
    const dem::ParticleView stone = scene.particles[i];
    sieved.insert(sieved.end(), {stone.size, stone.mass});
  }
  std::vector<double> breaks;
  for (const dem::Break& each : scene.particles.breaks())
    breaks.insert(
        breaks.end(),
        {each.time, static_cast<double>(each.stone), static_cast<double>(each.fragment),
         each.position.x(), each.position.y(), each.position.z(), each.diameter, each.mass,
         each.force, each.released, each.lost, each.stress, static_cast<double>(each.kind)});
  const Bonds bonds = bonds_of(scene.particles);
  // The same on all ranks; rank 0 writes it.
  const std::vector<double> surface =
      cell > 0 ? surface_of(impl_->comm, scene.particles, cell) : std::vector<double>{};
  const std::span<const double> own(surface.data(), impl_->comm.root() ? surface.size() : 0);
  impl_->replace([&](io::File& file) {
    // One group per stage: names of stages are unique.
    const std::string chains = "chains/" + stage, pebbles = "stones/" + stage;
    file.write<double>(chains + "/segments", network.segments, 4,
                       {"m", "x and z of the centres of the two pieces of each contact"});
    file.write<double>(chains + "/force", network.force, 1,
                       {"N", "magnitude of each contact force"});
    file.write<double>(pebbles + "/centre", stones.centre, 2, {"m", "x and z of each pebble"});
    file.write<double>(pebbles + "/sieved", sieved, 2,
                       {"m, kg", "of each stone: smallest opening that it passes, and mass"});
    if (scene.breaks)
      file.write<double>(
          "breaks/" + stage, breaks, 13,
          {"s, -, -, m, m, m, m, kg, N, J, J, Pa, -",
           "parts that broke off up to the end of the stage: time, stone, fragment "
           "(-1: fines), x, y, z, diameter, mass, force, elastic energy of its contacts, "
           "kinetic energy lost, stress, kind (0: pebble of a clump, 1: corner of a "
           "polyhedron, 2: part of a split stone, 3: dust of a worn stone)"});
    if (scene.bonds) {
      file.write<double>("bonds/" + stage + "/whole", bonds.whole, 9,
                         {"-, -, -, m, m, m, N, -, -",
                          "bonds: both stones, number of the [[bond]], x, y, z, force, "
                          "utilisation (stress over strength), damage"});
      file.write<double>("bonds/" + stage + "/broken", bonds.broken, 11,
                         {"s, -, -, -, -, m, m, m, Pa, Pa, J",
                          "bonds that broke up to the end of the stage: time, both stones, number "
                          "of the [[bond]], 1 by shear or 0 by tension, x, y, z, tensile and shear "
                          "stress, elastic energy that damage took"});
    }
    if (cell > 0)
      file.write<double>("surface/" + stage + "/top", own, 3,
                         {"m", "x, y of each cell, and z of the highest stone in the cell"});
    file.write<double>(pebbles + "/radius", stones.radius, 1, {"m", "of each pebble"});
    set_axes_of_snapshot(impl_->comm, file, stage);
    if (!impl_->times.empty()) impl_->append_to(file);  // saves a flush
  });
}

}  // namespace trackbed::observe
