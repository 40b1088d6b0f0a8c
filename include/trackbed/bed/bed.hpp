// Generation of a ballast bed: the stones and their initial positions, the walls around them and
// the platen that compacts them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "trackbed/bed/container.hpp"
#include "trackbed/bed/servo.hpp"
#include "trackbed/core/surface.hpp"
#include "trackbed/core/types.hpp"
#include "trackbed/dem/particles.hpp"
#include "trackbed/geom/stone.hpp"
#include "trackbed/input/section.hpp"
#include "trackbed/io/archive.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::bed {

// Disk or sphere; plane outline of disks; clump of given spheres, or of spheres that fill a
// polyhedron; rounded polyhedra; the same in convex pieces; shapes of a file.
enum class StoneKind { disk, pebbles, clump, polyhedra, compound, library };

// Standards with known limits; custom: sieves and passing from the deck.
enum class GradingKind { custom, en13450_a, china_special, china_first, as2758_60 };

// Per cent of the mass that may pass each sieve; empty for custom. EN 13450:2002, category A, and
// the Chinese special class, which has the same limits; Chinese first class for new lines; AS
// 2758.7 nominal 60, from memory, not verified against the standard.
struct GradingLimits {
  std::vector<double> sieve, low, high;  // mm, %, %
};
const GradingLimits& limits_of(GradingKind kind);

// Irregular convex stones in space; see geom::StoneShape.
struct PolyhedronParameters {
  std::int64_t vertices = 24;
  double elongation = 0.85, flatness = 0.65, spread = 0, angularity = 1;
  double rounding = 0.05;              // radius over the diameter of the sphere of equal volume
  std::int64_t pieces = 3;             // compound
  std::vector<double> spheres{5, 10};  // fewest and most, clump
  void declare(input::Section& s);
  bool operator==(const PolyhedronParameters&) const = default;
};

// Stones of one layer of the bed, and their amount.
struct LayerParameters {
  StoneKind stone = StoneKind::pebbles;
  std::string material = "ballast";
  double height = 0.5;    // m, required after compaction (determines the bulk area or volume)
  double porosity = 0.4;  // expected after compaction, sets the number of stones
  GradingKind grading = GradingKind::custom;
  std::vector<double> sieve = {22.4, 31.5, 40, 50, 63};  // mm, linear in log(size) in between
  std::vector<double> passing = {0, 13, 47.5, 85, 100};  // per cent by mass
  double pebble_radius = 0.004;                          // m, of the disks of a plane stone
  double pebble_spacing = 2;                             // radii
  std::int64_t shapes = 24;                              // number of different shapes
  double elongation = 0.7, angularity = 0.3;
  std::vector<double> clump;  // x y z r of each sphere at unit scale; none: filled polyhedra
  PolyhedronParameters polyhedron;
  std::string library;  // file of shapes (library.hpp)
  std::int64_t seed = 1;
  void declare(input::Section& s);
  // Per sieve: opening in m, specified passing, lowest and highest allowed in % (custom: as
  // specified).
  std::vector<double> grading_table() const;
};

// A layer other than the uppermost one, for stages that name it.
struct NamedLayer : LayerParameters {
  std::string name;
  void declare(input::Section& s);
};

// The uppermost layer, and the parameters common to all layers.
struct BedParameters : LayerParameters {
  std::vector<double> x = {0, 6};       // m, between the end walls (or the periodic cell)
  std::vector<double> y = {-0.5, 0.5};  // m, space models
  std::vector<double> crest;            // m, y of the ends of the level top; none: level everywhere
  double slope = 1.5;                   // run over rise beyond the crest
  ContainerKind container = ContainerKind::box;
  double split = 0, beside = 0;  // m, see Container
  std::string cell;              // checkpoint whose stones are repeated along x instead of new ones
  std::vector<NamedLayer> layers;
  std::string section = "bed";  // of the deck, for messages; bed.layer.NAME with of_layer
  void declare(input::Section& s);
  // m, height of the bed at y if its crest is at height `top`.
  double top_at(double y, double top) const;
  // The container of this bed; periodic sides are those of the domain.
  Container container_in(const dem::Domain& domain) const;
  // The bed with the parameters of that layer; of the uppermost one if `name` is empty.
  BedParameters of_layer(const std::string& name) const;
};

