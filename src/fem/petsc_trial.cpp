// Options tried before a run, on its own ground: whether PETSc takes an option may hang on how many
// unknowns there are, on their matrix and on the preconditioner that a step gets, so a smaller
// ground would refuse what a run takes, or the other way round. It costs one more setting up.
#include <petscsys.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "petsc_check.hpp"
#include "petsc_files.hpp"
#include "trackbed/fem/ground.hpp"
#include "trackbed/fem/petsc.hpp"

namespace trackbed::fem {

namespace {

// What PETSc asks for only as it solves, which a trial does not: of smoothers and coarse grids, of
// factors within them or beside the tangent, of what it says at the end. With a window that is not
// known, whether steps get multigrid is not either.
bool comes_later(const std::string& name, bool window_known) {
  constexpr std::array pieces = {"ground_mg_",        "ground_gamg_", "_mat_",
                                 "_converged_reason", "_ksp_error",   "_pc_view"};
  return std::any_of(pieces.begin(), pieces.end(),
                     [&](const char* piece) { return name.find(piece) != std::string::npos; }) ||
         (!window_known && name.starts_with("ground_pc_gamg_"));
}

// Options that nothing has asked for yet. A trial leaves them so, and what it was asked to write is
// written nowhere.
class Untouched {
 public:
  Untouched() {
    PetscInt count = 0;
    char **names = nullptr, **values = nullptr;
    check(PetscOptionsLeftGet(nullptr, &count, &names, &values), "list its options");
    for (PetscInt i = 0; i < count; ++i)
      all_.emplace_back(names[i], values[i] == nullptr ? "" : values[i]);
    check(PetscOptionsLeftRestore(nullptr, &count, &names, &values), "give back its options");
    for (const auto& [name, value] : all_) set(name, unwritten(name, value));
  }
  ~Untouched() {
    for (const auto& [name, value] : all_) set(name, value);
  }
  Untouched(const Untouched&) = delete;
  Untouched& operator=(const Untouched&) = delete;
  bool none() const { return all_.empty(); }
  // Those that nothing has asked for since, nor would in a run.
  std::vector<std::string> left(bool window_known) const {
    std::vector<std::string> names = Petsc::unused_options();
    std::erase_if(names, [&](const std::string& name) {
      return std::none_of(all_.begin(), all_.end(),
                          [&](const auto& one) { return one.first == name; }) ||
             comes_later(name, window_known);
    });
    return names;
  }

 private:
  // Taken away first: only a new option counts as one that nobody has asked for.
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
  const Untouched options;
  constexpr double usual = 1e-4;  // s, of windows that only the stones tell
  if (!options.none())
    Ground(comm, parameters, dimension, thickness).try_solvers(window > 0 ? window : usual);
  return options.left(window > 0);
}

}  // namespace trackbed::fem
