// Rolling resistance on surfaces, by couples on the triangles in contact: a surface has no
// rotational degree of freedom for a moment. The law: contact.hpp, `rolling_moment`; the couples:
// couple.hpp.
#include <cmath>

#include "dem/particles/couple.hpp"
#include "dem/particles/impl.hpp"

namespace trackbed::dem {

// Gradients of linear shape functions: grad phi_k = n x e_k / (2 A), e_k the side opposite to node
// k in the triangle's sense of rotation, A its area. Spin: the slope of the motion along n gives
// the part in the face, omega = grad(u . n) x n; the part along n is the mean rotation of the arms
// about the centre, sum (r_k x u_k) . n / sum r_k^2.
Couple::Couple(const Surface& surface, int triangle, double s) {
  const auto& nodes = surface.triangles[static_cast<std::size_t>(triangle)];
  std::array<Vec3, 3> x;
  for (std::size_t k = 0; k < 3; ++k) x[k] = node_at(surface, nodes[k], s);
  const Vec3 area = (x[1] - x[0]).cross(x[2] - x[0]);  // twice the triangle's
  const double size = area.norm();
  const Vec3 centre = (x[0] + x[1] + x[2]) / 3;
  normal_ = area / size;
  // Motion over a window, so the spin is an angle, rad.
  Vec3 slope = Vec3::Zero(), around = Vec3::Zero();  // of the motion along the normal; in the face
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3& u = surface.motion[static_cast<std::size_t>(nodes[k])];
    gradient_[k] = normal_.cross(x[(k + 2) % 3] - x[(k + 1) % 3]) / size;
    arm_[k] = x[k] - centre;
    square_ += arm_[k].squaredNorm();
    slope += u.dot(normal_) * gradient_[k];
    around += arm_[k].cross(u);
  }
  spin_ = slope.cross(normal_) + around.dot(normal_) / square_ * normal_;
}

std::array<Vec3, 3> Couple::forces(const Vec3& moment) const {
  const Vec3 across = normal_.cross(moment);
  const double along = moment.dot(normal_) / square_;
  std::array<Vec3, 3> all;
  for (std::size_t k = 0; k < 3; ++k)
    all[k] = across.dot(gradient_[k]) * normal_ + along * normal_.cross(arm_[k]);
  return all;
}

// The moment is applied to the particle; each contact's triangle takes its part of the opposite.
// The spin relative to which the particle rolls is the mean of the triangles', weighted like their
// forces.
void Particles::Impl::add_rolling_resistance(const Approach& a, Approach::Patch& patch,
                                             const PatchLoad& load, const SubStep& step) {
  thread_local std::vector<Couple> couples;
  couples.clear();
  Surface& surface = *surfaces[static_cast<std::size_t>(a.surface)];
  double total = 0;
  Vec3 spin = Vec3::Zero();  // rad in a window
  for (std::size_t k = 0; k < load.contacts.size(); ++k) {
    couples.emplace_back(surface, load.contacts[k].triangle, step.fraction);
    total += load.weights[k];
    spin += load.weights[k] * couples.back().spin();
  }
  const auto p = static_cast<std::size_t>(a.piece);
  const auto b = static_cast<std::size_t>(pieces.body[p]);
  const double radius = shapes.only_spheres() ? state.x[b].w : pieces.x[p].w;
  const Vec3 n = patch.N.normalized(), w = state.w[b].vec3();
  // rad/s: a window lasts count * dt.
  const Vec3 against = w - spin / (total * step.count * step.dt);
  const Rolls<double> rolls{{n.x(), n.y(), n.z()},
                            {against.x(), against.y(), against.z()},
                            0.5 * w.dot(n),
                            load.f_n,
                            load.next,
                            load.k_n,
                            radius,
                            std::sqrt(mass(b))};
  Triple<double> roll{patch.roll.x, patch.roll.y, patch.roll.z};
  const auto resistance = rolling_moment(laws[static_cast<std::size_t>(a.law)].rolling, rolls,
                                         load.softening, step.dt, roll);
  patch.roll = {roll.x, roll.y, roll.z, 0};
  const Vec3 moment = vec3(resistance.moment);
  account(b, resistance.spent);
  state.t[b].set(state.t[b].vec3() + moment);
  action.moment -= moment;
  for (std::size_t k = 0; k < couples.size(); ++k) {
    const auto forces = couples[k].forces(-load.weights[k] / total * moment);
    for (std::size_t i = 0; i < 3; ++i)
      add_to_node(surface, load.contacts[k].triangle, i, forces[i], step);
  }
}

}  // namespace trackbed::dem
