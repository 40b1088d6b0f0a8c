// Checks of the wave of ground.base_motion: whether the sides of a ground of layers conform to it,
// whether it acts while the ground moves, and whether the elements resolve it.
#pragma once

#include <string>
#include <vector>

#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

struct WaveAtSide {
  std::string key, kind;  // in [ground]: of one side or of all; its boundary condition
  std::string words;      // the rest of the sentence
  bool refused = false;   // else a warning
};

// Sides at which the ground would not move as the wave does, each key once; none without a wave.
// Reads the table: throws InputError about it. Not for a mesh file (look_at_mesh). Local.
std::vector<WaveAtSide> look_at_wave(const GroundParameters& parameters, Dimension dimension);

// Rules for ground.sides in the whole deck, if a side uses it; the dimension decides which sides
// exist.
void declare_common_side(const GroundParameters& parameters, input::Section& s);

// Warnings about the speed of a wave, and about its arrival time at a ground that moves for at most
// `time` s (infinity: not known). Sentences without the name of the file; none without a wave.
// Reads the tables: throws InputError about them. Local.
std::vector<std::string> look_at_times(const GroundParameters& parameters, Dimension dimension,
                                       double time);

struct UnresolvedLayer {
  std::size_t layer = 0;
  std::string words;  // about its elements
};

// Layers whose elements are too high for the frequencies of a wave along x or z: these arrive late
// at the top, and the peak is too low. None without a wave, and none of tetrahedra. Reads the
// tables: throws InputError about them. Local.
std::vector<UnresolvedLayer> look_at_elements(const GroundParameters& parameters,
                                              Dimension dimension);

}  // namespace trackbed::fem
