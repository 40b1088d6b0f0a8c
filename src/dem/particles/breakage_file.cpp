// The state of breakage in a checkpoint.
#include <cmath>

#include "dem/particles/impl.hpp"
#include "trackbed/dem/templates.hpp"

namespace trackbed::dem {

namespace {

constexpr int crack_columns = sizeof(Crack) / sizeof(double);
constexpr int cut_columns = sizeof(Cut) / sizeof(double);
constexpr int break_columns = 14;

}  // namespace

void Particles::Impl::save_breakage(io::File& file, const std::string& group) const {
  const Breaking& b = breaking;
  if (!b.parameters.any() && b.next < 0) return;
  const std::string at = group + "/breakage";
  std::vector<std::int64_t> labels;
  if (comm.root()) labels = shapes.labels();
  file.write<std::int64_t>(at + "/labels", labels, 1,
                           {"-", "of each piece of the templates: its number in the whole stone"});
  std::vector<std::int64_t> single;
  if (comm.root()) single.assign(b.single.begin(), b.single.end());
  file.write<std::int64_t>(at + "/single", single, 1,
                           {"-", "numbers of templates that only one stone can have"});
  std::vector<double> cracks, cuts, breaks;
  for (const Crack& c : b.cracks)
    cracks.insert(cracks.end(),
                  {static_cast<double>(c.stone), static_cast<double>(c.pebble),
                   static_cast<double>(c.shape), c.scale, c.density, c.force, c.overlap, c.energy});
  for (const Cut& c : b.cuts)
    cuts.insert(cuts.end(),
                {static_cast<double>(c.stone), static_cast<double>(c.kind),
                 static_cast<double>(c.shape), c.scale, c.density, c.normal[0], c.normal[1],
                 c.normal[2], c.offset, c.size[0], c.size[1], c.force, c.stress, c.energy});
  for (const Break& e : b.breaks)
    breaks.insert(
        breaks.end(),
        {e.time, static_cast<double>(e.stone), static_cast<double>(e.fragment),
         static_cast<double>(e.pebble), e.position.x(), e.position.y(), e.position.z(), e.diameter,
         e.mass, e.force, e.released, e.lost, e.stress, static_cast<double>(e.kind)});
  file.write<double>(at + "/cracks", cracks, crack_columns,
                     {"-, -, -, -, kg/m3, N, m, J",
                      "pebbles that break off in the next window: stone, pebble, template, scale, "
                      "density, force, overlap, energy"});
  file.write<double>(
      at + "/cuts", cuts, cut_columns,
      {"-, -, -, -, kg/m3, -, -, -, m, -, -, N, Pa, J",
       "stones that are cut in the next window: stone, kind (1: corner, 2: split, 3: "
       "wear), template, scale, density, normal, offset, sizes of both parts, force, "
       "stress, energy"});
  file.write<double>(
      at + "/breaks", breaks, break_columns,
      {"s, -, -, -, m, m, m, m, kg, N, J, J, Pa, -",
       "parts that broke off: time, stone, fragment (-1: fines), pebble, x, y, z, diameter, mass, "
       "force, elastic energy of its contacts, kinetic energy lost, stress, kind (0: pebble of a "
       "clump, 1: corner of a polyhedron, 2: part of a split stone, 3: dust)"});
  file.attribute(group, "breaking", static_cast<std::int64_t>(b.active));
  file.attribute(group, "break_ball", static_cast<std::int64_t>(b.ball));
  file.attribute(group, "break_next", b.next);
  file.attribute(group, "break_pending", b.pending);
  file.attribute(group, "break_least_mass", b.least_mass);
  file.attribute(group, "break_least_radius", b.least_radius);
  file.attribute(group, "break_largest_radius", b.largest_radius);
  file.attribute(group, "break_fragments", b.totals.fragments);
  file.attribute(group, "break_fines", b.totals.fines);
  file.attribute(group, "break_cuts", b.totals.cuts);
  file.attribute(group, "break_splits", b.totals.splits);
  file.attribute(group, "break_fragment_mass", b.totals.fragment_mass);
  file.attribute(group, "break_fines_mass", b.totals.fines_mass);
  file.attribute(group, "break_released", b.totals.released);
  file.attribute(group, "break_lost", b.totals.lost);
  file.attribute(group, "break_wears", b.totals.wears);
  file.attribute(group, "break_dust_mass", b.totals.dust_mass);
}

void Particles::Impl::load_shapes(const io::File& file, const std::string& group) {
  const std::string path = group + "/breakage/labels";
  std::vector<std::int64_t> labels;
  if (file.has(path)) labels = file.read_all<std::int64_t>(path);
  std::size_t first = 0;
  for (const Template& shape : load_templates(file, group + "/template")) {
    const std::size_t end = first + shape.pieces.size();
    const auto at = [&](std::size_t k) { return labels.begin() + static_cast<std::ptrdiff_t>(k); };
    if (end <= labels.size())
      shapes.add(shape, {at(first), at(end)});
    else
      shapes.add(shape);
    first = end;
  }
}

// A state without breakage begins it with its next stage.
void Particles::Impl::load_breakage(const io::File& file, const std::string& group) {
  Breaking& b = breaking;
  const BreakageParameters parameters = b.parameters;
  const int material = b.material;
  b = {};
  b.parameters = parameters, b.material = material;
  const std::string at = group + "/breakage";
  if (!file.has(at + "/cracks")) return;
  const auto whole = [](double value) { return std::llround(value); };
  const auto cracks = file.read_own_rows<double>(at + "/cracks");
  for (std::size_t k = 0; k + crack_columns <= cracks.size(); k += crack_columns) {
    const double* c = cracks.data() + k;
    b.cracks.push_back({whole(c[0]), whole(c[1]), whole(c[2]), c[3], c[4], c[5], c[6], c[7]});
  }
  const auto breaks = file.read_own_rows<double>(at + "/breaks");
  for (std::size_t k = 0; k + break_columns <= breaks.size(); k += break_columns) {
    const double* e = breaks.data() + k;
    b.breaks.push_back({e[0], whole(e[1]), whole(e[2]), whole(e[3]), Vec3(e[4], e[5], e[6]), e[7],
                        e[8], e[9], e[10], e[11], e[12], static_cast<BreakKind>(whole(e[13]))});
  }
  const auto cuts = file.read_own_rows<double>(at + "/cuts");
  for (std::size_t k = 0; k + cut_columns <= cuts.size(); k += cut_columns) {
    const double* c = cuts.data() + k;
    b.cuts.push_back({whole(c[0]),
                      whole(c[1]),
                      whole(c[2]),
                      c[3],
                      c[4],
                      {c[5], c[6], c[7]},
                      c[8],
                      {c[9], c[10]},
                      c[11],
                      c[12],
                      c[13]});
  }
  const auto single = file.read_all<std::int64_t>(at + "/single");
  b.single.insert(single.begin(), single.end());
  b.active = file.integer_attribute(group, "breaking") != 0;
  b.ball = static_cast<int>(file.integer_attribute(group, "break_ball"));
  b.next = file.integer_attribute(group, "break_next");
  b.pending = file.integer_attribute(group, "break_pending");
  b.least_mass = file.number_attribute(group, "break_least_mass");
  b.least_radius = file.number_attribute(group, "break_least_radius");
  b.largest_radius = file.number_attribute(group, "break_largest_radius");
  b.totals = {file.integer_attribute(group, "break_fragments"),
              file.integer_attribute(group, "break_fines"),
              file.integer_attribute(group, "break_cuts"),
              file.integer_attribute(group, "break_splits"),
              file.number_attribute(group, "break_fragment_mass"),
              file.number_attribute(group, "break_fines_mass"),
              file.number_attribute(group, "break_released"),
              file.number_attribute(group, "break_lost"),
              file.integer_attribute(group, "break_wears"),
              file.number_attribute(group, "break_dust_mass")};
}

}  // namespace trackbed::dem
