// The stones of the layers that stages make, before any stone exists.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "app/parameters/parameters.hpp"
#include "app/scene/steps.hpp"
#include "trackbed/bed/bed.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::app {

// The stones of each layer that stages make, by its name, before any stone exists.
using StonesOfLayers = std::map<std::string, bed::Stones>;

// Throws InputError if the stones of the deck cannot be made, or if its step is unstable for them:
// checked from the deck alone, so that a run is refused before it writes anything. Returns what
// they will be, since placing them takes time. Collective.
StonesOfLayers require_stones(const par::Comm& comm, const Model& model, const input::Deck& deck);

// Sentences about layers whose stones are much longer than the sieves they pass.
std::vector<std::string> warnings_of(const Model& model, const StonesOfLayers& layers);

// Of all layers together.
StonesStep step_of(const Model& model, const StonesOfLayers& layers);

}  // namespace trackbed::app
