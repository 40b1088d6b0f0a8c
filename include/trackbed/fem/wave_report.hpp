// What the wave of ground.base_motion and the sides of a ground of layers make of each other, and
// whether the ground feels the wave at all, and its zones carry it.
#pragma once

#include <string>
#include <vector>

#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

struct WaveAtSide {
  std::string key, kind;  // in [ground]: of the side or of all, and what it is
  std::string words;      // go on after them
  bool refused = false;   // otherwise odd, but legitimate
};

// Sides at which the ground would not move as the wave does, each key once; none without a wave.
// Reads the table: throws InputError about it. Not for a mesh file (look_at_mesh). Local.
std::vector<WaveAtSide> look_at_wave(const GroundParameters& parameters, Dimension dimension);

// Rules for ground.sides in the whole deck, where a side takes it: which ones there are the
// dimension tells.
void declare_common_side(const GroundParameters& parameters, input::Section& s);

// What is odd about the speed of a wave, and about when it comes to a ground that moves for `time`
// s at most once it is let go (infinity: nobody knows). Sentences without the file's name; none
// without a wave. Reads the tables: throws InputError about them. Local.
std::vector<std::string> look_at_times(const GroundParameters& parameters, Dimension dimension,
                                       double time);

struct BlurringLayer {
  std::size_t layer = 0;
  std::string words;  // about its zones
};

// Layers whose zones are too high for the frequencies of a wave along x or z: those arrive late at
// the top, and its peak is lower than it should be. None without a wave, and of tetrahedra. Reads
// the tables: throws InputError about them. Local.
std::vector<BlurringLayer> look_at_zones(const GroundParameters& parameters, Dimension dimension);

}  // namespace trackbed::fem
