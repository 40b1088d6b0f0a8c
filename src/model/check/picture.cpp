// SVG 1.1 (W3C 2011): text that every browser shows and that can be edited.
#include "model/check/picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace trackbed::model {

namespace {

// Pixels. A long model fills the width, a high one the height.
constexpr double widest = 1500, highest = 700, margin = 60, line_height = 18;
constexpr double ticks_wanted = 12;

std::string escaped(const std::string& words) {
  std::string out;
  for (const char c : words) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else
      out += c;
  }
  return out;
}

constexpr double letter = 7;  // pixels, mean width of a letter of 13 pixels

// 1, 2 or 5 times a power of ten, m.
double tick_distance(double length) {
  const double rough = length / ticks_wanted, power = std::pow(10, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= rough) return factor * power;
  return 10 * power;
}

// Multiples of `step` from low to high, m.
std::vector<double> ticks(double low, double high, double step) {
  std::vector<double> found;
  for (double k = std::ceil(low / step); k * step <= high; ++k)
    found.push_back(k * step + 0.0);  // no minus zero
  return found;
}

std::string styled(const Paint& paint) {
  return fmt::format(R"(fill="{}" fill-opacity="{:g}" stroke="{}" stroke-width="{:g}")", paint.fill,
                     paint.opacity, paint.line, paint.width);
}

std::string label(double x, double y, const char* anchor, const std::string& words) {
  return fmt::format(
      R"(<text x="{:.1f}" y="{:.1f}" text-anchor="{}" paint-order="stroke" stroke="white")"
      R"( stroke-width="3">{}</text>)"
      "\n",
      x, y, anchor, escaped(words));
}

}  // namespace

// Extent, m, and pixels per metre.
struct Picture::View {
  Point2 low, high;
  double scale;
  double x(double along) const { return margin + (along - low.x) * scale; }
  double y(double height) const { return 2 * line_height + (high.z - height) * scale; }
  double right() const { return x(high.x) + margin; }
  double bottom() const { return y(low.z) + margin; }
};

void Picture::polygon(std::vector<Point2> corners, const Paint& paint) {
  parts_.push_back({Kind::polygon, std::move(corners), 0, paint});
}

void Picture::rectangle(Point2 low, Point2 high, const Paint& paint) {
  polygon({low, {high.x, low.z}, high, {low.x, high.z}}, paint);
}

void Picture::line(std::vector<Point2> points, const Paint& paint) {
  parts_.push_back({Kind::line, std::move(points), 0, paint});
}

void Picture::circle(Point2 centre, double radius, const Paint& paint) {
  parts_.push_back({Kind::circle, {centre}, radius, paint});
}

void Picture::text(Point2 at, const std::string& words, Anchor anchor, double below) {
  parts_.push_back({Kind::text, {at}, below, {}, words, anchor});
}

void Picture::name(Point2 at, Point2 size, const std::string& words, Anchor anchor) {
  parts_.push_back({Kind::name, {at}, 4, {}, words, anchor, size});
}

Picture::View Picture::view() const {
  constexpr double far = std::numeric_limits<double>::infinity();
  Point2 low{far, far}, high{-far, -far};
  for (const Part& part : parts_)
    for (const Point2& p : part.points) {
      const double reach = part.kind == Kind::circle ? part.size : 0;
      low = {std::min(low.x, p.x - reach), std::min(low.z, p.z - reach)};
      high = {std::max(high.x, p.x + reach), std::max(high.z, p.z + reach)};
    }
  if (parts_.empty()) low = {0, 0}, high = {1, 1};
  // A part without height or length, as a rail alone, still has a picture.
  const double least = std::max({high.x - low.x, high.z - low.z, 1e-9}) / 20;
  if (high.x - low.x < least) high.x = low.x + least;
  if (high.z - low.z < least) high.z = low.z + least;
  return {low, high, std::min(widest / (high.x - low.x), highest / (high.z - low.z))};
}

