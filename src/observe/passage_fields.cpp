// Field files of a track: rails, sleepers and wheels, and the ground below them.
#include <algorithm>
#include <array>

#include "observe/field_series.hpp"
#include "trackbed/observe/passage.hpp"
#include "trackbed/track/rail.hpp"

namespace trackbed::observe {

namespace {

class PassageShapes {
 public:
  PassageShapes(const track::Passage& passage, const track::Train& train, const TrackShape& shape)
      : passage_(passage), line_(passage.line()), train_(train), shape_(shape) {}

  io::Grid rails_and_wheels() const {
    return observe::rails_and_wheels(
        passage_, train_,
        {.origin = shape_.origin,
         .wheel_radius = shape_.wheel_radius,
         .level = rail_level(),
         .across = [this](std::size_t side) { return y_of_rail(side); }});
  }

  // Boxes of six faces, which follow the two ends of a sleeper.
  io::Grid sleepers() const {
    io::Grid grid;
    io::FieldData number{"surface", {"-", "number of the sleeper"}, 1, {}},
        part{"part", {"-", "2: sleeper"}, 1, {}},
        moved{"displacement", {"m", "x y z, contained in the shape"}, 3, {}};
    for (std::size_t i = 0; i < line_.sleepers(); ++i) {
      const auto first = static_cast<std::int64_t>(grid.points.size());
      for (const Vec3& corner : box_of(i)) {
        const double up = displacement(i, corner.y());
        grid.points.emplace_back(corner.x(), corner.y(), corner.z() + up);
        moved.values.insert(moved.values.end(), {0, 0, up});
      }
      constexpr std::array<std::array<int, 4>, 6> faces{
          {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
      for (const auto& face : faces) {
        std::array<std::int64_t, 4> nodes{};
        for (std::size_t k = 0; k < 4; ++k) nodes[k] = first + face[k];
        grid.add(io::CellKind::quad, nodes);
        number.values.push_back(static_cast<double>(i)), part.values.push_back(2);
      }
    }
    grid.point_data = {std::move(moved)};
    grid.cell_data = {std::move(number), std::move(part)};
    return grid;
  }

 private:
  double rail_level() const {
    return (line_.sleepers() > 0 ? shape_.height : 0) + track::drawn_rail_height;
  }
  double y_of_rail(std::size_t side) const {
    return line_.sides() == 1 ? shape_.y : shape_.y + (side == 0 ? 0.5 : -0.5) * line_.gauge();
  }
  // Corners at rest: bit 0 of the number is the end along x, bit 1 along y, bit 2 along z.
  std::array<Vec3, 8> box_of(std::size_t i) const {
    std::array<Vec3, 8> corners;
    const double x = shape_.origin + line_.sleeper_x(i);
    for (int k = 0; k < 8; ++k)
      corners.at(static_cast<std::size_t>(k)) = {
          x + ((k & 1) == 0 ? -0.5 : 0.5) * shape_.width,
          shape_.y + ((k & 2) == 0 ? -0.5 : 0.5) * shape_.length, (k & 4) == 0 ? 0 : shape_.height};
    return corners;
  }
  // m, upwards, of sleeper i at y; straight between and beyond the points below both rails.
  double displacement(std::size_t i, double y) const {
    const auto below = [&](std::size_t side) {
      return passage_.line_motion().displacement[line_.sleeper_unknown(i, side)];
    };
    if (line_.sides() == 1) return below(0);
    const double left = (y - y_of_rail(1)) / (y_of_rail(0) - y_of_rail(1));
    return left * below(0) + (1 - left) * below(1);
  }

  const track::Passage& passage_;
  const track::Line& line_;
  const track::Train& train_;
  const TrackShape& shape_;
};

}  // namespace

void write_fields(const par::Comm& comm, const FieldFiles& files, const track::Passage& passage,
                  const track::Train& train, const TrackShape& shape, const fem::Ground* ground) {
  FieldSeries series(comm, files);
  const PassageShapes shapes(passage, train, shape);
  if (ground) series.write("ground", [&] { return ground->fields(); });
  if (passage.line().sleepers() > 0)
    series.write_on_root("surfaces", [&] { return shapes.sleepers(); });
  series.write_on_root("train", [&] { return shapes.rails_and_wheels(); });
}

}  // namespace trackbed::observe
