// Stages that move walls and tines or change a pressure: their motion in a window, and the removal
// of stones that leave the floor.
#pragma once

#include "model/scene/world.hpp"
#include "trackbed/core/clock.hpp"

namespace trackbed::model {

// Moves walls in a window that begins `time` s after stage `number` did. Fixed walls complete their
// last displacement; walls with a controlled pressure are moved by their servos.
void move_walls(World& world, std::size_t number, double time, double dt);
// The same for a platen whose displacement is given.
void drive_platen(World& world, const Stage& stage, double time, double dt);
// The same for the platen's target pressure, which changes from that of the preceding stage.
void aim_platen(World& world, std::size_t number, double time, double dt);
// The same for tines and the sleepers between them, whose motion is given.
void tamp(World& world, double time, double dt);
// Removes stones whose centre is beyond the floor, every hundredth of a second of the stage.
// Collective.
void clear_beside_floor(World& world, const Clock& clock);

}  // namespace trackbed::model
