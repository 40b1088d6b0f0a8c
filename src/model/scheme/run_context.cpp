#include "trackbed/model/run_context.hpp"

#include "trackbed/core/whole_steps.hpp"
#include "trackbed/model/batch_job.hpp"
#include "trackbed/model/effective.hpp"
#include "trackbed/model/interrupt.hpp"

namespace trackbed::model {

void RunContext::warn(const std::string& sentence) {
  course.warnings.push_back(sentence);
  log.warning(sentence);
}

bool RunContext::is_to_stop() const {
  if (interrupted()) return true;
  if (!comm.root()) return false;
  const double limit = model.output.wall_time;
  return (limit > 0 && log.wall_time() > limit) || time_left_of_job() < reserve;
}

observe::FieldFiles RunContext::field_files(const std::string& name,
                                            const std::vector<std::string>& parts) const {
  return {
      .folder = folder + "/fields",
      .name = name,
      .time = course.clock.time(),
      .parts = parts,
      .origin = {{"title", model.title}, {"version", version()}, {"build", build_description()}}};
}

std::int64_t RunContext::windows_in(double interval) const {
  return steps_within(interval, course.clock.dt());
}

bool RunContext::ends(double interval) const {
  return interval > 0 && course.clock.window() % windows_in(interval) == 0;
}

}  // namespace trackbed::model
