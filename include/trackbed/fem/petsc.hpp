// PETSc for the life of a program. Create it in main after par::Environment, with the arguments
// that follow `--`; a Ground that solves without it starts PETSc with defaults, and MPI_Finalize
// then ends it.
#pragma once

#include <string>
#include <vector>

#include "trackbed/core/types.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::fem {

struct GroundParameters;

class Petsc {
 public:
  // Solver options begin with `ground_`: {"-ground_ksp_type", "gmres"}.
  explicit Petsc(const std::vector<std::string>& options = {});
  ~Petsc();
  Petsc(const Petsc&) = delete;
  Petsc& operator=(const Petsc&) = delete;

  // Starts PETSc if nobody did. Collective over the world.
  static void ensure();
  // Sets up the solvers that this ground needs in steps of `window` s (0: not known yet), so that
  // options which they refuse are known before a run. Nothing if none were given. What options
  // write, into files or on the screen, is left to the run. Returns the names of those that nothing
  // asked for, without those that may come into use as a run solves.
  // Collective; InputError.
  static std::vector<std::string> try_options(const par::Comm& comm,
                                              const GroundParameters& parameters,
                                              Dimension dimension, double thickness, double window);
  // Names of options that were given and that nothing has asked for so far: mostly misspelt.
  static std::vector<std::string> unused_options();
};

}  // namespace trackbed::fem
