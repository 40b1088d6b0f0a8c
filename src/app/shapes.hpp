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
  std::int64_t stones = 0;         // parametric ones
  geom::StoneShape stone;
  std::int64_t seed = 1;
  bed::MeshShape mesh;  // its rounding is that of parametric stones too
  std::string library, picture;
  std::vector<std::string> given;  // names of all options that were, "--seed" for example
};

// Shows, then writes; old files give way only to complete ones of their kind.
int shapes(const par::Comm& comm, const ShapeArguments& arguments);

}  // namespace trackbed::app
