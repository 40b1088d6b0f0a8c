// Start and end of PETSc, and its error codes.
//
// PETSc is started once per process, by the program or, in tests, by whoever needs it first.
#include "trackbed/fem/petsc.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <petscsys.h>

#include "petsc_check.hpp"

namespace trackbed::fem {

namespace {

// Of the process, as PETSc's own.
std::vector<std::string>& given() {
  static std::vector<std::string> options;
  return options;
}

// PETSc stops at a first word that is no option without saying which.
void require_option(const std::vector<std::string>& options) {
  if (options.empty() || options.front().starts_with('-')) return;
  throw InputError({fmt::format(
      "command line: after -- stand options of PETSc, as -ground_ksp_type cg; \"{}\" is none",
      options.front())});
}

// PETSc's signal handler is left out so that the program's own stays, and errors come back as codes
// instead of an abort: they become RunError and its exit code.
void start(const std::vector<std::string>& options) {
  require_option(options);
  given() = options;
  std::vector<std::string> words = {"trackbed", "-no_signal_handler"};
  words.insert(words.end(), options.begin(), options.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  int count = static_cast<int>(words.size());
  char** list = pointers.data();
  check(PetscInitialize(&count, &list, nullptr, nullptr), "start PETSc");
  check(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr), "set the error handler of PETSc");
}

// Harmless if somebody else ended PETSc already.
void finish() {
  PetscBool running = PETSC_FALSE;
  PetscInitialized(&running);
  if (running == PETSC_TRUE) PetscFinalize();
}

// MPI_Finalize first frees the attributes of MPI_COMM_SELF (MPI 4.0, 11.2.4): the place to end a
// library that was started on demand.
int finish_with_mpi(MPI_Comm, int, void*, void*) {
  finish();
  return MPI_SUCCESS;
}

}  // namespace

// Carries PETSc's own words for the code; the return handler keeps its traceback off the screen.
void check(int code, const char* what) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(static_cast<PetscErrorCode>(code), &text, nullptr);
  throw RunError(std::string("PETSc could not ") + what + ": " + (text != nullptr ? text : "?"));
}

void take_options(KSP solver) {
  const int code = KSPSetFromOptions(solver);
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(static_cast<PetscErrorCode>(code), &text, nullptr);
  throw InputError({fmt::format("command line: PETSc does not take the options after -- ({}): {}",
                                fmt::join(given(), " "), text != nullptr ? text : "?")});
}

Petsc::Petsc(const std::vector<std::string>& options) { start(options); }
Petsc::~Petsc() { finish(); }

std::vector<std::string> Petsc::unused_options() {
  PetscBool running = PETSC_FALSE;
  check(PetscInitialized(&running), "say whether it runs");
  if (running != PETSC_TRUE) return {};
  PetscInt count = 0;
  char **names = nullptr, **values = nullptr;
  check(PetscOptionsLeftGet(nullptr, &count, &names, &values), "list its options");
  std::vector<std::string> unused;
  for (PetscInt i = 0; i < count; ++i) unused.emplace_back(names[i]);
  check(PetscOptionsLeftRestore(nullptr, &count, &names, &values), "give back its options");
  return unused;
}

void Petsc::ensure() {
  PetscBool running = PETSC_FALSE;
  check(PetscInitialized(&running), "say whether it runs");
  if (running == PETSC_TRUE) return;
  start({});
  int key = MPI_KEYVAL_INVALID;
  MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, finish_with_mpi, &key, nullptr);
  MPI_Comm_set_attr(MPI_COMM_SELF, key, nullptr);
}

}  // namespace trackbed::fem
