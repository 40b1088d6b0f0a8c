// Codes of PETSc become RunError; options that it refuses, InputError.
#pragma once

#include <petscksp.h>

#include <string>

#include "trackbed/core/error.hpp"

namespace trackbed::fem {

void check(int code, const char* what);
// Sets a solver as the options after -- say. Collective.
void take_options(KSP solver);

}  // namespace trackbed::fem
