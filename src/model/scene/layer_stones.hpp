// The stones of the layers that stages make, before any stone exists.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "model/scene/steps.hpp"
#include "trackbed/bed/bed.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/model/checks.hpp"

namespace trackbed::model {

// Of all layers together, with this fraction of the stiffness of contacts.
StonesStep step_of(const Model& model, const StonesOfLayers& layers, double stiffness = 1);

}  // namespace trackbed::model
