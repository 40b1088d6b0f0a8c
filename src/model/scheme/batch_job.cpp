#include "trackbed/model/batch_job.hpp"

#include <chrono>
#include <cstdlib>
#include <limits>

namespace trackbed::model {

namespace {

// Unix time, s.
double end_of_job() {
  for (const char* name : {"TRACKBED_END_TIME", "SLURM_JOB_END_TIME"})
    if (const char* text = std::getenv(name)) {
      char* end = nullptr;
      const double value = std::strtod(text, &end);
      if (end != text && *end == '\0' && value > 0) return value;
    }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

double time_left_of_job() {
  static const double end = end_of_job();
  return end -
         std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

}  // namespace trackbed::model