std::string Picture::drawn(const Part& part, const View& view) {
  if (part.kind == Kind::text) {
    constexpr const char* anchors[] = {"start", "middle", "end"};
    double x = view.x(part.points[0].x);
    // Kept within the picture, whose axes begin at the margin.
    const double half = letter * static_cast<double>(part.words.size()) / 2;
    if (part.anchor == Anchor::middle && margin + 2 * half < view.right())
      x = std::clamp(x, margin + half, view.right() - half);
    return label(x, view.y(part.points[0].z) + part.size,
                 anchors[static_cast<std::size_t>(part.anchor)], part.words);
  }
  if (part.kind == Kind::circle)
    return fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:.2f}\" {}/>\n",
                       view.x(part.points[0].x), view.y(part.points[0].z), part.size * view.scale,
                       styled(part.paint));
  std::string points;
  for (const Point2& p : part.points)
    points += fmt::format("{:.2f},{:.2f} ", view.x(p.x), view.y(p.z));
  return fmt::format("<{} points=\"{}\" {}/>\n",
                     part.kind == Kind::polygon ? "polygon" : "polyline", points,
                     styled(part.paint));
}

std::string Picture::axes(const View& view) {
  const Paint frame{.line = "#444"};
  const double left = view.x(view.low.x) - 8, bottom = view.y(view.low.z) + 8;
  std::string out = fmt::format("<path d=\"M{0:.1f} {1:.1f} V{2:.1f} H{3:.1f}\" {4}/>\n", left,
                                view.y(view.high.z), bottom, view.x(view.high.x), styled(frame));
  const double long_side = std::max(view.high.x - view.low.x, view.high.z - view.low.z);
  const double step = tick_distance(long_side);
  for (const double x : ticks(view.low.x, view.high.x, step)) {
    out += fmt::format("<path d=\"M{0:.1f} {1:.1f} v5\" {2}/>\n", view.x(x), bottom, styled(frame));
    out += label(view.x(x), bottom + 18, "middle", fmt::format("{:.4g}", x));
  }
  const double upward = tick_distance(std::min(long_side, 3 * (view.high.z - view.low.z)));
  for (const double z : ticks(view.low.z, view.high.z, upward)) {
    out += fmt::format("<path d=\"M{0:.1f} {1:.1f} h-5\" {2}/>\n", left, view.y(z), styled(frame));
    out += label(left - 8, view.y(z) + 4, "end", fmt::format("{:.4g}", z));
  }
  out += label(view.x(view.high.x), bottom + 36, "end", "x along the track, m");
  out += label(left, view.y(view.high.z) - 8, "middle", "z, m");
  return out;
}

std::string Picture::texts(const View& view, std::vector<std::string>& notes) const {
  std::string out, list;
  int number = 0;
  for (Part part : parts_) {
    if (part.kind != Kind::text && part.kind != Kind::name) continue;
    const std::size_t end = part.words.find_last_not_of(' ') + 1;  // a space keeps off the border
    const double width = letter * static_cast<double>(part.words.size() + 1);
    if (part.kind == Kind::name && (width > part.size_of_part.x * view.scale ||
                                    line_height > part.size_of_part.z * view.scale)) {
      const std::string short_name = fmt::format("{}", ++number);
      list +=
          fmt::format("{}{}: {}", number > 1 ? "; " : "", short_name, part.words.substr(0, end));
      part.words = short_name;
    }
    part.kind = Kind::text;
    out += drawn(part, view);
  }
  if (number > 0) notes.push_back(list + ".");
  return out;
}

std::string Picture::svg() const {
  const View view = this->view();
  std::vector<std::string> notes = notes_;
  const std::string texts = this->texts(view, notes);
  const double height = view.bottom() + line_height * static_cast<double>(notes.size() + 1);
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "viewBox=\"0 0 {0:.0f} {1:.0f}\" font-family=\"sans-serif\" font-size=\"13\">\n"
      "<title>{2}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      std::max(view.right(), 640.0), height, escaped(title_));
  out += label(margin, line_height - 2, "start", title_);
  for (const Part& part : parts_)
    if (part.kind != Kind::text && part.kind != Kind::name) out += drawn(part, view);
  out += texts + axes(view);  // no body hides a text
  double y = view.bottom();
  for (const std::string& note : notes) out += label(margin, y += line_height, "start", note);
  return out + "</svg>\n";
}

}  // namespace trackbed::model
