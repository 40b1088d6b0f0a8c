// The four parameters of an implicit time integrator, in one form for all schemes.
//
//   M [(1 - alpha_m) a' + alpha_m a] + C [(1 - alpha_f) v' + alpha_f v]
//     + K [(1 - alpha_f) u' + alpha_f u] = (1 - alpha_f) F' + alpha_f F,
//   u' = u + dt v + dt^2 [(1/2 - beta) a + beta a'],  v' = v + dt [(1 - gamma) a + gamma a']
// with a prime at the end of the step (generalised alpha: Chung, Hulbert 1993,
// doi:10.1115/1.2900803). Newmark (1959, doi:10.1061/JMCEA3.0000098) has both alphas 0; Hilber,
// Hughes, Taylor (1977, doi:10.1002/eqe.4290050306) have alpha_f = -alpha; Wood, Bossak,
// Zienkiewicz (1980, doi:10.1002/nme.1620151011) have alpha_m = alpha. Signs differ between papers:
// here alpha is negative where it damps, in both.
#pragma once

#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

struct AlphaScheme {
  double alpha_m, alpha_f, beta, gamma;
};

// All schemes except Newmark's use gamma = 1/2 - alpha_m + alpha_f, which makes them second order,
// and beta = (1 - alpha_m + alpha_f)^2 / 4, which maximises the damping of the highest frequencies.
inline AlphaScheme alpha_scheme(const GroundParameters& p) {
  AlphaScheme s{0, 0, p.newmark_beta, p.newmark_gamma};
  if (p.integrator == Integrator::newmark) return s;
  if (p.integrator == Integrator::hht) s.alpha_f = -p.alpha;
  if (p.integrator == Integrator::bossak) s.alpha_m = p.alpha;
  if (p.integrator == Integrator::generalized_alpha) {
    s.alpha_m = (2 * p.rho_inf - 1) / (p.rho_inf + 1);
    s.alpha_f = p.rho_inf / (p.rho_inf + 1);
  }
  const double shift = s.alpha_f - s.alpha_m;
  s.gamma = 0.5 + shift;
  s.beta = 0.25 * (1 + shift) * (1 + shift);
  return s;
}

}  // namespace trackbed::fem
