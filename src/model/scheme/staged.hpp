// A bed, placed stones or a ground alone, in stages: in each window track, ground and stones
// advance one after the other.
#pragma once

#include <string>
#include <vector>

#include "model/scene/world.hpp"
#include "model/scheme/staged_figures.hpp"
#include "model/stages/stages.hpp"
#include "trackbed/model/scheme.hpp"
#include "trackbed/observe/results.hpp"

namespace trackbed::model {

class StagedScheme final : public Scheme {
 public:
  StagedScheme(RunContext& run, const std::vector<bed::PlacedShape>& shapes);

  std::size_t stages() const override { return model_.stages.size(); }
  std::string stage() const override { return present().name; }
  double duration_of_later_stages() const override;
  void start() override;
  bool begin_stage() override;
  void advance() override;
  std::string problem() override;
  bool agrees_in_every_window() const override { return true; }
  bool is_done() const override { return actions_.settled(present(), run_.course.clock); }
  void record() override;
  Status status() override;
  void end_stage() override;
  bool keeps_stages() const override { return true; }
  void flush() override { results_.flush(); }
  std::string rescue() noexcept override;
  void finish() override;
  std::vector<std::string> warnings_at_end() override;
  void summarize(nlohmann::ordered_json& summary) override;
  void archive(io::Archive& a) override;
  void resume(const io::File& file, const std::string& histories) override;

 private:
  void move_sleepers(double dt);
  void move_solids(double dt);
  void move_platen(double dt);
  void move_ground(double dt);
  void load_ground(double dt);
  void move_stones(double dt);
  void average_support(double dt);

  const Stage& present() const { return model_.stages[run_.course.stage]; }
  double begin_of_window() const;   // s, since the stage began
  double middle_of_window() const;  // the same
  double end_of_window() const;     // the same
  bool settle_ground();
  bool is_last_passage() const;
  void judge(const StageRecord& record, const std::string& shortfall);
  void sample();
  void write_fields_of_window();
  void write_fields(const std::string& name, const std::vector<std::string>& parts);
  bool keeps_extremes() const;
  void require_still_stable() const;  // throws InputError; collective
  void archive_platen(io::Archive& a);
  void begin_extremes();
  void resume_extremes(bool kept);

  RunContext& run_;
  const par::Comm& comm_;
  const Model& model_;
  World world_;
  StageActions actions_;
  observe::Results results_;
  observe::Sensors sensors_;
  std::vector<double> seat_force_;  // N, in the last window
  std::vector<Vec3> load_;          // N, of pressures on the top, in the last window
  SpeedCounters measured_;          // counters at the start of the last stage
  double stage_begin_ = 0;          // s of wall time
};

}  // namespace trackbed::model
