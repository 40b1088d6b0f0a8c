// Green's functions of a track in a file, for condition monitoring: the command `kernel`.
#pragma once

#include <cstdint>
#include <string>

#include "trackbed/model/parameters.hpp"
#include "trackbed/par/comm.hpp"
#include "trackbed/track/greens.hpp"

namespace trackbed::model {

// `step`, `axles` and `side` follow from the model and the members below.
struct KernelParameters : track::GreensParameters {
  std::string rail = "left";  // of two rails: left or right
  double apart = 0.01;        // m, between positions of the force
  // Number of axles, from the first one, of the moving response; 0: those of the first bogie.
  std::int64_t bogie = 0;
  double from = 0, to = 0;  // m, range of the force of the moving response; to 0: track's end
};

// Writes the functions and the wheels of the model's train into `file` (HDF5). Returns a line that
// describes them. Throws InputError with all reasons if the track has none. Collective: every rank
// computes all functions, rank 0 writes.
std::string write_kernel(const par::Comm& comm, const Model& model, KernelParameters parameters,
                         const std::string& file);

}  // namespace trackbed::model
