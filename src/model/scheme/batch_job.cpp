#include "trackbed/model/batch_job.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <string>

#include "trackbed/core/error.hpp"
#include "trackbed/core/unix_time.hpp"

namespace trackbed::model {

namespace {

constexpr const char* own_name = "TRACKBED_END_TIME";
constexpr const char* name_of_slurm = "SLURM_JOB_END_TIME";

// Unix time, s, that a variable states.
std::optional<double> time_in(const char* name) {
  const char* text = std::getenv(name);
  if (text == nullptr) return {};
  char* end = nullptr;
  const double value = std::strtod(text, &end);
  if (end == text || *end != '\0' || !std::isfinite(value)) return {};
  return value;
}

// Of Slurm's variable only a time to come counts: a job may be allowed to run beyond its end.
double end_of_job() {
  if (const auto own = time_in(own_name)) return *own;
  const auto of_slurm = time_in(name_of_slurm);
  return of_slurm && *of_slurm > unix_time() ? *of_slurm : std::numeric_limits<double>::infinity();
}

}  // namespace

void require_time_of_job() {
  const char* text = std::getenv(own_name);
  if (text == nullptr) return;
  constexpr double year = 3.2e7;  // s; milliseconds would lie far beyond
  const auto end = time_in(own_name);
  if (end && *end > unix_time() && *end < unix_time() + 10 * year) return;
  throw InputError(
      {fmt::format("the environment variable {} = \"{}\" must be a time to come in s since 1970 "
                   "(now {:.0f}); set "
                   "it to the end of this batch job, or unset it",
                   own_name, text, unix_time())});
}

double time_left_of_job() {
  static const double end = end_of_job();
  return end - unix_time();
}

}  // namespace trackbed::model
