// The state of sleepers. Shape and mass follow from the deck.
#include "track/sleepers/impl.hpp"

namespace trackbed::track {

void RigidSleepers::archive(io::Archive& a) {
  Impl& impl = *impl_;
  std::vector<Body>& all = impl.bodies;
  a("placed", impl.placed, {"-", "1: the sleepers are in the model; else 0"});
  a("bottom", impl.bottom, {"m", "height of the lower face as placed"});
  a("last_window", impl.last_step, {"s", "length of the last window"});
  a.rows("displacement", all, {"m", "of the centre since the sleeper was placed"},
         &Body::displacement);
  a.rows("velocity", all, {"m/s", "of the centre, at mid-window"}, &Body::velocity);
  a.rows("acceleration", all, {"m/s^2", "of the centre, at the start of the last window"},
         &Body::acceleration);
  a.rows("attitude", all, {"-", "quaternion x y z w"}, &Body::attitude);
  a.rows("spin", all, {"rad/s", "in space axes, at mid-window"}, &Body::spin);
  a.rows("turning", all, {"rad/s^2", "in space axes, at the start of the last window"},
         &Body::turning);
  a.rows("reaction", all, {"N", "from stones in the last window"}, &Body::reaction);
  if (a.reads()) impl.show_at_rest();
}

}  // namespace trackbed::track
