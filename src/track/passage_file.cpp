// A passage to a checkpoint and back.
// Stored is what the next step begins with and the deck does not give: motion of track and train,
// and where Newton's method begins (its last bits depend on that). Matrices and the columns of
// stops are made again from the deck, with the same bits.
#include <algorithm>
#include <array>

#include "passage_room.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

namespace {

// The state, listed once. `of` gives its numbers; how many follows from the model.
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
    throw RunError(path + " belongs to another track or train");
  std::copy(values.begin(), values.end(), to.data());
}

}  // namespace

// Approaches, then what stops and seats had at the end of the last step. Stops first seen by a
// later version would go to the end.
void Passage::save(io::File& file, const std::string& group, const par::Comm& comm) const {
  Room& room = *room_;
  for (const Item& item : motion_items)
    write(file, group + "/" + item.name, item.of(room.track, room.vehicles),
          {item.unit, item.meaning}, comm.root());
  write(file, group + "/approach", room.approach, {"m", "of wheels and rail, then of stops"},
        comm.root());
  write(file, group + "/stop_rate", room.stop_rate,
        {"m/s", "of the stops' approach, without what moved seats add"}, comm.root());
  std::vector<double> seats;
  for (const Seat& seat : room.seats) seats.insert(seats.end(), {seat.height, seat.rate});
  file.write<double>(group + "/seats", std::span(seats).first(comm.root() ? seats.size() : 0), 2,
                     {"m, m/s", "height of the sleepers since the rail was laid, and its rate"});
  const std::vector<std::int64_t> counts{room.steps, room.iterations, room.lost};
  file.write<std::int64_t>(group + "/counts",
                           std::span(counts).first(comm.root() ? counts.size() : 0), 1,
                           {"-",
                            "steps since the train was sent, steps of Newton's method, steps of "
                            "wheels off the rail"});
}

// What a step leaves behind twice is stored once: the stops' approach is also that before the next.
void Passage::load(const io::File& file, const std::string& group) {
  Room& room = *room_;
  for (const Item& item : motion_items)
    read(file, group + "/" + item.name, item.of(room.track, room.vehicles));
  read(file, group + "/approach", room.approach);
  read(file, group + "/stop_rate", room.stop_rate);
  const std::vector<double> seats = file.read_all<double>(group + "/seats");
  const auto counts = file.read_all<std::int64_t>(group + "/counts");
  if (seats.size() != 2 * room.seats.size() || counts.size() != 3)
    throw RunError(group + " belongs to another track");
  for (std::size_t k = 0; k < room.seats.size(); ++k)
    room.seats[k] = {seats[2 * k], seats[2 * k + 1]};
  for (Eigen::Index k = 0; k < room.stop_before.size(); ++k)
    room.stop_before[k] = room.own_approach(k);
  room.steps = counts[0], room.iterations = counts[1], room.lost = counts[2];
}

}  // namespace trackbed::track
