// Options are tried before a run, on its own ground: whether PETSc accepts an option may depend on
// the number of unknowns, on the matrix and on the preconditioner of a step, so that a smaller
// ground could reject options that are valid in the run, or the reverse. The cost is one more
// set-up.
#include <petscsys.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fem/solver/petsc_check.hpp"
#include "fem/solver/petsc_files.hpp"
#include "trackbed/fem/ground.hpp"
#include "trackbed/fem/petsc.hpp"

namespace trackbed::fem {

namespace {

// Options that PETSc reads only during a solve, which a trial does not do: those of smoothers and
// coarse grids, of factors within them or of the tangent, of final output. If the window is not
// known, it is not known either whether steps use multigrid.
bool is_used_later(const std::string& name, bool window_known) {
  constexpr std::array pieces = {"ground_mg_",        "ground_gamg_", "_mat_",
                                 "_converged_reason", "_ksp_error",   "_pc_view"};
  return std::any_of(pieces.begin(), pieces.end(),
                     [&](const char* piece) { return name.find(piece) != std::string::npos; }) ||
         (!window_known && name.starts_with("ground_pc_gamg_"));
}

// Options not used yet. A trial leaves them unused, and discards their output.
class UnusedOptions {
 public:
  UnusedOptions() {
    PetscInt count = 0;
    char **names = nullptr, **values = nullptr;
    check(PetscOptionsLeftGet(nullptr, &count, &names, &values), "list its options");
    for (PetscInt i = 0; i < count; ++i)
      all_.emplace_back(names[i], values[i] == nullptr ? "" : values[i]);
    check(PetscOptionsLeftRestore(nullptr, &count, &names, &values), "return its list of options");
    for (const auto& [name, value] : all_) set(name, unwritten(name, value));
  }
  ~UnusedOptions() {
    for (const auto& [name, value] : all_) set(name, value);
  }
  UnusedOptions(const UnusedOptions&) = delete;
  UnusedOptions& operator=(const UnusedOptions&) = delete;
  bool none() const { return all_.empty(); }
  // Options not used since, and not used in a run either.
  std::vector<std::string> still_unused(bool window_known) const {
    std::vector<std::string> names = Petsc::unused_options();
    std::erase_if(names, [&](const std::string& name) {
      return std::none_of(all_.begin(), all_.end(),
                          [&](const auto& one) { return one.first == name; }) ||
             is_used_later(name, window_known);
    });
    return names;
  }

 private:
  // Cleared first: only a new option counts as unused.
  static void set(const std::string& name, const std::optional<std::string>& value) {
    const std::string option = "-" + name;
    PetscOptionsClearValue(nullptr, option.c_str());
    if (value)
      PetscOptionsSetValue(nullptr, option.c_str(), value->empty() ? nullptr : value->c_str());
  }
  std::vector<std::pair<std::string, std::string>> all_;
};

}  // namespace

std::vector<std::string> Petsc::try_options(const par::Comm& comm,
                                            const GroundParameters& parameters, Dimension dimension,
                                            double thickness, double window) {
  ensure();
  const UnusedOptions options;
  constexpr double usual = 1e-4;  // s, for windows that depend on the stones
  if (!options.none())
    Ground(comm, parameters, dimension, thickness).try_solvers(window > 0 ? window : usual);
  return options.still_unused(window > 0);
}

}  // namespace trackbed::fem
