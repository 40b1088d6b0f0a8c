// Text without regard to case. Private to the module.
#pragma once

#include <string>

namespace trackbed::input {

// Letters of names are ASCII.
std::string lower(std::string text);  // nearest.cpp

}  // namespace trackbed::input
