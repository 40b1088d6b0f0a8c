// PETSc for the lifetime of a program. Create it in main after par::Environment, with the arguments
// that follow `--`; a Ground that solves without it initialises PETSc with defaults, which
// MPI_Finalize then ends.
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

  // Initialises PETSc if it is not. Collective over the world.
  static void ensure();
  // Sets up the solvers of this ground in steps of `window` s (0: not known yet), so that options
  // which PETSc rejects are reported before a run. Does nothing without options. Output of options
  // to files or to the screen is left to the run. Returns the names of options that were set but
  // not used, without those that may be used later in a solve. Collective; throws InputError.
  static std::vector<std::string> try_options(const par::Comm& comm,
                                              const GroundParameters& parameters,
                                              Dimension dimension, double thickness, double window);
  // Names of options that were set but not used up to now: mostly misspelt.
  static std::vector<std::string> unused_options();
};

}  // namespace trackbed::fem
