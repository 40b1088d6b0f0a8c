// Windows are repeated until they have taken `enough`, so that a large model is measured in one or
// two.
#include "model/check/probe.hpp"

#include <algorithm>
#include <chrono>
#include <vector>

namespace trackbed::model {

// All ranks take as many windows as the slowest one needs.
double measured_time_of(const par::Comm& comm, const std::function<void()>& window) {
  constexpr double enough = 0.3;  // s
  constexpr int most = 200;       // windows
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

// A window may consist of any number of steps: of long ones a part is measured.
double measured_window_of_stones(World& world, const Steps& steps) {
  constexpr int most = 100;
  const int substeps = std::min(steps.substeps, most);
  const double part = static_cast<double>(substeps) / static_cast<double>(steps.substeps);
  world.expect_weight(substeps);
  const auto window = [&] {
    world.coupler.publish();
    world.particles.advance(part * steps.window, substeps);
    world.collect_loads(part * steps.window, substeps);
    world.comm.agree(world.particles.trouble());
    world.comm.agree(world.coupler.trouble());
  };
  return measured_time_of(world.comm, window) / part;
}

double measured_window_of_ground(World& world, double window) {
  constexpr double most = 100;  // explicit steps
  const bool steps = world.model.ground.integrator == fem::Integrator::explicit_;
  const double measured = steps ? std::min(window, most * world.ground->stable_step()) : window;
  std::vector<Vec3> load(world.ground->top().nodes(), Vec3::Zero());
  double newtons = 1;  // changes from window to window, so that an implicit step has to iterate
  const auto advance = [&] {
    std::fill(load.begin(), load.end(), Vec3(0, 0, -newtons));
    newtons = newtons < 2 ? 1.01 * newtons : 1;
    world.ground->advance(measured, load);
  };
  return measured_time_of(world.comm, advance) * (window / measured);
}

}  // namespace trackbed::model
