// Windows are repeated until they have taken `enough`, so that a large model is measured in one or
// two. The first window sets up neighbour lists, or matrices, and is not counted.
#include "model/check/probe.hpp"

#include <chrono>
#include <vector>

namespace trackbed::model {

namespace {

constexpr double enough = 0.3;  // s
constexpr int most = 200;       // windows

// All ranks take as many windows as the slowest one needs.
double mean_time_of(const par::Comm& comm, const auto& window) {
  const auto now = std::chrono::steady_clock::now;
  const auto since = [&](const auto& start) {
    return comm.max(std::chrono::duration<double>(now() - start).count());
  };
  window();
  const auto start = now();
  double took = 0;
  int done = 0;
  while (done < most && took < enough) window(), ++done, took = since(start);
  return took / done;
}

}  // namespace

double measured_window_of_stones(World& world, const Steps& steps) {
  world.expect_weight(steps.substeps);
  return mean_time_of(world.comm, [&] {
    world.coupler.publish();
    world.particles.advance(steps.window, steps.substeps);
    const dem::SurfaceAction& did = world.particles.surface_action();
    world.coupler.collect(steps.substeps, steps.window, {did.force, did.moment, did.work});
    world.particles.expect_load(world.coupler.largest_load());
  });
}

double measured_window_of_ground(World& world, double window) {
  const std::vector<Vec3> load(world.ground->top().nodes(), Vec3::Zero());
  return mean_time_of(world.comm, [&] { world.ground->advance(window, load); });
}

}  // namespace trackbed::model
