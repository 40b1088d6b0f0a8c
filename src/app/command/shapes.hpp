// The command `shapes`: a table of stones, a library and a picture of them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trackbed/bed/library.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// Defaults are those of parametric stones in decks.
struct ShapeArguments {
  std::vector<std::string> files;  // decks, libraries, meshes
  std::int64_t stones = 0;         // number of parametric stones
  geom::StoneShape stone;
  std::int64_t seed = 1;
  bed::MeshShape mesh;  // its rounding is that of parametric stones too
  std::string library, picture;
  std::vector<std::string> given;  // names of all options that were given, for example "--seed"
};

// Prints, then writes; existing files are replaced only by complete files of the same kind.
int shapes(const par::Comm& comm, const ShapeArguments& arguments);

}  // namespace trackbed::app
