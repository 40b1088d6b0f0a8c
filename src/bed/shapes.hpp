// Templates of stones and the openings they pass.
#pragma once

#include <vector>

#include "trackbed/bed/bed.hpp"

namespace trackbed::bed {

// Smallest slot (plane) or square hole (space) that the spheres pass, by a raster of directions.
double smallest_slot(const std::vector<geom::Sphere>& disks);
double smallest_hole(const std::vector<geom::Sphere>& spheres);

// Pieces about the centre of mass in principal axes.
dem::Template template_of(const std::vector<geom::Sphere>& spheres, const geom::Solid& solid,
                          double sieve);

// Template of `seed` as large as passes a slot of `size` m. Throws InputError if no pebble fits.
dem::Template outline_stone(const BedParameters& parameters, double size, std::uint64_t seed);
dem::Template round_stone(Dimension dimension);                                   // diameter 1 m
dem::Template clump_stone(const BedParameters& parameters, Dimension dimension);  // extent 1 m

}  // namespace trackbed::bed
