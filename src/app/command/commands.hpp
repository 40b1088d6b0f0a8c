// The commands of the program. Each returns the exit code; InputError and RunError pass through.
#pragma once

#include <string>
#include <vector>

#include "app/command/shapes.hpp"
#include "trackbed/model/kernel.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

struct Arguments {
  std::string deck;                    // run, check
  std::string file;                    // resume, info
  std::string section;                 // describe
  std::vector<std::string> overrides;  // key=value
  std::string folder;                  // -o; empty: chosen; kernel: a file
  std::string drawing;                 // check: file to draw the model into
  std::vector<int> ranks;              // check: for which the work is stated
  ShapeArguments shapes;
  model::KernelParameters kernel;
  bool force = false;      // run: results of an earlier run may be removed
  bool or_resume = false;  // run: a run that has begun is continued
};

int run(const par::Comm& comm, const Arguments& arguments);
int resume(const par::Comm& comm, const Arguments& arguments);
int check(const par::Comm& comm, const Arguments& arguments);
int describe(const par::Comm& comm, const Arguments& arguments);
int schema(const par::Comm& comm, const Arguments& arguments);
int kernel(const par::Comm& comm, const Arguments& arguments);
int info(const par::Comm& comm, const Arguments& arguments);

}  // namespace trackbed::app
