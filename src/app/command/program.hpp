// The command line: arguments to commands, exceptions to exit codes.
#pragma once

#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// Returns the exit code; no exception leaves it. Called on every rank with the same arguments.
int program(const par::Comm& comm, int argc, char** argv);

}  // namespace trackbed::app
