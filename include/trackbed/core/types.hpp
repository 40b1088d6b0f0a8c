// Types for quantities in space that all modules use. SI units throughout: m, kg, s, N, Pa. The x
// axis is along the track in the direction of travel, y is lateral, z is upwards.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>

namespace trackbed {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;  // rotates from the body's principal axes to space

using Id = std::int64_t;  // identifies a particle, node or element, equally on every rank

inline constexpr double gravity = 9.81;  // m/s^2, along -z

// Dimension of the model. `plane`: translation in y and rotations about x and z are fixed.
enum class Dimension { plane, space };

}  // namespace trackbed