// Adds templates and loose columns of non-overlapping stones above z = `foot` to `particles`. Ids
// increase from left to right and upwards and follow the highest existing one. The stones do not
// depend on the number of ranks. Returns the height they reach (m). Throws InputError for
// incompatible parameters, RunError if that height is beyond the domain (stones_of predicts it).
// Collective.
double fill(dem::Particles& particles, const par::Comm& comm, const BedParameters& parameters,
            int material, double foot = 0);
// The same stones, scaled down by the factor with which their loose columns are about
// `height_ratio` times as high as the bed; they are to be grown (Particles::grow_to). Collective.
double fill_to_grow(dem::Particles& particles, const par::Comm& comm,
                    const BedParameters& parameters, int material, double foot,
                    double height_ratio);

struct Box {
  Vec3 low, high;  // m; plane: y is not used
};

// Adds stones of the same kind for `boxes`, as many as fill each at `parameters.porosity`, in loose
// columns above z = `foot` that do not overlap each other; a box narrower than a stone gets none.
// Their ids follow the highest existing one. The stones do not depend on the number of ranks.
// Returns the height they reach (m). Throws RunError if that is beyond the domain. Collective.
double fill_boxes(dem::Particles& particles, const par::Comm& comm, const BedParameters& parameters,
                  int material, std::span<const Box> boxes, double foot);
// Properties of the stones that `fill` will generate. Throws InputError if they cannot be
// generated. Collective.
struct Stones {
  std::int64_t count = 0;
  double smallest_volume = 0;  // m^3; plane: m^2
  double largest_bound = 0;    // m, radius of the largest bounding sphere
  double longest = 0;          // m, largest extent of any stone
  double top = 0;  // m, height of the loose columns above their foot; of 1024 of them, if more
};
Stones stones_of(const par::Comm& comm, const BedParameters& parameters, const dem::Domain& domain);

struct PlatenParameters : ServoParameters {
  double pressure = 200e3;  // Pa
  double vibration = 0;     // m, amplitude of a sine added to the servo's motion
  double frequency = 30;    // Hz, of the vibration
  void declare(input::Section& s);
};

// A rigid plate that a servo loads to a given pressure on the bed.
class Platen {
 public:
  Platen(const PlatenParameters& parameters, const Container& container, int material);
  Platen(const PlatenParameters& parameters, const dem::Domain& domain, int material)
      : Platen(parameters, Container(domain), material) {}
  Surface& surface();
  // Sets the target pressure, Pa; it has to become steady again. `integral`: the servo has an
  // integral term, for a bed that sinks or rises continuously, for instance under shear.
  void set_target(double pressure, bool integral = false);
  void place(double z);                      // at rest, its lower face at z
  void advance(double dt, double force_up);  // measured force from stones in the last window, N
  void drive(double dt, double down, double force_up);  // by a given displacement, m
  void set_area(double area);  // m^2, of the bed below it, which changes with moving walls
  double pressure() const;     // Pa, averaged
  double z() const;
  bool steady() const;            // averaged pressure within the tolerance for the time `hold`
  std::string shortfall() const;  // why it is not steady; empty if it is

  void archive(io::Archive& a);

 private:
  void set_motion(double motion);
  double vibration_increment(double dt);

  PlatenParameters parameters_;
  Surface surface_;
  double area_;  // m^2
  bool integral_ = false;
  Servo servo_;
  double z_ = 0, vibration_time_ = 0;  // m; s, since the vibration began
};

}  // namespace trackbed::bed
