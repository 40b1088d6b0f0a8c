// A folder for one test's files, made and removed by rank 0.
#pragma once

#include <filesystem>
#include <string>

#include "trackbed/io/checkpoint.hpp"

namespace trackbed::io {

class Scratch {
 public:
  // One folder per test and number of ranks: ctest may run several side by side.
  explicit Scratch(const std::string& test)
      : path_("scratch_" + test + "_" + std::to_string(world_.size())) {
    if (world_.root()) {
      std::filesystem::remove_all(path_);
      std::filesystem::create_directories(path_);
    }
    world_.barrier();
  }
  ~Scratch() {
    world_.barrier();
    std::error_code ignored;
    if (world_.root()) std::filesystem::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  const std::string& folder() const { return path_; }
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  par::Comm world_ = par::Comm::world();
  std::string path_;
};

inline File open_latest(const par::Comm& comm, const std::string& folder) {
  return open_checkpoint(comm, choose_checkpoint(comm, folder, IfDamaged::refuse).file);
}

}  // namespace trackbed::io
