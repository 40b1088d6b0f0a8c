// Rules that tie modules together, checked while the deck is read.
#pragma once

#include "trackbed/input/deck.hpp"
#include "trackbed/model/checks.hpp"

namespace trackbed::model {

// Declares them to the open root section, after all parameters that they read.
constexpr double same_length = 1e-9;  // m, between lengths of a deck that are meant to be equal

// Number of sleepers before x m from the start of the track.
std::size_t sleepers_up_to(const track::TrackParameters& track, double x);

void declare_rules(const Model& model, input::Section& s);
void declare_train(const Model& model, input::Section& s);  // after the track has been read
// Parts of declare_rules.
void declare_ground_mesh(const Model& model, input::Section& s);
void declare_ground_sides(const Model& model, input::Section& s);
// Warns of a ground without the damping that the coupling needs, after the time steps.
void declare_delay(const Model& model, input::Section& s);
// Warns of a ground that is held in a stage after it moved.
void declare_held_again(const Model& model, input::Section& s);
// Warns of a load just before the ground begins to move, of which it would still contain a part.
void declare_begin_of_motion(const Model& model, input::Section& s);
// Parameters without effect: sides that a plane model does not have, `sides` if each side has its
// own kind. Blocks of a plane model have no position across the track.
void declare_idle_sides(const fem::GroundParameters& ground, Dimension dimension,
                        input::Section& s);
void declare_ground_yields(const Model& model, input::Section& s);
void declare_walls(const Model& model, input::Section& s);
inline constexpr const char* breakage_meaning =
    "Breakage: pebbles of clumps break off; polyhedra split and lose corners (docs/breakage.md).";
void declare_breakage(const Model& model, input::Section& s);
inline constexpr const char* bond_meaning =
    "Bonds between stones: glued ballast, agglomerates (docs/bonds.md).";
void declare_bonds(const Model& model, input::Section& s);
void declare_tamping(const Model& model, input::Section& s);
// Warns of a dem.safety that is large for compacted stones with corners, if there are any.
void declare_steadiness(const Model& model, bool corners, input::Section& s);
// Rules for intervals and cycles that windows must resolve, after the time steps have been read.
void declare_intervals(const Model& model, input::Section& s);
void declare_jump_period(const Model& model, input::Section& s);  // after the jump's parameters

// Stages: names, order, used parameters; regions: names, and whether they can contain stones.
void declare_stages(const Model& model, input::Section& s);
void declare_names_of_stages(const Model& model, input::Section& s);  // parts of it
void declare_uses_of_stages(const Model& model, input::Section& s);
void declare_names_of_pressures(const Model& model, input::Section& s);
void declare_names_of_bonds(const Model& model, input::Section& s);
void declare_names_of_placed(const Model& model, input::Section& s);
void declare_regions(const Model& model, input::Section& s);
// Names of sensors, and whether there can be something to read at their places.
void declare_fields(const Model& model, input::Section& s);
void declare_sensors(const Model& model, input::Section& s);
// Which layers of the bed are poured, whether its outline is possible and its ballast plausible.
void declare_layers(const Model& model, input::Section& s);
void declare_profile(const Model& model, input::Section& s);
void declare_ballast(const Model& model, input::Section& s);

}  // namespace trackbed::model
