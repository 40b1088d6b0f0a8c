// Rules that tie rooms together, checked while the deck is read.
#pragma once

#include "app/parameters.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::app {

// Declares them to the open root section, after all that they read.
void declare_rules(const Model& model, input::Section& s);
void declare_train(const Model& model, input::Section& s);  // once the track is read, too
// Parts of declare_rules.
void declare_ground_mesh(const Model& model, input::Section& s);
void declare_ground_sides(const Model& model, input::Section& s);
// What has no effect: sides that a plane model does not have, `sides` where each has its own. A
// plane model's blocks have no place across.
void declare_idle_sides(const fem::GroundParameters& ground, Dimension dimension,
                        input::Section& s);
void declare_ground_yields(const Model& model, input::Section& s);
void declare_walls(const Model& model, input::Section& s);
void declare_tamping(const Model& model, input::Section& s);
// Warns of a dem.safety that is large for pressed stones with corners, if there are any.
void declare_steadiness(const Model& model, bool corners, input::Section& s);
// What only the files of a ground can tell: all that is wrong with its mesh, and a bed that reaches
// beyond its top; odd moduli along a layer; sides that hold the wave from below. Throws InputError.
// Reads the files, if there are any; else all is empty.
struct GroundFile {
  std::string size;  // a line about extent and volume of a mesh
  std::vector<std::string> warnings;
};
GroundFile require_ground(const Model& model, const input::Deck& deck);
// The same for intervals and cycles that windows must resolve, once the steps in time are read.
void declare_intervals(const Model& model, input::Section& s);

// Where a table of seat loads begins or ends with a jump while axles pass. Throws InputError about
// the table, which it reads.
std::vector<std::string> doubts_of_loads(const Model& model);

// Stages: names, order, what they use; regions: names, and whether stones can be there.
void declare_stages(const Model& model, input::Section& s);
void declare_names_of_stages(const Model& model, input::Section& s);  // parts of it
void declare_uses_of_stages(const Model& model, input::Section& s);
void declare_names_of_pressures(const Model& model, input::Section& s);
void declare_names_of_placed(const Model& model, input::Section& s);
void declare_regions(const Model& model, input::Section& s);
// Which layers of the bed are poured, and whether its outline can be.
void declare_layers(const Model& model, input::Section& s);
void declare_profile(const Model& model, input::Section& s);

}  // namespace trackbed::app
