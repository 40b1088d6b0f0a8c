// Where sleepers of a track without stones rest on a ground of elements, and what of both cannot be
// put together.
#pragma once

#include <cstdint>
#include <vector>

#include "trackbed/couple/footprints.hpp"
#include "trackbed/input/section.hpp"

namespace trackbed::app {

struct Model;

// Sleepers `before` to `before + count - 1` of the track have the ground below their ballast.
struct FootingParameters {
  std::int64_t before = 20, count = 1;
  double first = 0;                   // m, x of the ground, of the first of them
  double width = 0.29, length = 1.3;  // m along x and y, of what their ballast presses on
  double y = 0;                       // m, its middle
  double rails = 1;                   // whose load the ground carries
  void declare(input::Section& s);
};

// Of each sleeper, in a plane model over its thickness, m; on two rails of each of its two ballast
// springs, left before right: the same rectangle, pressed as the spring's force and arm are.
std::vector<couple::Rectangle> footprints_of(const Model& model);

// model = "track_on_ground": rules that tie track and ground together; of other models that they
// have no footing.
void declare_footing(const Model& model, input::Section& s);

}  // namespace trackbed::app
