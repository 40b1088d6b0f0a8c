// Histories of stones and surfaces that a deck places by name: the values that a row adds to the
// columns.
#include "observe/column_writer.hpp"
#include "observe/impl.hpp"

namespace trackbed::observe {

namespace {

void put(ColumnWriter& to, const StoneInstant& stone) {
  const std::string group = "history/stone/" + stone.name + "/";
  to.put(group + "position", {"m", "x y z of the centre of mass"}, stone.position);
  to.put(group + "attitude",
         {"-", "quaternion x y z w from the axes of the shape in the deck to space"},
         std::span<const double>(stone.attitude.coeffs().data(), 4));
  to.put(group + "velocity", {"m/s", "x y z, of the centre of mass"}, stone.velocity);
  to.put(group + "spin", {"rad/s", "angular velocity, x y z"}, stone.spin);
  to.put(group + "momentum", {"kg m/s", "x y z"}, stone.momentum);
  to.put(group + "angular_momentum", {"kg m2/s", "about the centre of mass, x y z"},
         stone.angular_momentum);
  to.put(group + "force", {"N", "of all contacts of the stone, x y z, without gravity"},
         stone.force);
  to.put(group + "torque", {"N m", "of all contacts of the stone about its centre of mass, x y z"},
         stone.torque);
  to.put(group + "impulse", {"N s", "of the contact force since the start of the run, x y z"},
         stone.impulse);
  to.put(group + "peak_force",
         {"N", "largest magnitude of the contact force since the start of the run"},
         stone.peak_force);
  to.put(group + "contacts", {"-", "number of contacts of the stone's pieces"},
         static_cast<double>(stone.contacts));
}

void put(ColumnWriter& to, const SurfaceInstant& surface) {
  const std::string group = "history/surface/" + surface.name + "/";
  to.put(group + "force", {"N", "of the stones, x y z, mean of the last window"}, surface.force);
  to.put(group + "displacement", {"m", "x y z, since time 0"}, surface.displacement);
  to.put(group + "impulse", {"N s", "of the stones' force since the start of the run, x y z"},
         surface.impulse);
  to.put(group + "peak_force",
         {"N", "largest magnitude of the stones' force since the start of the run"},
         surface.peak_force);
}

}  // namespace

void Results::Impl::sample_placed(const PlacedInstant& instant) {
  ColumnWriter to(placed);
  to.put("history/energy/translational", {"J", "kinetic, of the stones' centres of mass"},
         instant.translational);
  to.put("history/energy/rotational", {"J", "kinetic, about the stones' centres of mass"},
         instant.rotational);
  to.put("history/energy/supplied",
         {"J", "work of driven surfaces and stones on the others since the start of the run"},
         instant.supplied);
  to.put("history/energy/dissipated",
         {"J", "initial plus supplied minus present energy: friction, dampers"},
         instant.dissipated);
  to.put("history/total/momentum", {"kg m/s", "of all stones, x y z"}, instant.momentum);
  to.put("history/total/angular_momentum", {"kg m2/s", "of all stones about the origin, x y z"},
         instant.angular_momentum);
  to.put("history/total/contacts", {"-", "of pieces of stones with each other and with surfaces"},
         static_cast<double>(instant.contacts));
  for (const StoneInstant& stone : instant.stones) put(to, stone);
  for (const SurfaceInstant& surface : instant.surfaces) put(to, surface);
}

}  // namespace trackbed::observe
