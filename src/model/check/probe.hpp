// Wall times measured in `check`, on the cores on which it runs: of the stones of a bed as it is
// laid from a cell, and of the ground.
#pragma once

#include <functional>

#include "model/scene/world.hpp"
#include "trackbed/model/course.hpp"

namespace trackbed::model {

// s of wall time of a window, the mean of several; the first one, which is not counted, sets up
// neighbour lists or matrices. Collective.
double measured_time_of(const par::Comm& comm, const std::function<void()>& window);

// s of wall time of a window of the stones and of the coupler, in the bed as it is now. Moves the
// stones. Throws RunError if they cannot be computed. Collective.
double measured_window_of_stones(World& world, const Steps& steps);

// s of wall time of a window of the ground under small loads that change: explicit steps, or an
// implicit one; a ground that yields takes more. Moves the ground. Collective.
double measured_window_of_ground(World& world, double window);

}  // namespace trackbed::model
