// Templates in a file: of a checkpoint, or of a library of shapes.
#pragma once

#include <string>
#include <vector>

#include "trackbed/dem/particles.hpp"
#include "trackbed/io/file.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::dem {

// Templates are the same on every rank: the root writes them. A piece is stored as its corners, its
// faces as loops of corners and its radius; all else is derived. Collective.
void save_templates(io::File& file, const std::string& group,
                    const std::vector<Template>& templates, const par::Comm& comm);
std::vector<Template> load_templates(const io::File& file, const std::string& group);

}  // namespace trackbed::dem
