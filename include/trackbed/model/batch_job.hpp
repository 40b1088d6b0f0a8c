// The end of the batch job in which the program runs.
#pragma once

namespace trackbed::model {

// Throws InputError if TRACKBED_END_TIME is not a time to come. Local.
void require_time_of_job();

// s of wall time until the batch job ends, by the environment variable TRACKBED_END_TIME or
// SLURM_JOB_END_TIME (Unix time, s), which is read once; infinite if neither is set to a
// time.
double time_left_of_job();

}  // namespace trackbed::model
