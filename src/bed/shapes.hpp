// Templates of the stones that a deck describes.
#pragma once

#include "trackbed/bed/bed.hpp"

namespace trackbed::bed {

constexpr int union_columns = 192;  // across a union of spheres, to integrate its mass

// Template of `seed` that just passes a slot of `size` m. Throws InputError if no pebble fits.
dem::Template outline_stone(const BedParameters& parameters, double size, std::uint64_t seed);
dem::Template round_stone(Dimension dimension);                                   // diameter 1 m
dem::Template clump_stone(const BedParameters& parameters, Dimension dimension);  // extent 1 m
// The k-th polyhedron, compound or filled polyhedron; about 1 m. Throws InputError if it cannot be
// generated; `polyhedron_shape` throws std::invalid_argument, for callers whose parameters have
// other names.
dem::Template polyhedron_stone(const BedParameters& parameters, std::int64_t k);
dem::Template polyhedron_shape(const BedParameters& parameters, std::int64_t k);

// Each sphere as a piece, with a core of one corner.
std::vector<geom::Piece> balls(const std::vector<geom::Sphere>& spheres);

}  // namespace trackbed::bed
