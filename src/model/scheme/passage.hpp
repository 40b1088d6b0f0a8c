// A track alone, or on a ground, over which a train passes: one stage, whose windows are the steps
// of the track. Every rank computes the same track from the same input; more ranks are useful only
// with a ground, which is distributed over them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/coupling/track_built.hpp"
#include "model/coupling/wheel_extremes.hpp"
#include "trackbed/model/scheme.hpp"
#include "trackbed/observe/passage.hpp"

namespace trackbed::model {

class PassageScheme final : public Scheme {
 public:
  explicit PassageScheme(RunContext& run);

  std::size_t stages() const override { return 1; }
  std::string stage() const override { return "passage"; }
  double duration_of_later_stages() const override { return 0; }
  void start() override {}
  bool begin_stage() override;
  void advance() override;
  std::string problem() override;
  bool agrees_in_every_window() const override { return false; }
  bool is_done() const override { return false; }
  void record() override;
  Status status() override;
  void end_stage() override;
  bool keeps_stages() const override { return false; }
  void flush() override;
  std::string rescue() noexcept override;
  std::vector<std::string> warnings_at_end() override;
  void summarize(nlohmann::ordered_json& summary) override;
  void archive(io::Archive& a) override;
  void resume(const io::File&, const std::string&) override {}

 private:
  Clock clock() const;  // at the start
  void record_step();
  void sample();
  void write_fields();
  observe::PassageEnergies energies() const;

  RunContext& run_;
  TrackAssembly whole_;
  BuiltTrack built_;
  observe::Sensors sensors_;  // in the ground
  observe::PassageHistories histories_;
  WheelExtremes wheels_;
};

}  // namespace trackbed::model
