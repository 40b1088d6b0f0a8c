// Requests to stop with a checkpoint: SIGTERM, SIGINT and SIGUSR1 (which mpirun forwards at once
// without ending the ranks afterwards).
#pragma once

namespace trackbed::model {

void catch_interrupts();
// Whether this rank has received a signal. Local: the caller makes ranks agree.
bool interrupted();

}  // namespace trackbed::model
