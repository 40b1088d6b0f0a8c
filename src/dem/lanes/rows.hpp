// Eight Vec4, from anywhere in memory, as four `Lanes`, and back: each row is loaded as a whole and
// the eight are transposed in registers. Rejected: filling lanes number by number, because the
// vector load then waits for the scalar stores. Numbers of rows are used and not pointers to them:
// eight pointers for each of several arrays do not stay in registers.
#pragma once

#include "dem/lanes/lanes.hpp"

namespace trackbed::dem {

// One Vec4 in a register.
using Four [[gnu::vector_size(32)]] = double;
using FourInMemory [[gnu::vector_size(32), gnu::may_alias]] = double;

struct Lanes4 {
  Lanes x, y, z, w;
  [[gnu::always_inline]] Lanes3 xyz() const { return {x, y, z}; }
};

[[gnu::always_inline]] inline Four four(const Vec4& v) {
  return *reinterpret_cast<const FourInMemory*>(&v);
}
[[gnu::always_inline]] inline void put(Vec4& to, Four v) {
  *reinterpret_cast<FourInMemory*>(&to) = v;
}

// a[k] is row k (low half) and row k + 4 (high half).
[[gnu::always_inline]] inline Lanes4 transposed(const Lanes (&a)[4]) {
  const Lanes even01 = __builtin_shufflevector(a[0], a[1], 0, 8, 2, 10, 4, 12, 6, 14);
  const Lanes odd01 = __builtin_shufflevector(a[0], a[1], 1, 9, 3, 11, 5, 13, 7, 15);
  const Lanes even23 = __builtin_shufflevector(a[2], a[3], 0, 8, 2, 10, 4, 12, 6, 14);
  const Lanes odd23 = __builtin_shufflevector(a[2], a[3], 1, 9, 3, 11, 5, 13, 7, 15);
  return {__builtin_shufflevector(even01, even23, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(odd01, odd23, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(even01, even23, 2, 3, 10, 11, 6, 7, 14, 15),
          __builtin_shufflevector(odd01, odd23, 2, 3, 10, 11, 6, 7, 14, 15)};
}

// Rows `row(0)` to `row(7)`, each a Four.
template <class Row>
[[gnu::always_inline]] inline Lanes4 rows_of(Row&& row) {
  Lanes pair[4];
  for (std::size_t k = 0; k < 4; ++k)
    pair[k] = __builtin_shufflevector(row(k), row(k + 4), 0, 1, 2, 3, 4, 5, 6, 7);
  return transposed(pair);
}
// Rows `at(0)` to `at(7)` of an array.
template <class At>
[[gnu::always_inline]] inline Lanes4 rows(const Vec4* array, At&& at) {
  return rows_of([&](std::size_t k) { return four(array[at(k)]); });
}
// Eight consecutive rows.
[[gnu::always_inline]] inline Lanes4 rows(const Vec4* array) {
  return rows(array, [](std::size_t k) { return k; });
}

// The reverse: put_row(k, row) for each of the eight.
template <class Put>
[[gnu::always_inline]] inline void to_rows(const Lanes4& v, Put&& put_row) {
  const Lanes even01 = __builtin_shufflevector(v.x, v.y, 0, 8, 2, 10, 4, 12, 6, 14);
  const Lanes odd01 = __builtin_shufflevector(v.x, v.y, 1, 9, 3, 11, 5, 13, 7, 15);
  const Lanes even23 = __builtin_shufflevector(v.z, v.w, 0, 8, 2, 10, 4, 12, 6, 14);
  const Lanes odd23 = __builtin_shufflevector(v.z, v.w, 1, 9, 3, 11, 5, 13, 7, 15);
  const Lanes pair[4] = {__builtin_shufflevector(even01, even23, 0, 1, 8, 9, 4, 5, 12, 13),
                         __builtin_shufflevector(odd01, odd23, 0, 1, 8, 9, 4, 5, 12, 13),
                         __builtin_shufflevector(even01, even23, 2, 3, 10, 11, 6, 7, 14, 15),
                         __builtin_shufflevector(odd01, odd23, 2, 3, 10, 11, 6, 7, 14, 15)};
  for (std::size_t k = 0; k < 4; ++k) {
    put_row(k, __builtin_shufflevector(pair[k], pair[k], 0, 1, 2, 3));
    put_row(k + 4, __builtin_shufflevector(pair[k], pair[k], 4, 5, 6, 7));
  }
}

}  // namespace trackbed::dem
