// The end of the batch job in which the program runs.
#pragma once

namespace trackbed::model {

// s of wall time until the batch job ends, by the environment variable TRACKBED_END_TIME or
// SLURM_JOB_END_TIME (Unix time, s), which is read once; infinite if neither is set to a number.
double time_left_of_job();

}  // namespace trackbed::model
