// Checkpoints of sleepers.
// Rank 0 writes the state, which is identical on all ranks; all ranks read it, so that a run
// resumes on any number of ranks. Shape and mass are not stored: they follow from the deck in the
// same file.
#include <algorithm>
#include <array>

#include "track/sleepers/impl.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

namespace {

// The state of one sleeper, listed once: content of a checkpoint.
struct Item {
  const char *name, *unit, *meaning;
  std::size_t columns;
  double* (*of)(Body&);
};
constexpr std::array state_items{
    Item{"displacement", "m", "of the centre since it was placed", 3,
         [](Body& b) { return b.displacement.data(); }},
    Item{"velocity", "m/s", "of the centre, at mid-window", 3,
         [](Body& b) { return b.velocity.data(); }},
    Item{"acceleration", "m/s^2", "of the centre, at the start of the last window", 3,
         [](Body& b) { return b.acceleration.data(); }},
    Item{"attitude", "-", "quaternion x y z w", 4,
         [](Body& b) { return b.attitude.coeffs().data(); }},
    Item{"spin", "rad/s", "in space axes, at mid-window", 3, [](Body& b) { return b.spin.data(); }},
    Item{"turning", "rad/s^2", "in space axes, at the start of the last window", 3,
         [](Body& b) { return b.turning.data(); }},
    Item{"reaction", "N", "from stones in the last window", 3,
         [](Body& b) { return b.reaction.data(); }},
};

}  // namespace

// Collective, as is `load`.
void RigidSleepers::save(io::File& file, const std::string& group, const par::Comm& comm) const {
  std::vector<Body> written;
  if (comm.root()) written = impl_->bodies;
  for (const Item& item : state_items) {
    std::vector<double> rows;
    for (Body& body : written) rows.insert(rows.end(), item.of(body), item.of(body) + item.columns);
    file.write<double>(group + "/" + item.name, rows, item.columns, {item.unit, item.meaning});
  }
  std::vector<double> common;
  if (comm.root()) common = {impl_->placed ? 1.0 : 0.0, impl_->bottom, impl_->last_step};
  file.write<double>(group + "/common", common, 1,
                     {"-, m, s", "placed (0 or 1), height of the lower face (m), last window (s)"});
}

// A different number of sleepers is refused here although compatible.cpp compares the decks first:
// a file may be damaged where the deck is not.
void RigidSleepers::load(const io::File& file, const std::string& group) {
  const auto common = file.read_all<double>(group + "/common");
  if (common.size() != 3) throw RunError(group + "/common does not contain the state of sleepers");
  place(common[1]);
  impl_->placed = common[0] != 0;
  impl_->last_step = common[2];
  for (const Item& item : state_items) {
    // Files of versions without two rails do not contain it; it is not used there and starts at 0.
    if (item.name == std::string("turning") && !file.has(group + "/turning")) continue;
    const auto rows = file.read_all<double>(group + "/" + item.name);
    if (rows.size() != item.columns * count())
      throw RunError(group + "/" + item.name + " was written for a different number of sleepers");
    auto next = rows.begin();
    for (Body& body : impl_->bodies) {
      std::copy_n(next, item.columns, item.of(body));
      next += static_cast<std::ptrdiff_t>(item.columns);
    }
  }
  impl_->show_at_rest();
}

}  // namespace trackbed::track
