// A dataset of a history.
#pragma once

#include <string>
#include <vector>

#include "trackbed/io/file.hpp"

namespace trackbed::observe {

// [rows, width], grows; `values` are rows not yet in the file, `last` those of the last flush.
// width 0: nothing was sampled yet, so no dataset is created.
struct Column {
  std::string path;
  io::Label label;
  std::size_t width = 0;
  std::vector<double> values{}, last{};
};

}  // namespace trackbed::observe
