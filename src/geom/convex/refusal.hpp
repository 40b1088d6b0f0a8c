// What a shape or file that cannot be used throws; callers add its name.
#pragma once

#include <stdexcept>
#include <string>

namespace trackbed::geom {

[[noreturn]] inline void refuse(const std::string& reason) { throw std::invalid_argument(reason); }

}  // namespace trackbed::geom
