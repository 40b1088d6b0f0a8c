// Builds a ballast bed: which stones, where they start, the walls around them and the platen that
// compacts them.
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
#include "trackbed/io/file.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::bed {

// Disk or sphere; plane outline of disks; given spheres, or as many as fill a polyhedron; rounded
// polyhedra; the same in convex pieces; those of a file.
enum class StoneKind { disk, pebbles, clump, polyhedra, compound, library };

// Standards whose limits are known; custom: the deck gives sieves and passing.
enum class GradingKind { custom, en13450_a, china_special, china_first, as2758_60 };

// Per cent of the mass that may pass each sieve; empty for custom.
// EN 13450:2002, category A, and the Chinese special class, which has the same limits; Chinese
// first class for new lines; AS 2758.7 nominal 60, as remembered, not read in the standard.
struct GradingLimits {
  std::vector<double> sieve, low, high;  // mm, %, %
};
const GradingLimits& limits_of(GradingKind kind);

// Irregular convex stones in space; see geom::StoneShape.
struct PolyhedronParameters {
  std::int64_t vertices = 24;
  double elongation = 0.85, flatness = 0.65, spread = 0, angularity = 1;
  double rounding = 0.05;              // radius over the diameter of the ball of the same volume
  std::int64_t pieces = 3;             // compound
  std::vector<double> spheres{5, 10};  // fewest and most, clump
  void declare(input::Section& s);
  bool operator==(const PolyhedronParameters&) const = default;
};

// What a layer of the bed is made of, and how much of it there is.
struct LayerParameters {
  StoneKind stone = StoneKind::pebbles;
  std::string material = "ballast";
  double height = 0.5;    // m, wanted after compaction (bulk area/volume is set by it)
  double porosity = 0.4;  // expected after compaction, sets the number of stones
  GradingKind grading = GradingKind::custom;
  std::vector<double> sieve = {22.4, 31.5, 40, 50, 63};  // mm, linear in log(size) in between
  std::vector<double> passing = {0, 13, 47.5, 85, 100};  // per cent by mass
  double pebble_radius = 0.004;                          // m, of the disks of a plane stone
  double pebble_spacing = 2;                             // radii
  std::int64_t shapes = 24;                              // different outlines
  double elongation = 0.7, angularity = 0.3;
  std::vector<double> clump;  // x y z r of each sphere at unit scale; none: filled polyhedra
  PolyhedronParameters polyhedron;
  std::string library;  // file of shapes (library.hpp)
  std::int64_t seed = 1;
  void declare(input::Section& s);
  // Opening in m, passing as asked, lowest and highest allowed in % (custom: as asked), per sieve.
  std::vector<double> grading_table() const;
};

// Another layer than the uppermost one, for stages that name it.
struct NamedLayer : LayerParameters {
  std::string name;
  void declare(input::Section& s);
};

// The uppermost layer, and what all layers have in common.
struct BedParameters : LayerParameters {
  std::vector<double> x = {0, 6};       // m, between the end walls (or the periodic cell)
  std::vector<double> y = {-0.5, 0.5};  // m, space models
  std::vector<double> crest;            // m, y of the ends of the level top; none: level all over
  double slope = 1.5;                   // run over rise beyond the crest
  ContainerKind container = ContainerKind::box;
  double split = 0, beside = 0;  // m, see Container
  std::string cell;              // checkpoint whose stones are repeated along x instead of new ones
  std::vector<NamedLayer> layers;
  void declare(input::Section& s);
  // m, where the bed ends above y if its crest is at height `top`.
  double top_at(double y, double top) const;
  // What the walls of this bed stand around; periodic sides are the domain's.
  Container container_in(const dem::Domain& domain) const;
  // A bed of that layer alone; of the uppermost one if `name` is empty.
  BedParameters of_layer(const std::string& name) const;
};

// Adds templates and loose columns of stones that do not overlap above z = `foot` to `particles`,
// ids from left to right and upwards after the highest one there is. The same stones on any number
// of ranks. Returns the height they reach (m). Throws InputError for parameters that do not go
// together, RunError if that height is beyond the domain (stones_of tells before). Collective.
double fill(dem::Particles& particles, const par::Comm& comm, const BedParameters& parameters,
            int material, double foot = 0);
// The same stones, all of that share of their size with which loose columns of them are about
// `room` times as high as the bed is to be; they are to grow (Particles::grow_to). Collective.
double fill_to_grow(dem::Particles& particles, const par::Comm& comm,
                    const BedParameters& parameters, int material, double foot, double room);

struct Box {
  Vec3 low, high;  // m; plane: y counts for nothing
};

// Adds stones of the same kind for `boxes`, as many as fill each at `parameters.porosity`, loose in
// columns above z = `foot` that do not overlap each other; a box narrower than a stone gets none.
// Their ids follow the highest one there is. The same stones on any number of ranks. Returns the
// height they reach (m). Throws RunError if that is beyond the domain. Collective.
double fill_boxes(dem::Particles& particles, const par::Comm& comm, const BedParameters& parameters,
                  int material, std::span<const Box> boxes, double foot);
// The stones that `fill` will make, before any is there. Throws InputError if they cannot be made.
// Collective.
struct Stones {
  std::int64_t count = 0;
  double smallest_volume = 0;  // m^3; plane: m^2
  double largest_bound = 0;    // m, radius of the ball around the largest
  double longest = 0;          // m, greatest extent of any
  double top = 0;              // m, how high they reach, loose, above their foot
};
Stones stones_of(const par::Comm& comm, const BedParameters& parameters, const dem::Domain& domain);

struct PlatenParameters : ServoParameters {
  double pressure = 200e3;  // Pa
  double vibration = 0;     // m, amplitude of a sine added to the servo's motion
  double frequency = 30;    // Hz, of it
  void declare(input::Section& s);
};

// A rigid plate that a servo presses on the bed.
class Platen {
 public:
  Platen(const PlatenParameters& parameters, const Container& container, int material);
  Platen(const PlatenParameters& parameters, const dem::Domain& domain, int material)
      : Platen(parameters, Container(domain), material) {}
  Surface& surface();
  // Pa, from now on; it has to become steady anew. `follows`: for a bed that sinks or rises all the
  // time, as one that is sheared, the servo learns the speed that keeps the pressure.
  void aim(double pressure, bool follows = false);
  void place(double z);                      // at rest, its lower face at z
  void advance(double dt, double force_up);  // measured force from stones in the last window, N
  void drive(double dt, double down, double force_up);  // by that way, m, whatever the force
  void cover(double area);  // m^2, of the bed below it from now on: walls may move
  double pressure() const;  // Pa, averaged
  double z() const;
  bool steady() const;            // averaged pressure within the tolerance for the time `hold`
  std::string shortfall() const;  // a sentence on what `steady` lacks; empty if nothing

  // All ranks hold the same state; rank 0 of `comm` writes it, all read it. Collective.
  void save(io::File& file, const std::string& group, const par::Comm& comm) const;
  void load(const io::File& file, const std::string& group);

 private:
  void show(double motion);
  double shake(double dt);

  PlatenParameters parameters_;
  Surface surface_;
  double area_;  // m^2
  bool follows_ = false;
  Servo servo_;
  double z_ = 0, shaken_ = 0;  // m; s, since the vibration began
};

}  // namespace trackbed::bed
