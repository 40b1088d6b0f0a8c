// Columns: set-up, time stepping, and their forces on the model. Cost per step: a few operations
// per level of a column and per border corner of the model.
#include "fem/boundary/free_field.hpp"

namespace trackbed::fem {

namespace {

// Forces on the corners due to the (lower, upper) motion of two tied levels, then half of each less
// that of the corner opposite along the normal.
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

// N/m between the levels for motion along `c`: resistance of the upper corners to a common motion.
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
      elements_(static_cast<std::size_t>(mesh.lattice.elements[2])) {
  if (const int normals = components_ - 1; any_free_field(parameters, normals)) {
    const std::int64_t last = mesh.lattice.elements[0] - 1, step = mesh.lattice.plane ? last : 1;
    for (std::int64_t i = 0; i <= last; i += std::max<std::int64_t>(step, 1))
      make_column(mesh, parameters, stiffness, i);
    for (std::size_t s = 0; s < mesh.solids.solid.size(); ++s)
      for (int n = 0; n < normals; ++n)
        hold_.push_back(
            hold_of(stiffness.matrices(static_cast<std::int32_t>(s)).stiffness, components_, n));
  }
  find_corners(mesh, parameters);
  for (auto* numbers : {&displacement_, &velocity_, &acceleration_, &force_, &mixed_.displacement,
                        &mixed_.damped, &mixed_.velocity})
    numbers->assign(mass_.size(), 0.0);
  reset();
}

// The column at element `i` along the track: elements from the base up, the same on every rank,
// whether it holds them or not. Level k is below element k.
void FreeField::make_column(const Mesh& mesh, const GroundParameters& parameters,
                            const Stiffness& stiffness, std::int64_t i) {
  const Lattice& lattice = mesh.lattice;
  const int half = lattice.corners() / 2;  // corners of a level
  mass_.resize(index(columns_ + 1, 0, 0), 0.0);
  damping_.resize(mass_.size(), 0.0);
  for (std::size_t k = 0; k < elements_; ++k) {
    const Id element = lattice.element({i, 0, static_cast<std::int64_t>(k)});
    const auto solid = static_cast<std::int32_t>(mesh.solids.of(parameters, lattice, element));
    const ElementMatrices& matrices = stiffness.matrices(solid);
    const Elastic& of = mesh.solids.solid[static_cast<std::size_t>(solid)];
    Chain chain{solid, of.rayleigh_stiffness, {}};
    for (int c = 0; c < components_; ++c) {
      chain.stiffness[c] = chain_stiffness(matrices.stiffness, components_, c);
      for (const std::size_t level : {k, k + 1}) {
        mass_[index(columns_, level, c)] += half * matrices.corner_mass;
        damping_[index(columns_, level, c)] += of.rayleigh_mass * half * matrices.corner_mass;
      }
    }
    chains_.push_back(chain);
  }
  const std::int32_t low = chains_[columns_ * elements_].solid;
  const Border border(mesh, parameters);
  for (int c = 0; c < components_; ++c) {
    foot_.push_back(half * border.dashpot(low, components_ - 1, c));
    damping_[index(columns_, 0, c)] += foot_.back();
  }
  ++columns_;
}

// Elements in ascending order, as in Terms: nodal sums are bitwise identical on any number of
// ranks.
void FreeField::find_corners(const Mesh& mesh, const GroundParameters& parameters) {
  const Lattice& lattice = mesh.lattice;
  const Border border(mesh, parameters);
  const int up = components_ - 1;
  if (mesh.imported) {
    for (const BasePart& part : viscous_base(mesh))
      if (mesh.owned[static_cast<std::size_t>(part.node)] != 0) base_.push_back(part);
    return;
  }
  for (std::size_t z = 0; z < mesh.element.size(); ++z) {
    const Index3 at = lattice.element_index(mesh.element[z]);
    const std::int32_t solid = mesh.solid[z];
    for (int k = 0; k < lattice.corners(); ++k) {
      const std::int32_t node = mesh.home(mesh.corner(z, k));
      if (mesh.owned[static_cast<std::size_t>(node)] == 0) continue;
      const bool end = lattice.plane && at[0] > 0;  // the second column of a plane model
      const auto column =
          static_cast<std::size_t>(lattice.plane ? (end ? columns_ - 1 : 0) : at[0]);
      for (int n = 0; n < up; ++n) {
        if (parameters.side(n, (k >> n & 1) != 0) != Sides::free_field) continue;
        if (!border.on_side(at, k, n)) continue;
        SideCorner& side = sides_.emplace_back();
        side.node = node, side.corner = k;
        side.hold = static_cast<std::size_t>(solid * up + n);
        side.chain = column * elements_ + static_cast<std::size_t>(at[2]);
        for (int c = 0; c <= up; ++c) side.dashpots[c] = border.dashpot(solid, n, c);
      }
      if (!border.on_base(at, k)) continue;
      BasePart low{node, {}};
      for (int c = 0; c <= up; ++c) low.dashpots[c] = border.dashpot(solid, up, c);
      base_.push_back(low);
    }
  }
}

// State of the ground when it starts to move. The wave may already be in progress then: its table
// decides, and its motion before that time is not counted.
void FreeField::reset() {
  list([](const char*, const char*, std::vector<double>& values) {
    std::fill(values.begin(), values.end(), 0.0);
  });
  mixed_.wave = motion_.at(0);
}

void FreeField::list(const Visit& visit) {
  visit("displacement", "m", displacement_);
  visit("velocity", "m/s", velocity_);
  visit("acceleration", "m/s^2", acceleration_);
}

// Computes force_ from `mixed_`: chains, and the wave at the foot; the dashpots of the column
// itself are left to the schemes. A wave v_in loads the dashpots of the foot with 2 v_in - v, since
// the ground below both transmits and absorbs it (Joyner, Chen 1975). There are no springs below a
// wave.
void FreeField::compute_forces() {
  std::fill(force_.begin(), force_.end(), 0.0);
  for (std::size_t column = 0; column < columns_; ++column)
    for (int c = 0; c < components_; ++c) {
      const int axis = components_ == 3 ? c : 2 * c;
      const std::size_t foot = index(column, 0, c);
      const std::size_t at =
          column * static_cast<std::size_t>(components_) + static_cast<std::size_t>(c);
      force_[foot] = 2 * foot_[at] * mixed_.wave[axis];
      for (std::size_t k = 0; k < elements_; ++k) {
        const Chain& chain = chains_[column * elements_ + k];
        const std::size_t low = index(column, k, c), high = index(column, k + 1, c);
        const double stretch = mixed_.displacement[high] - mixed_.displacement[low] +
                               chain.damping * (mixed_.damped[high] - mixed_.damped[low]);
        const double force = chain.stiffness[c] * stretch;
        force_[low] += force;
        force_[high] -= force;
      }
    }
}

// As in explicit.cpp: stiffness damping uses the velocity at mid-step, dashpots that at the end.
void FreeField::explicit_step(double h, double end) {
  const double half = 0.5 * h;
  // The kick of the last step and the drift of this one.
  for (std::size_t n = 0; n < mass_.size(); ++n) {
    velocity_[n] += half * acceleration_[n];
    displacement_[n] += h * velocity_[n];
  }
  mixed_.displacement = displacement_;
  mixed_.damped = velocity_;
  mixed_.wave = motion_.at(end);
  compute_forces();
  // The new velocity is on both sides, as in the kick of the model.
  for (std::size_t n = 0; n < mass_.size(); ++n) {
    const double driving = force_[n] / mass_[n], rate = damping_[n] / mass_[n];
    velocity_[n] = (velocity_[n] + half * driving) / (1 + half * rate);
    acceleration_[n] = driving - rate * velocity_[n];
  }
  mixed_.velocity = velocity_;
}

// As in implicit.cpp: the equation of the column is that of the model, with chains for elements.
void FreeField::implicit_step(double dt, const AlphaScheme& s, double end) {
  const double f = 1 - s.alpha_f, g = s.alpha_f;
  mixed_.wave = f * motion_.at(end) + g * motion_.at(end - dt);
  displacement_before_ = displacement_, velocity_before_ = velocity_;
  for (std::size_t n = 0; n < mass_.size(); ++n) {
    displacement_[n] += dt * velocity_[n] + dt * dt * (0.5 - s.beta) * acceleration_[n];
    velocity_[n] += dt * (1 - s.gamma) * acceleration_[n];
    mixed_.displacement[n] = f * displacement_[n] + g * displacement_before_[n];
    mixed_.velocity[n] = f * velocity_[n] + g * velocity_before_[n];
  }
  // The forces of the predicted motion; then a tridiagonal system for the acceleration is solved.
  mixed_.damped = mixed_.velocity;
  compute_forces();
  for (std::size_t n = 0; n < mass_.size(); ++n)
    force_[n] -= damping_[n] * mixed_.velocity[n] + s.alpha_m * mass_[n] * acceleration_[n];
  for (std::size_t column = 0; column < columns_; ++column)
    for (int c = 0; c < components_; ++c) solve(column, c, dt, s);
  for (std::size_t n = 0; n < mass_.size(); ++n) {
    displacement_[n] += s.beta * dt * dt * acceleration_[n];
    velocity_[n] += s.gamma * dt * acceleration_[n];
    mixed_.displacement[n] = f * displacement_[n] + g * displacement_before_[n];
    mixed_.velocity[n] = f * velocity_[n] + g * velocity_before_[n];
  }
  mixed_.damped = mixed_.velocity;
}

// Acceleration of one column along one component: tridiagonal, eliminated from the base up.
void FreeField::solve(std::size_t column, int c, double dt, const AlphaScheme& s) {
  const double f = 1 - s.alpha_f;
  std::vector<double>&diagonal = diagonal_, &above = above_;
  diagonal.assign(elements_ + 1, 0.0), above.assign(elements_ + 1, 0.0);
  for (std::size_t level = 0; level <= elements_; ++level) {
    const std::size_t n = index(column, level, c);
    diagonal[level] = (1 - s.alpha_m) * mass_[n] + f * s.gamma * dt * damping_[n];
  }
  for (std::size_t k = 0; k < elements_; ++k) {
    const Chain& chain = chains_[column * elements_ + k];
    const double stiff = f * (s.beta * dt * dt + s.gamma * dt * chain.damping) * chain.stiffness[c];
    diagonal[k] += stiff, diagonal[k + 1] += stiff;
    above[k] = -stiff;
  }
  for (std::size_t k = 0; k < elements_; ++k) {
    const double ratio = above[k] / diagonal[k];
    diagonal[k + 1] -= ratio * above[k];
    force_[index(column, k + 1, c)] -= ratio * force_[index(column, k, c)];
  }
  for (std::size_t level = elements_ + 1; level-- > 0;) {
    const std::size_t n = index(column, level, c);
    const double next = level < elements_ ? acceleration_[index(column, level + 1, c)] : 0.0;
    acceleration_[n] = (force_[n] - above[level] * next) / diagonal[level];
  }
}

// Local, on own nodes; corners in the order of elements. External forces are subtracted from the
// internal ones, so that no scheme needs another array.
void FreeField::act_on(Nodal& internal) const {
  const int half = (1 << components_) / 2;
  for (const SideCorner& side : sides_) {
    const Chain& chain = chains_[side.chain];
    const Eigen::MatrixXd& hold = hold_[side.hold];
    const std::size_t column = side.chain / elements_, k = side.chain % elements_;
    const std::size_t level = k + static_cast<std::size_t>(side.corner / half);
    for (int c = 0; c < components_; ++c) {
      double force = side.dashpots[c] * mixed_.velocity[index(column, level, c)];
      for (int d = 0; d < 2 * components_; ++d) {
        const std::size_t n =
            index(column, k + static_cast<std::size_t>(d / components_), d % components_);
        force += hold(side.corner * components_ + c, d) *
                 (mixed_.displacement[n] + chain.damping * mixed_.damped[n]);
      }
      internal[c][side.node] -= force;
    }
  }
  for (const BasePart& base : base_)
    for (int c = 0; c < components_; ++c) {
      const int axis = components_ == 3 ? c : 2 * c;
      internal[c][base.node] -= 2 * base.dashpots[c] * mixed_.wave[axis];
    }
}

}  // namespace trackbed::fem
