// A picture in the plane of x (along the track) and z, m, as SVG: parts are added in the units of
// the model, and the scale follows from all of them.
#pragma once

#include <string>
#include <vector>

namespace trackbed::model {

struct Point2 {
  double x, z;  // m
};

// How a part is drawn; colours as in CSS.
struct Paint {
  const char* fill = "none";
  const char* line = "none";
  double width = 1;    // pixels, of the line
  double opacity = 1;  // of the fill
};

enum class Anchor { start, middle, end };

class Picture {
 public:
  explicit Picture(std::string title) : title_(std::move(title)) {}

  void polygon(std::vector<Point2> corners, const Paint& paint);
  void rectangle(Point2 low, Point2 high, const Paint& paint);
  void line(std::vector<Point2> points, const Paint& paint);
  void circle(Point2 centre, double radius, const Paint& paint);  // radius: m
  // `below`: pixels by which the text is moved down.
  void text(Point2 at, const std::string& words, Anchor anchor = Anchor::middle, double below = 0);
  // The name of a part, in its middle or at an end of it; of a part that is too small for it a
  // number, which is explained below the axes. `size`: m, of the part.
  void name(Point2 at, Point2 size, const std::string& words, Anchor anchor = Anchor::middle);
  // One sentence below the axes.
  void note(const std::string& sentence) { notes_.push_back(sentence); }

  // The file's contents, with axes in metres.
  std::string svg() const;

 private:
  enum class Kind { polygon, line, circle, text, name };
  struct Part {
    Kind kind;
    std::vector<Point2> points;  // of names: the place only
    double size;                 // m, radius; of texts: pixels downwards
    Paint paint;
    std::string words = {};
    Anchor anchor = Anchor::middle;
    Point2 size_of_part = {0, 0};  // m, of names
  };
  struct View;
  View view() const;
  static std::string drawn(const Part& part, const View& view);
  // The texts; adds names that do not fit to `notes`.
  std::string texts(const View& view, std::vector<std::string>& notes) const;
  static std::string axes(const View& view);

  std::string title_;
  std::vector<Part> parts_;
  std::vector<std::string> notes_;
};

}  // namespace trackbed::model
