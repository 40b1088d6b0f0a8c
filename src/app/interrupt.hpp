// Polite requests to stop: SIGTERM, SIGINT and SIGUSR1 (which mpirun passes on at once and leaves
// all the time that is needed).
#pragma once

namespace trackbed::app {

void catch_interrupts();
// Local: agreeing on it is the caller's.
bool interrupted();  // on this rank

}  // namespace trackbed::app
