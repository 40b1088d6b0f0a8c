// 64-bit hash of bytes and a finaliser with which hashes are combined by addition, so that the hash
// of a set does not depend on order or number of ranks.
#pragma once

#include <cstddef>
#include <cstdint>

namespace trackbed {

// XXH3 (Collet; xxHash 0.8), whose results do not depend on the processor. Of several ranges in
// turn: the seed of each is the hash of the one before.
std::uint64_t hash_bytes(const void* data, std::size_t bytes, std::uint64_t seed = 0);

// splitmix64 finaliser (Steele, Lea, Flood 2014, doi:10.1145/2660193.2660195).
inline std::uint64_t mix(std::uint64_t value) {
  value += 0x9e3779b97f4a7c15ULL;
  value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9ULL;
  value = (value ^ (value >> 27)) * 0x94d049bb133111ebULL;
  return value ^ (value >> 31);
}

// Uniform in [0, 1) from a seed and a key: the same draw for the same item on any rank.
inline double uniform(std::uint64_t seed, std::uint64_t key) {
  return static_cast<double>(mix(seed ^ mix(key)) >> 11) * 0x1.0p-53;
}

}  // namespace trackbed
