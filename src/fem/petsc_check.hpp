// Codes of PETSc become RunError.
#pragma once

#include <string>

#include "trackbed/core/error.hpp"

namespace trackbed::fem {

void check(int code, const char* what);

}  // namespace trackbed::fem
