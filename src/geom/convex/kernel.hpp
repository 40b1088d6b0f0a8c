// CGAL's kernel, for the files named ..._cgal.cpp only. Its exact predicates switch the rounding
// mode; without this option the compiler folds constants across the switch.
#pragma once

#if defined(__GNUC__) && !defined(__clang__) && !defined(__ROUNDING_MATH__)
#error "files that use CGAL are compiled with -frounding-math (src/geom/CMakeLists.txt)"
#endif

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace trackbed::geom {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

}  // namespace trackbed::geom
