#include "trackbed/core/hash.hpp"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace trackbed {

std::uint64_t hash_bytes(const void* data, std::size_t bytes, std::uint64_t seed) {
  return XXH3_64bits_withSeed(data, bytes, seed);
}

}  // namespace trackbed
