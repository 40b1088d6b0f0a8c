// The stages that move walls and tines or change a pressure: how far in a window, and the stones
// that run off the floor.
#pragma once

#include "app/world.hpp"
#include "trackbed/core/clock.hpp"

namespace trackbed::app {

// One window that begins `time` s after stage `number` did. Walls that stay finish their last
// motion; those that hold a pressure are moved by their servos.
void move_walls(World& world, std::size_t number, double time, double dt);
// The same for a platen whose way is given.
void push_platen(World& world, const Stage& stage, double time, double dt);
// The same for the platen's pressure, which goes from that of the stage before to its own.
void aim_platen(World& world, std::size_t number, double time, double dt);
// The same for tines and the sleepers between them, which are held.
void tamp(World& world, double time, double dt);
// Takes stones away whose centre is beyond the floor, at whole hundredths of a second of the stage.
// Collective.
void clear_beside_floor(World& world, const Clock& clock);

}  // namespace trackbed::app
