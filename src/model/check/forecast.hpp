// How many stones the layers of a bed will have, and what they cost by a table.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/scene/layer_stones.hpp"

namespace trackbed::model {

struct LayerForecast {
  std::string layer;      // name; empty: the uppermost one
  std::int64_t made = 0;  // stones that its stage of kind fill pours: exact
  std::int64_t left = 0;  // stones below the last profile and beside the sleepers: expected
  double step_time = 0;   // s of one core for a sub-step of a stone
};

// For each stage of kind fill, in order; copies of a cell are counted in `world`. `left` is correct
// as far as the compacted bed has the height and porosity given in the deck; stones of cribs are
// not included. Step times are those of a table. Throws InputError if the stones cannot be made.
// Collective.
std::vector<LayerForecast> forecast(const World& world, const StonesOfLayers& stones);
// The times of the table in words.
std::string table_of_times(Dimension dimension);
// What is poured and what remains, of the layers for which there is more to say than their number.
std::vector<std::string> sentences_of(const Model& model, const std::vector<LayerForecast>& layers);

}  // namespace trackbed::model
