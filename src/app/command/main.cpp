// MPI is initialised before anything else and finalised after everything else: objects with MPI
// handles exist only within `program`.
#include "app/command/program.hpp"
#include "trackbed/par/comm.hpp"

int main(int argc, char** argv) {
  // The first object constructed and the last one destroyed.
  const trackbed::par::Environment environment(argc, argv);
  return trackbed::app::program(trackbed::par::Comm::world(), argc, argv);
}
