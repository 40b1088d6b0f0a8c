// Sizes of stones from a sieve curve.
//
// A sieve curve P(s) is a distribution by mass; stones are drawn by number. With mass ~ s^D the
// number of stones per size is dN = dP/s^D. P is linear in log(s) between sieves, so within a class
// of mass fraction p from a to b, N = p (a^-D - b^-D)/(D log(b/a)), and both distributions have
// closed inverses.
#pragma once

#include <vector>

namespace trackbed::bed {

class Grading {
 public:
  // Sieves in m, passing in per cent; `dimension` D: 2 for disks, 3 for bodies.
  Grading(const std::vector<double>& sieve, const std::vector<double>& passing, int dimension);
  double by_mass(double fraction) const;    // m, size that `fraction` of the mass is smaller than
  double by_number(double fraction) const;  // m, size that `fraction` of the stones is smaller than
  double mean_power() const { return 1 / stones_.back(); }  // number mean of s^D, m^D

 private:
  std::vector<double> sieve_, mass_,
      stones_;  // m; cumulative mass fraction, stones per unit of mass
  double power_;
};

}  // namespace trackbed::bed
