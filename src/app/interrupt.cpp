// A handler only notes that a signal came; the run looks at the note once per window.
//
// Anything more in a handler (a message, a file, an MPI call) may meet the program in the middle of
// the same thing and is undefined.
#include "app/interrupt.hpp"

#include <csignal>
#include <initializer_list>

namespace trackbed::app {

namespace {

// The only thing a signal handler may safely touch; there is one process, so there is one flag.
volatile std::sig_atomic_t asked_to_stop = 0;

extern "C" void note_interrupt(int) { asked_to_stop = 1; }

}  // namespace

// Open MPI passes SIGUSR1 on; SIGTERM and SIGINT reach ranks that a batch system tells itself. The
// whole run stops if one rank was told: agree() takes the maximum.
void catch_interrupts() {
  for (const int signal : {SIGTERM, SIGINT, SIGUSR1}) std::signal(signal, note_interrupt);
}

bool interrupted() { return asked_to_stop != 0; }

}  // namespace trackbed::app
