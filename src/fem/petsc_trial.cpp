// Options tried before a run, on its own ground: whether PETSc takes an option may hang on how many
// unknowns there are, on their matrix and on the preconditioner that a step gets, so a smaller
// ground would refuse what a run takes, or the other way round. It costs one more setting up.
#include <petscsys.h>

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

void Petsc::try_options(const par::Comm& comm, const GroundParameters& parameters,
                        Dimension dimension, double thickness, double window) {
  ensure();
  const Untouched options;
  if (!options.none()) Ground(comm, parameters, dimension, thickness).try_solvers(window);
}

}  // namespace trackbed::fem
