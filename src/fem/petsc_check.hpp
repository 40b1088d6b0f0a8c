// Codes of PETSc become RunError; options that it refuses, InputError.
#pragma once

#include <petscksp.h>

#include <string>

#include "trackbed/core/error.hpp"

namespace trackbed::fem {

void check(int code, const char* what);
// Sets a solver as the options say; numbers out of range are refused as well. Collective.
void take_options(KSP solver);
// Before the first solve, where PETSc finds what of the options does not go together. Collective.
void set_up(KSP solver);
// Of that only who factorises, for a solver that may never be set up. Collective.
void find_factors(KSP solver);

}  // namespace trackbed::fem
