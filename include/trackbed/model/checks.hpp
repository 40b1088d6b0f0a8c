// Checks of a deck that need its files, its stones or the built model.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "trackbed/bed/bed.hpp"
#include "trackbed/bed/placed.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/model/parameters.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::model {

// Checks that need the files of a ground: its mesh, and whether the bed reaches beyond its top;
// unusual moduli along a layer; sides that restrain the incoming wave. Throws InputError. Empty if
// there are no files.
struct GroundFile {
  std::string size;  // a line about extent and volume of a mesh
  std::vector<std::string> warnings;
};
GroundFile require_ground(const Model& model, const input::Deck& deck);
// Warnings of tables of seat loads that begin or end with a jump while axles pass. Reads the table;
// throws InputError for a bad one.
std::vector<std::string> warnings_of_loads(const Model& model);

// Warnings on files of irregularities; throws InputError for a bad one.
std::vector<std::string> warnings_of_files(const TrackModel& model);

// The stones of each layer that stages make, by its name, before any stone exists.
using StonesOfLayers = std::map<std::string, bed::Stones>;

// Throws InputError if the stones of the deck cannot be made, or if its step is unstable for them:
// checked from the deck alone, so that a run is refused before it writes anything. Returns what
// they will be, since placing them takes time. Collective.
StonesOfLayers require_stones(const par::Comm& comm, const Model& model, const input::Deck& deck);

// Sentences about layers whose stones are much longer than the sieves they pass.
std::vector<std::string> warnings_of(const Model& model, const StonesOfLayers& layers);

struct StonesToPlace {
  std::vector<bed::PlacedShape> shapes;  // in the order of the deck; making them takes time
  std::vector<std::string> warnings;
};
// Throws InputError if a stone cannot be made, if stones initially overlap each other or a surface
// too deeply, or if the step of the deck is too long for them. Empty for other models. Collective.
StonesToPlace require_placed(const par::Comm& comm, const Model& model, const input::Deck& deck);

// The shapes of all placed stones, in the order of the deck. Throws InputError. Collective.
std::vector<bed::PlacedShape> placed_shapes(const par::Comm& comm, const Model& model);

// A line about train, rail and supports that the deck does not give, or nothing.
std::string words_of_defaults(const Model& model, const input::Deck& deck);

// Input of the estimate of a run in stages besides its model.
struct StagesToCheck {
  const input::Deck& deck;
  std::string name;    // of the deck
  std::string start;   // checkpoint to start from, or empty
  std::string ground;  // GroundFile::size
  const StonesToPlace& placed;
  const StonesOfLayers& stones;
  const std::vector<int>& ranks;  // for which the work is to be stated
};
// Builds the model as far as possible without moving it, and prints its properties, an estimate of
// the run, and the memory. Collective.
void check_stages(const par::Comm& comm, const Model& model, const StagesToCheck& given);
// The model of the deck, seen from the side, as the contents of an SVG file: ground and walls,
// ballast as it is poured, sleepers where they are placed, the train at its start, placed stones.
// `shapes`: of placed stones, in the order of the deck; `name`: of the deck. Local.
std::string drawing_of(const Model& model, const std::vector<bed::PlacedShape>& shapes,
                       const std::string& name);
// Prints the properties of the model and an estimate of the wall time from some steps. Collective.
void check_track(const par::Comm& comm, const Model& model);

}  // namespace trackbed::model
