// The signal handler only sets a flag, which the run reads when its ranks agree (`Run::agree`).
//
// Anything more in a handler (a message, a file, an MPI call) may interrupt the same operation of
// the program and is undefined behaviour.
#include "trackbed/model/interrupt.hpp"

#include <csignal>
#include <initializer_list>

namespace trackbed::model {

namespace {

// The only type that a signal handler may safely write.
volatile std::sig_atomic_t asked_to_stop = 0;

extern "C" void note_interrupt(int) { asked_to_stop = 1; }

}  // namespace

// Open MPI forwards SIGUSR1; SIGTERM and SIGINT reach ranks that a batch system signals directly.
// The whole run stops if one rank received a signal: `Run::agree` takes the maximum.
void catch_interrupts() {
  for (const int signal : {SIGTERM, SIGINT, SIGUSR1}) std::signal(signal, note_interrupt);
}

bool interrupted() { return asked_to_stop != 0; }

}  // namespace trackbed::model
