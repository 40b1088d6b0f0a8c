// The stones of a bed: their templates and the frequency of each.
#pragma once

#include <vector>

#include "grading.hpp"
#include "trackbed/bed/bed.hpp"

namespace trackbed::bed {

struct Draw {
  int shape;  // index into Mix::templates
  double scale;
};

// Templates of the file of shapes for stones of kind library; none for other kinds. Throws
// InputError if it is not a library. Collective.
std::vector<dem::Template> library_of(const par::Comm& comm, const BedParameters& parameters);

// Local and constant: a draw depends on its number alone.
class Mix {
 public:
  // `library`: the stones of kind library, else not used. Throws InputError if the stones cannot be
  // generated.
  Mix(const BedParameters& parameters, Dimension dimension,
      std::vector<dem::Template> library = {});

  const std::vector<dem::Template>& templates() const { return templates_; }
  // The k-th of `count` stones, from small to large; together they have the specified grading.
  Draw draw(std::uint64_t k, std::uint64_t count) const;
  // Whether sizes ascend and shapes take turns; the shapes of a library come one after the other.
  bool ascends() const { return frequency_.empty(); }
  double bound(const Draw& draw) const;   // m, radius of the circle or sphere around the stone
  double extent(const Draw& draw) const;  // m, largest distance between two of its points
  double largest_bound() const;           // m, of all that can be drawn
  double mean_volume() const;             // m^3 (plane: m^2), number mean

 private:
  void add_outlines(const BedParameters& parameters);
  void add_scaled(const BedParameters& parameters, Dimension dimension);

  Grading grading_;
  double power_;
  std::vector<dem::Template> templates_;
  std::vector<double> bounds_;     // m at unit scale
  std::vector<double> extents_;    // likewise
  std::vector<double> frequency_;  // pebbles: cumulative fraction by number
};

}  // namespace trackbed::bed
