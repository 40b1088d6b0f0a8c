// The part of a sampled profile between two wavelengths.
#pragma once

#include <vector>

namespace trackbed::track {

// m, root mean square of the part of `values` (m, `step` m apart) between two wavelengths (m): a
// Butterworth band pass of fourth order without phase, half the power at both borders. A straight
// line is taken out first; the ends are continued by their mirror image. 0 for less than two
// values.
double band_rms(std::vector<double> values, double step, double shortest, double longest);

}  // namespace trackbed::track
