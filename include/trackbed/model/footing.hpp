// Where sleepers of a track without stones rest on a ground of elements, and the rules that tie
// track and ground together.
#pragma once

#include <cstdint>
#include <vector>

#include "trackbed/couple/footprints.hpp"
#include "trackbed/input/section.hpp"
#include "trackbed/observe/passage.hpp"

namespace trackbed::model {

struct Model;

// Sleepers `before` to `before + count - 1` of the track have the ground below their ballast.
struct FootingParameters {
  std::int64_t before = 20, count = 1;
  double first = 0;                   // m, x of the first of them, in the ground's coordinates
  double width = 0.29, length = 1.3;  // m along x and y, of the area loaded by their ballast
  double y = 0;                       // m, middle of this area
  double rails = 1;                   // number of rails whose load the ground carries
  void declare(input::Section& s);
};

// One rectangle per sleeper, in a plane model over its thickness, m; on two rails one for each of
// its two ballast springs, left before right: the same rectangle with the pressure gradient of the
// spring's arm.
std::vector<couple::Rectangle> footprints_of(const Model& model);

// Of a track without stones, for pictures and field files: in the coordinates of its ground, or
// from x = 0 without one.
observe::TrackShape shape_of_track(const Model& model);

// model = "track_on_ground": rules that tie track and ground together; other models must have no
// footing.
void declare_footing(const Model& model, input::Section& s);

}  // namespace trackbed::model
