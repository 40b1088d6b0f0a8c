#include "trackbed/model/course.hpp"

namespace trackbed::model {

namespace {

// One column of the table of finished stages.
struct Column {
  const char* name;
  double StageRecord::*value;
  io::Label label;
};

const Column columns[] = {
    {"time", &StageRecord::time, {"s", "end of each finished stage"}},
    {"duration", &StageRecord::duration, {"s", "simulated time of each stage"}},
    {"window", &StageRecord::window, {"s", "length of a window"}},
    {"substeps", &StageRecord::substeps, {"-", "sub-steps in a window"}},
    {"particles", &StageRecord::particles, {"-", "at the end of each stage"}},
    {"bulk_density",
     &StageRecord::bulk_density,
     {"kg/m^3", "at the end of each stage; 0: not defined"}},
    {"wall_time", &StageRecord::wall_time, {"s", "wall time of each stage"}},
    {"aim", &StageRecord::aim, {"-", "0: the stage has no aim, 1: missed, 2: reached"}},
    {"platen_pressure", &StageRecord::platen_pressure, {"Pa", "mean; below 0: no platen"}},
    {"settlement", &StageRecord::settlement, {"m", "in the last cycle; below 0: no cycles"}},
    {"stable_step",
     &StageRecord::stable_step,
     {"s",
      "longest sub-step up to that of the stage that contacts at its end allow; 0: no stones"}}};

void archive_records(io::Archive& a, std::vector<StageRecord>& records) {
  std::vector<std::string> names;
  for (const StageRecord& record : records) names.push_back(record.name);
  a("stages/name", names, {"-", "finished stages"});
  records.resize(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) records[i].name = names[i];
  for (const Column& column : columns) {
    std::vector<double> values;
    for (const StageRecord& record : records) values.push_back(record.*column.value);
    a(std::string("stages/") + column.name, values, column.label);
    for (std::size_t i = 0; i < records.size(); ++i) records[i].*column.value = values.at(i);
  }
}

}  // namespace

void Course::archive(io::Archive& a) {
  double start = clock.start();
  std::int64_t window = clock.window(), all = clock.windows();
  a("stage", stage, {"-", "present stage, counted from 0"});
  a("stage_has_begun", begun, {"-", "1: the stage has begun; 0: it is finished"});
  a("stage_start", start, {"s", "start of the stage"});
  a("window", steps.window, {"s", "length of a window"});
  a("substeps", steps.substeps, {"-", "sub-steps in a window"});
  a("windows_of_stage", window, {"-", "windows of the stage that are done"});
  a("windows_in_stage", all, {"-", "windows of the stage, at most"});
  a("windows", windows, {"-", "windows of the run that are done"});
  a("warnings", warnings, {"-", "warnings of the run, UTF-8, each with a line feed"});
  a("wall_time", earlier_wall_time, {"s", "wall time of all parts of the run up to here"});
  archive_records(a, done);
  if (!a.reads()) return;
  clock = Clock(steps.window, all);
  clock.set(start, window);
}

Course course_in(const io::File& checkpoint) {
  Course course;
  io::Archive::reader(checkpoint).part("run", course);
  return course;
}

}  // namespace trackbed::model
