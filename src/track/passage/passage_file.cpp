// The state at the start of the next step: motion of track and train, and the initial approaches of
// Newton's method (its last bits depend on them). Matrices and the columns of stops are computed
// again from the deck, bitwise identical; `stop_before` follows from the stops' approach.
#include "track/passage/passage_impl.hpp"

namespace trackbed::track {

void Passage::archive(io::Archive& a) {
  Impl& impl = *impl_;
  Newmark &track = impl.track, &train = impl.vehicles;
  a("track_displacement", track.displacement, {"m, rad", "of rail nodes and sleepers on springs"});
  a("track_velocity", track.velocity, {"m/s, rad/s", "of rail nodes and sleepers on springs"});
  a("track_acceleration", track.acceleration,
    {"m/s^2, rad/s^2", "of rail nodes and sleepers on springs"});
  a("train_displacement", train.displacement, {"m, rad", "of the vehicles' bodies"});
  a("train_velocity", train.velocity, {"m/s, rad/s", "of the vehicles' bodies"});
  a("train_acceleration", train.acceleration, {"m/s^2, rad/s^2", "of the vehicles' bodies"});
  a("approach", impl.approach,
    {"m",
     "compression of the wheel-rail contacts, followed by that of the one-sided springs (gaps, "
     "bilinear pads, pads with uplift)"});
  a("stop_rate", impl.stop_rate,
    {"m/s",
     "rate of compression of the one-sided springs, without the part due to prescribed seat "
     "motion"});
  a.rows("seat_height", impl.seats,
         {"m", "displacement of each moved seat since the rail was laid"}, &Seat::height);
  a.rows("seat_rate", impl.seats, {"m/s", "velocity of each moved seat"}, &Seat::rate);
  a("steps", impl.steps, {"-", "since the train started"});
  a("iterations", impl.iterations, {"-", "of Newton's method up to now"});
  a("lost", impl.lost, {"-", "steps without wheel-rail contact, summed over the wheels"});
  if (!a.reads()) return;
  for (Eigen::Index k = 0; k < impl.stop_before.size(); ++k)
    impl.stop_before[k] = impl.own_approach(k);
}

}  // namespace trackbed::track
