// Ratios in figures of a run.
#pragma once

namespace trackbed {

// 0 if the denominator is not positive: JSON has no infinity.
inline double ratio(double above, double below) { return below > 0 ? above / below : 0; }

}  // namespace trackbed
