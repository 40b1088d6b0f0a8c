// MPI is begun before anything else and ended after everything else: objects that hold MPI handles
// live within `program`.
#include "app/program.hpp"
#include "trackbed/par/comm.hpp"

int main(int argc, char** argv) {
  // The first object made and the last to go.
  const trackbed::par::Environment environment(argc, argv);
  return trackbed::app::program(trackbed::par::Comm::world(), argc, argv);
}
