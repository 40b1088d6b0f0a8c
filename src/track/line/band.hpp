// The part of a sampled profile between two wavelengths.
#pragma once

#include <vector>

namespace trackbed::track {

// m, root mean square of `values` (m, `step` m apart) between two wavelengths (m): Butterworth band
// pass filter of fourth order without phase shift, half the power at both limits. A straight line
// is subtracted first; the profile is mirrored at its ends. 0 for less than two values.
double band_rms(std::vector<double> values, double step, double shortest, double longest);

}  // namespace trackbed::track
