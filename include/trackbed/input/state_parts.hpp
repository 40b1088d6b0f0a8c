// The parts of a run's state that fix parameters: a run continues from a checkpoint that contains
// such a part only with the same values of the parameters on which the part depends.
#pragma once

#include <cstdint>

namespace trackbed::input {

using StateParts = std::uint32_t;  // a set: the bits of namespace state

namespace state {

inline constexpr StateParts none = 0;
inline constexpr StateParts any = 1 << 0;       // every checkpoint
inline constexpr StateParts earlier = 1 << 1;   // every one whose deck has the parameter
inline constexpr StateParts passage = 1 << 2;   // a run of a track alone or on a ground
inline constexpr StateParts sleepers = 1 << 3;  // placed
inline constexpr StateParts solid_sleepers = 1 << 4;
inline constexpr StateParts solid_rails = 1 << 5;
inline constexpr StateParts tines = 1 << 6;  // inserted
inline constexpr StateParts train = 1 << 7;  // under way on a bed
// Of a file: another one may be named while a train is under way, but a changed content under the
// same name is a mistake.
inline constexpr StateParts content_with_train = 1 << 8;
// A ground that has moved from static equilibrium. Its state is the displacement from there, which
// depends on boundary conditions, springs and plane state as well as on materials: other values
// would release forces that nothing balances, and a border fixed from now on would keep its
// velocity. Damping, tolerances and the constants of integrators are not part of the state.
inline constexpr StateParts moved_ground = 1 << 9;
inline constexpr StateParts moved_plane_ground = 1 << 10;
inline constexpr StateParts moved_viscous_base = 1 << 11;
// The last step was implicit. Implicit steps can continue from the displacement, velocity and
// acceleration of explicit ones, but they leave the nodal forces of their predictor, which explicit
// steps would take for the present forces.
inline constexpr StateParts moved_implicitly = 1 << 12;

}  // namespace state

}  // namespace trackbed::input
