// Columns: building, stepping, and their hold on the model. Cost per step: a few operations per
// level of a column and per border corner of the model.
#include "free_field.hpp"

namespace trackbed::fem {

namespace {

// Two levels tied: corner motion from (lower, upper) motion, then what of the corner forces turns
// round from the low to the high side along a normal.
Eigen::MatrixXd hold_of(const Eigen::MatrixXd& stiffness, int components, int normal) {
  const Eigen::Index corners = stiffness.rows() / components, half = corners / 2;
  Eigen::MatrixXd tie = Eigen::MatrixXd::Zero(stiffness.rows(), 2 * components);
  for (Eigen::Index k = 0; k < corners; ++k)
    for (int c = 0; c < components; ++c) tie(k * components + c, k / half * components + c) = 1;
  const Eigen::MatrixXd force = stiffness * tie;
  Eigen::MatrixXd hold = force;
  for (Eigen::Index k = 0; k < corners; ++k)
    hold.middleRows(k * components, components) -=
        force.middleRows((k ^ (1 << normal)) * components, components);
  return 0.5 * hold;
}

bool any_free_field(const GroundParameters& p, int normals) {
  for (int n = 0; n < normals; ++n)
    for (const bool high : {false, true})
      if (p.side(n, high) == Sides::free_field) return true;
  return false;
}

// N/m between the levels for motion along `c`: the upper corners' resistance to moving together.
double chain_stiffness(const Eigen::MatrixXd& stiffness, int components, int c) {
  const Eigen::Index corners = stiffness.rows() / components;
  double sum = 0;
  for (Eigen::Index a = corners / 2; a < corners; ++a)
    for (Eigen::Index b = corners / 2; b < corners; ++b)
      sum += stiffness(a * components + c, b * components + c);
  return sum;
}

}  // namespace

FreeField::FreeField(const Mesh& mesh, const GroundParameters& parameters,
                     const Stiffness& stiffness)
    : motion_(parameters.base_motion),
      components_(mesh.lattice.components()),
      zones_(static_cast<std::size_t>(mesh.lattice.zones[2])) {
  if (const int normals = components_ - 1; any_free_field(parameters, normals)) {
    const std::int64_t last = mesh.lattice.zones[0] - 1, step = mesh.lattice.plane ? last : 1;
    for (std::int64_t i = 0; i <= last; i += std::max<std::int64_t>(step, 1))
      make_column(mesh, parameters, stiffness, i);
    for (std::size_t s = 0; s < mesh.solids.solid.size(); ++s)
      for (int n = 0; n < normals; ++n)
        hold_.push_back(
            hold_of(stiffness.element(static_cast<std::int32_t>(s)).stiffness, components_, n));
  }
  find_corners(mesh, parameters);
  for (auto* numbers : {&displacement_, &velocity_, &acceleration_, &force_, &seen_.displacement,
                        &seen_.damped, &seen_.velocity})
    numbers->assign(mass_.size(), 0.0);
  rest();
}

// The column at zone `i` along the track: zones from the base up, the same on every rank whether it
// holds them or not. Level k lies below zone k.
void FreeField::make_column(const Mesh& mesh, const GroundParameters& parameters,
                            const Stiffness& stiffness, std::int64_t i) {
  const Lattice& lattice = mesh.lattice;
  const int half = lattice.corners() / 2;  // corners of a level
  mass_.resize(index(columns_ + 1, 0, 0), 0.0);
  damping_.resize(mass_.size(), 0.0);
  for (std::size_t k = 0; k < zones_; ++k) {
    const Id zone = lattice.zone({i, 0, static_cast<std::int64_t>(k)});
    const auto solid = static_cast<std::int32_t>(mesh.solids.of(parameters, lattice, zone));
    const ZoneElement& element = stiffness.element(solid);
    const Elastic& of = mesh.solids.solid[static_cast<std::size_t>(solid)];
    Chain chain{solid, of.rayleigh_stiffness, {}};
    for (int c = 0; c < components_; ++c) {
      chain.stiffness[c] = chain_stiffness(element.stiffness, components_, c);
      for (const std::size_t level : {k, k + 1}) {
        mass_[index(columns_, level, c)] += half * element.corner_mass;
        damping_[index(columns_, level, c)] += of.rayleigh_mass * half * element.corner_mass;
      }
    }
    chains_.push_back(chain);
  }
  const std::int32_t low = chains_[columns_ * zones_].solid;
  const Border border(mesh, parameters);
  for (int c = 0; c < components_; ++c) {
    foot_.push_back(half * border.dashpot(low, components_ - 1, c));
    damping_[index(columns_, 0, c)] += foot_.back();
  }
  ++columns_;
}

// Zones in ascending order, as in Terms: nodal sums have the same bits on any number of ranks.
void FreeField::find_corners(const Mesh& mesh, const GroundParameters& parameters) {
  const Lattice& lattice = mesh.lattice;
  const Border border(mesh, parameters);
  const int up = components_ - 1;
  if (mesh.imported) {
    for (const BasePart& part : quiet_base(mesh))
      if (mesh.owned[static_cast<std::size_t>(part.node)] != 0) base_.push_back(part);
    return;
  }
  for (std::size_t z = 0; z < mesh.zone.size(); ++z) {
    const Index3 at = lattice.zone_index(mesh.zone[z]);
    const std::int32_t solid = mesh.solid[z];
    for (int k = 0; k < lattice.corners(); ++k) {
      const std::int32_t node = mesh.home(mesh.corner(z, k));
      if (mesh.owned[static_cast<std::size_t>(node)] == 0) continue;
      const bool end = lattice.plane && at[0] > 0;  // a plane model's second column
      const auto column =
          static_cast<std::size_t>(lattice.plane ? (end ? columns_ - 1 : 0) : at[0]);
      for (int n = 0; n < up; ++n) {
        if (parameters.side(n, (k >> n & 1) != 0) != Sides::free_field) continue;
        if (!border.on_side(at, k, n)) continue;
        SideCorner& side = sides_.emplace_back();
        side.node = node, side.corner = k;
        side.hold = static_cast<std::size_t>(solid * up + n);
        side.chain = column * zones_ + static_cast<std::size_t>(at[2]);
        for (int c = 0; c <= up; ++c) side.dashpots[c] = border.dashpot(solid, n, c);
      }
      if (!border.on_base(at, k)) continue;
      BasePart low{node, {}};
      for (int c = 0; c <= up; ++c) low.dashpots[c] = border.dashpot(solid, up, c);
      base_.push_back(low);
    }
  }
}

// As the ground when it is let go. The wave may be under way then: its table decides, and what it
// has moved before is not counted.
void FreeField::rest() {
  list([](const char*, const char*, std::vector<double>& values) {
    std::fill(values.begin(), values.end(), 0.0);
  });
  seen_.wave = motion_.at(0);
}

void FreeField::list(const Visit& visit) {
  visit("displacement", "m", displacement_);
  visit("velocity", "m/s", velocity_);
  visit("acceleration", "m/s^2", acceleration_);
}

// force_ from what is seen: chains, and the wave at the foot; dashpots of the column itself are
// left to the schemes. A wave v_in stretches the foot's dashpots by 2 v_in - v, since the ground
// below both brings it and lets it out (Joyner, Chen 1975). There are no springs below a wave.
void FreeField::pull() {
  std::fill(force_.begin(), force_.end(), 0.0);
  for (std::size_t column = 0; column < columns_; ++column)
    for (int c = 0; c < components_; ++c) {
      const int axis = components_ == 3 ? c : 2 * c;
      const std::size_t foot = index(column, 0, c);
      const std::size_t at =
          column * static_cast<std::size_t>(components_) + static_cast<std::size_t>(c);
      force_[foot] = 2 * foot_[at] * seen_.wave[axis];
      for (std::size_t k = 0; k < zones_; ++k) {
        const Chain& chain = chains_[column * zones_ + k];
        const std::size_t low = index(column, k, c), high = index(column, k + 1, c);
        const double stretch = seen_.displacement[high] - seen_.displacement[low] +
                               chain.damping * (seen_.damped[high] - seen_.damped[low]);
        const double force = chain.stiffness[c] * stretch;
        force_[low] += force;
        force_[high] -= force;
      }
    }
}

// As explicit.cpp: stiffness damping sees the velocity at mid-step, dashpots that at the end.
void FreeField::explicit_step(double h, double end) {
  const double half = 0.5 * h;
  // The kick of the step before and this one's drift.
  for (std::size_t n = 0; n < mass_.size(); ++n) {
    velocity_[n] += half * acceleration_[n];
    displacement_[n] += h * velocity_[n];
  }
  seen_.displacement = displacement_;
  seen_.damped = velocity_;
  seen_.wave = motion_.at(end);
  pull();
  // The new velocity stands on both sides, as in the model's kick.
  for (std::size_t n = 0; n < mass_.size(); ++n) {
    const double push = force_[n] / mass_[n], rate = damping_[n] / mass_[n];
    velocity_[n] = (velocity_[n] + half * push) / (1 + half * rate);
    acceleration_[n] = push - rate * velocity_[n];
  }
  seen_.velocity = velocity_;
}

// As implicit.cpp: the column's equation is the model's, with chains for zones.
void FreeField::implicit_step(double dt, const AlphaScheme& s, double end) {
  const double f = 1 - s.alpha_f, g = s.alpha_f;
  seen_.wave = f * motion_.at(end) + g * motion_.at(end - dt);
  displacement_before_ = displacement_, velocity_before_ = velocity_;
  for (std::size_t n = 0; n < mass_.size(); ++n) {
    displacement_[n] += dt * velocity_[n] + dt * dt * (0.5 - s.beta) * acceleration_[n];
    velocity_[n] += dt * (1 - s.gamma) * acceleration_[n];
    seen_.displacement[n] = f * displacement_[n] + g * displacement_before_[n];
    seen_.velocity[n] = f * velocity_[n] + g * velocity_before_[n];
  }
  // Predicted motion pulls; what is left is a tridiagonal system for the acceleration.
  seen_.damped = seen_.velocity;
  pull();
  for (std::size_t n = 0; n < mass_.size(); ++n)
    force_[n] -= damping_[n] * seen_.velocity[n] + s.alpha_m * mass_[n] * acceleration_[n];
  for (std::size_t column = 0; column < columns_; ++column)
    for (int c = 0; c < components_; ++c) solve(column, c, dt, s);
  for (std::size_t n = 0; n < mass_.size(); ++n) {
    displacement_[n] += s.beta * dt * dt * acceleration_[n];
    velocity_[n] += s.gamma * dt * acceleration_[n];
    seen_.displacement[n] = f * displacement_[n] + g * displacement_before_[n];
    seen_.velocity[n] = f * velocity_[n] + g * velocity_before_[n];
  }
  seen_.damped = seen_.velocity;
}

// Acceleration of one column along one component: three diagonals, eliminated from the base up.
void FreeField::solve(std::size_t column, int c, double dt, const AlphaScheme& s) {
  const double f = 1 - s.alpha_f;
  std::vector<double>&diagonal = diagonal_, &above = above_;
  diagonal.assign(zones_ + 1, 0.0), above.assign(zones_ + 1, 0.0);
  for (std::size_t level = 0; level <= zones_; ++level) {
    const std::size_t n = index(column, level, c);
    diagonal[level] = (1 - s.alpha_m) * mass_[n] + f * s.gamma * dt * damping_[n];
  }
  for (std::size_t k = 0; k < zones_; ++k) {
    const Chain& chain = chains_[column * zones_ + k];
    const double stiff = f * (s.beta * dt * dt + s.gamma * dt * chain.damping) * chain.stiffness[c];
    diagonal[k] += stiff, diagonal[k + 1] += stiff;
    above[k] = -stiff;
  }
  for (std::size_t k = 0; k < zones_; ++k) {
    const double ratio = above[k] / diagonal[k];
    diagonal[k + 1] -= ratio * above[k];
    force_[index(column, k + 1, c)] -= ratio * force_[index(column, k, c)];
  }
  for (std::size_t level = zones_ + 1; level-- > 0;) {
    const std::size_t n = index(column, level, c);
    const double next = level < zones_ ? acceleration_[index(column, level + 1, c)] : 0.0;
    acceleration_[n] = (force_[n] - above[level] * next) / diagonal[level];
  }
}

// Local, on own nodes; corners in the order of zones. Forces from outside count against the
// internal ones, so that neither scheme needs another array.
void FreeField::act_on(Nodal& internal) const {
  const int half = (1 << components_) / 2;
  for (const SideCorner& side : sides_) {
    const Chain& chain = chains_[side.chain];
    const Eigen::MatrixXd& hold = hold_[side.hold];
    const std::size_t column = side.chain / zones_, k = side.chain % zones_;
    const std::size_t level = k + static_cast<std::size_t>(side.corner / half);
    for (int c = 0; c < components_; ++c) {
      double force = side.dashpots[c] * seen_.velocity[index(column, level, c)];
      for (int d = 0; d < 2 * components_; ++d) {
        const std::size_t n =
            index(column, k + static_cast<std::size_t>(d / components_), d % components_);
        force += hold(side.corner * components_ + c, d) *
                 (seen_.displacement[n] + chain.damping * seen_.damped[n]);
      }
      internal[c][side.node] -= force;
    }
  }
  for (const BasePart& base : base_)
    for (int c = 0; c < components_; ++c) {
      const int axis = components_ == 3 ? c : 2 * c;
      internal[c][base.node] -= 2 * base.dashpots[c] * seen_.wave[axis];
    }
}

}  // namespace trackbed::fem
