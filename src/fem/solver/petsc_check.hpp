// Error codes of PETSc become RunError; rejected options, InputError.
#pragma once

#include <petscksp.h>

#include <string>

#include "trackbed/core/error.hpp"

namespace trackbed::fem {

void check(int code, const char* what);
// Sets a solver from the options; rejects numbers out of range. Collective.
void set_from_options(KSP solver);
// Set-up before the first solve, in which PETSc detects inconsistent options. Collective.
void set_up(KSP solver);
// Only selects the direct solver, for a solver that may never be set up. Collective.
void set_up_factors(KSP solver);

}  // namespace trackbed::fem
