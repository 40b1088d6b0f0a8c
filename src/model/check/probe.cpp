// Windows are repeated until they have taken `enough`, so that a large model is measured in one or
// two. The first window sets up neighbour lists, or matrices, and is not counted.
#include "model/check/probe.hpp"

#include <algorithm>
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
    world.comm.agree(world.particles.trouble());
    world.comm.agree(world.coupler.trouble());
  });
}

double measured_window_of_ground(World& world, double window) {
  std::vector<Vec3> load(world.ground->top().nodes(), Vec3::Zero());
  double newtons = 1;  // changes from window to window, so that an implicit step has to iterate
  return mean_time_of(world.comm, [&] {
    std::fill(load.begin(), load.end(), Vec3(0, 0, -newtons));
    newtons = newtons < 2 ? 1.01 * newtons : 1;
    world.ground->advance(window, load);
  });
}

}  // namespace trackbed::model
