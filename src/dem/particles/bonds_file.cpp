// Bonds in a checkpoint.
#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <cstring>

#include "dem/particles/impl.hpp"
#include "dem/state/rendezvous.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::dem {

namespace {

constexpr int bond_break_columns = 11;
static_assert(sizeof(Bond) == (3 + bond_numbers) * 8);

// Between the members of a bond behind the whole numbers and as many numbers.
void get_numbers(const Bond& bond, double* to) {
  std::memcpy(to, reinterpret_cast<const std::byte*>(&bond) + offsetof(Bond, arm),
              bond_numbers * sizeof(double));
}
void set_numbers(Bond& bond, const double* from) {
  std::memcpy(reinterpret_cast<std::byte*>(&bond) + offsetof(Bond, arm), from,
              bond_numbers * sizeof(double));
}

}  // namespace

// The owner of the first stone writes a bond. Also before there are any: their time has begun.
void Particles::Impl::save_bonds(io::File& file, const std::string& group) const {
  if (bonding.parameters.empty() && !bonding.any) return;
  const std::string at = group + "/bonds";
  std::vector<std::int64_t> stones_of;
  std::vector<double> numbers, breaks;
  for (const Bond& bond : bonding.bonds) {
    if (!own_number(bond.first)) continue;
    stones_of.insert(stones_of.end(), {bond.first, bond.second, bond.kind});
    numbers.resize(numbers.size() + bond_numbers);
    get_numbers(bond, &numbers[numbers.size() - bond_numbers]);
  }
  for (const BondBreak& b : bonding.breaks)
    breaks.insert(breaks.end(),
                  {b.time, static_cast<double>(b.first), static_cast<double>(b.second),
                   static_cast<double>(b.kind), b.by_shear ? 1.0 : 0.0, b.position.x(),
                   b.position.y(), b.position.z(), b.normal, b.shear, b.energy});
  file.write<std::int64_t>(at + "/stones", stones_of, 3,
                           {"-", "ids of both stones, number of the [[bond]]"});
  file.write<double>(
      at + "/numbers", numbers, bond_numbers,
      {"m (6), - (8), m, m, m, -, J",
       "of each bond: its place from both centres of mass, in principal axes; quaternions x y z w "
       "from its axes to those of both stones; radius; length; length beyond the balls around "
       "both stones at which it breaks; largest stress over strength; elastic energy that damage "
       "has taken"});
  file.write<double>(
      at + "/breaks", breaks, bond_break_columns,
      {"s, -, -, -, -, m, m, m, Pa, Pa, J",
       "bonds that broke: time, both stones, number of the [[bond]], 1 by shear or 0 "
       "by tension, x, y, z, tensile and shear stress, elastic energy that damage took"});
  file.attribute(group, "bonds_begun", static_cast<std::int64_t>(bonding.any));
  file.attribute(group, "bonds_made", bonding.made);
  file.attribute(group, "bonds_longest", bonding.longest);
}

// Every rank reads a part of the bonds and receives those of the stones that it has read.
void Particles::Impl::load_bonds(const io::File& file, const std::string& group) {
  std::vector<BondParameters> parameters = std::move(bonding.parameters);
  bonding = {};
  bonding.parameters = std::move(parameters);
  const std::string at = group + "/bonds";
  if (!file.has(at + "/stones")) return;
  const auto stones_of = file.read_own_rows<std::int64_t>(at + "/stones");
  const auto numbers = file.read_own_rows<double>(at + "/numbers");
  std::string problem;
  std::vector<Bond> bonds;
  for (std::size_t n = 0; 3 * n < stones_of.size(); ++n) {
    Bond bond{};
    bond.first = stones_of[3 * n], bond.second = stones_of[3 * n + 1];
    bond.kind = stones_of[3 * n + 2];
    if (problem.empty() && (bond.kind < 0 || bond.kind >= std::ssize(bonding.parameters)))
      problem = fmt::format(
          "the checkpoint has bonds of the {}. [[bond]], but the deck has {}: give all of them, in "
          "the same order",
          bond.kind + 1, bonding.parameters.size());
    set_numbers(bond, &numbers.at(n * bond_numbers));
    bonds.push_back(bond);
  }
  problem = comm.first_problem(problem);
  if (!problem.empty()) throw InputError({problem});
  bonding.bonds = delivered(comm, std::span(state.id), bonds, [](const Bond& bond) {
    return std::array{bond.first, bond.second};
  });
  const auto breaks = file.read_own_rows<double>(at + "/breaks");
  const auto whole = [](double value) { return std::llround(value); };
  for (std::size_t k = 0; k + bond_break_columns <= breaks.size(); k += bond_break_columns) {
    const double* b = breaks.data() + k;
    bonding.breaks.push_back({b[0], whole(b[1]), whole(b[2]), static_cast<int>(whole(b[3])),
                              b[4] != 0, Vec3(b[5], b[6], b[7]), b[8], b[9], b[10]});
  }
  bonding.any = file.integer_attribute(group, "bonds_begun") != 0;
  bonding.made = file.integer_attribute(group, "bonds_made");
  bonding.longest = file.number_attribute(group, "bonds_longest");
}

}  // namespace trackbed::dem
