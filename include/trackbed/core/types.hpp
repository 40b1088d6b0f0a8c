// The words every room uses for numbers in space. SI units throughout: m, kg, s, N, Pa.
// x runs along the track in the direction of travel, y is lateral, z points up.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>

namespace trackbed {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;  // rotates from the body's principal axes to space

using Id = std::int64_t;  // names a particle, node or element the same way on every rank

inline constexpr double gravity = 9.81;  // m/s^2, along -z

// In which space a model lives. `plane`: y translation and x, z rotations are frozen.
enum class Dimension { plane, space };

}  // namespace trackbed
