// Checkpoints of a passage.
// The file contains the state at the start of the next step: motion of track and train, and the
// initial approaches of Newton's method (its last bits depend on them). Matrices and the columns of
// stops are computed again from the deck, bitwise identical.
#include <algorithm>
#include <array>

#include "track/passage/passage_impl.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

namespace {

// The state, listed once. `of` returns its values; their number follows from the model.
struct Item {
  const char *name, *unit, *meaning;
  Vector& (*of)(Newmark& track, Newmark& train);
};
constexpr std::array motion_items{
    Item{"track_displacement", "m, rad", "of rail nodes and sleepers on springs",
         [](Newmark& track, Newmark&) -> Vector& { return track.displacement; }},
    Item{"track_velocity", "m/s, rad/s", "of the same",
         [](Newmark& track, Newmark&) -> Vector& { return track.velocity; }},
    Item{"track_acceleration", "m/s^2, rad/s^2", "of the same",
         [](Newmark& track, Newmark&) -> Vector& { return track.acceleration; }},
    Item{"train_displacement", "m, rad", "of the vehicles' bodies",
         [](Newmark&, Newmark& train) -> Vector& { return train.displacement; }},
    Item{"train_velocity", "m/s, rad/s", "of the same",
         [](Newmark&, Newmark& train) -> Vector& { return train.velocity; }},
    Item{"train_acceleration", "m/s^2, rad/s^2", "of the same",
         [](Newmark&, Newmark& train) -> Vector& { return train.acceleration; }}};

void write(io::File& file, const std::string& path, const Vector& values, const io::Label& label,
           bool root) {
  const auto count = root ? static_cast<std::size_t>(values.size()) : 0;
  file.write<double>(path, std::span(values.data(), count), 1, label);
}

void read(const io::File& file, const std::string& path, Vector& to) {
  const std::vector<double> values = file.read_all<double>(path);
  if (values.size() != static_cast<std::size_t>(to.size()))
    throw RunError(path + " was written for a different track or train");
  std::copy(values.begin(), values.end(), to.data());
}

}  // namespace

// Approaches, then stops and seats at the end of the last step. New kinds of stops of a later
// version would have to be appended.
void Passage::save(io::File& file, const std::string& group, const par::Comm& comm) const {
  Impl& impl = *impl_;
  for (const Item& item : motion_items)
    write(file, group + "/" + item.name, item.of(impl.track, impl.vehicles),
          {item.unit, item.meaning}, comm.root());
  write(file, group + "/approach", impl.approach, {"m", "of wheels to the rail, then of stops"},
        comm.root());
  write(file, group + "/stop_rate", impl.stop_rate,
        {"m/s", "rate of the stops' approach, without the motion of moved seats"}, comm.root());
  std::vector<double> seats;
  for (const Seat& seat : impl.seats) seats.insert(seats.end(), {seat.height, seat.rate});
  file.write<double>(group + "/seats", std::span(seats).first(comm.root() ? seats.size() : 0), 2,
                     {"m, m/s", "height of the seats since the rail was placed, and its rate"});
  const std::vector<std::int64_t> counts{impl.steps, impl.iterations, impl.lost};
  file.write<std::int64_t>(group + "/counts",
                           std::span(counts).first(comm.root() ? counts.size() : 0), 1,
                           {"-",
                            "steps since the train started, iterations of Newton's method, steps "
                            "times wheels without contact"});
}

// stop_before is not stored: it follows from the stops' approach.
void Passage::load(const io::File& file, const std::string& group) {
  Impl& impl = *impl_;
  for (const Item& item : motion_items)
    read(file, group + "/" + item.name, item.of(impl.track, impl.vehicles));
  read(file, group + "/approach", impl.approach);
  read(file, group + "/stop_rate", impl.stop_rate);
  const std::vector<double> seats = file.read_all<double>(group + "/seats");
  const auto counts = file.read_all<std::int64_t>(group + "/counts");
  if (seats.size() != 2 * impl.seats.size() || counts.size() != 3)
    throw RunError(group + " was written for a different track");
  for (std::size_t k = 0; k < impl.seats.size(); ++k)
    impl.seats[k] = {seats[2 * k], seats[2 * k + 1]};
  for (Eigen::Index k = 0; k < impl.stop_before.size(); ++k)
    impl.stop_before[k] = impl.own_approach(k);
  impl.steps = counts[0], impl.iterations = counts[1], impl.lost = counts[2];
}

}  // namespace trackbed::track
