// Initialisation and end of PETSc, its error codes, and options that it rejects.
//
// PETSc is initialised once per process, by the program or, in tests, on first use.
#include "trackbed/fem/petsc.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <petscsys.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <sstream>

#include "fem/solver/petsc_check.hpp"
#include "fem/solver/petsc_files.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::fem {

namespace {

constexpr const char* variable = "PETSC_OPTIONS";  // of the environment, read by PETSc itself

// Global as in PETSc itself: the options after --, and the text of the last error.
std::vector<std::string>& given() {
  static std::vector<std::string> options;
  return options;
}
std::string& last_error() {
  static std::string words;
  return words;
}

// Those of rank 0, as PETSc uses them: mpirun may not pass them to other ranks.
std::vector<std::string>& of_environment() {
  static std::vector<std::string> words;
  return words;
}
void read_environment(const par::Comm& comm) {
  const char* text = std::getenv(variable);
  std::istringstream stream(comm.broadcast(text == nullptr ? "" : text));
  of_environment().clear();
  for (std::string word; stream >> word;) of_environment().push_back(word);
}

// Returns the code instead of printing a traceback; the text is that of the function where the
// error was raised.
PetscErrorCode keep_error(MPI_Comm, int, const char*, const char*, PetscErrorCode code,
                          PetscErrorType type, const char* words, void*) {
  if (type == PETSC_ERROR_INITIAL) last_error() = words == nullptr ? "" : words;
  return code;
}

std::string error_text(int code) {
  const std::string first = last_error().substr(0, last_error().find('\n'));
  if (!first.empty()) return first;
  const char* text = nullptr;
  PetscErrorMessage(static_cast<PetscErrorCode>(code), &text, nullptr);
  return text != nullptr ? text : "?";
}

// The source of the options, if there is only one.
const char* source() { return given().empty() ? variable : "command line"; }

// A rejected option is from one of two sources; RunError if there are no options.
void refuse(int code, const char* what) {
  std::vector<std::string> places;
  if (!given().empty()) places.push_back(fmt::format("after `--`: {}", fmt::join(given(), " ")));
  if (const auto& words = of_environment(); !words.empty())
    places.push_back(fmt::format("in {}: {}", variable, fmt::join(words, " ")));
  if (places.empty()) return check(code, what);
  throw InputError({fmt::format("{}: PETSc rejects one of the options ({}): {}", source(),
                                fmt::join(places, "; "), error_text(code))});
}

// Errors that are not caused by an option.
bool is_runtime_error(int code) {
  constexpr std::array all = {
      PETSC_ERR_MEM, PETSC_ERR_LIB,           PETSC_ERR_FP,           PETSC_ERR_SIG,
      PETSC_ERR_MPI, PETSC_ERR_NOT_CONVERGED, PETSC_ERR_MAT_LU_ZRPVT, PETSC_ERR_MAT_CH_ZRPVT};
  return std::find(all.begin(), all.end(), code) != all.end();
}

// PETSc accepts any number here and would then never stop.
void require_range(KSP solver) {
  PetscReal relative = 0, absolute = 0, growth = 0;
  PetscInt most = 0;
  const char* prefix = nullptr;
  check(KSPGetTolerances(solver, &relative, &absolute, &growth, &most), "get the tolerance");
  check(KSPGetOptionsPrefix(solver, &prefix), "get the prefix of a solver");
  const auto require = [&](bool holds, const char* name, double value, const char* range) {
    if (holds) return;
    throw InputError({fmt::format("{}: -{}{} = {:g}: must be {}", source(),
                                  prefix == nullptr ? "" : prefix, name, value, range)});
  };
  require(relative >= 0 && relative < 1, "ksp_rtol", relative, "at least 0 and below 1");
  require(absolute >= 0, "ksp_atol", absolute, "at least 0");
  require(growth > 0, "ksp_divtol", growth, "above 0");
  require(most >= 0, "ksp_max_it", static_cast<double>(most), "at least 0");
}

// PETSc stops at a first word that is not an option without naming it.
void require_option(const std::vector<std::string>& options) {
  if (options.empty() || options.front().starts_with('-')) return;
  throw InputError(
      {fmt::format("command line: PETSc options are expected after --, for example "
                   "-ground_ksp_type cg; \"{}\" is not an option",
                   options.front())});
}

// The signal handler of PETSc is disabled so that that of the program remains, and errors are
// returned as codes instead of aborting: they become RunError and its exit code. The error handler
// is set before initialisation, since that reads options.
void start(const std::vector<std::string>& options) {
  require_option(options);
  given() = options;
  read_environment(par::Comm::world());
  std::string problem = unusable_file(options, "command line");
  if (problem.empty()) problem = unusable_file(of_environment(), variable);
  if (problem = par::Comm::world().first_problem(problem); !problem.empty())
    throw InputError({problem});
  std::vector<std::string> words = {"trackbed", "-no_signal_handler"};
  words.insert(words.end(), options.begin(), options.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  int count = static_cast<int>(words.size());
  char** list = pointers.data();
  check(PetscPushErrorHandler(keep_error, nullptr), "set the error handler of PETSc");
  if (const int code = PetscInitialize(&count, &list, nullptr, nullptr); code != 0)
    refuse(code, "start");
}

// Harmless if PETSc has been finalised elsewhere.
void finish() {
  PetscBool running = PETSC_FALSE;
  PetscInitialized(&running);
  if (running == PETSC_TRUE) PetscFinalize();
}

// MPI_Finalize first frees the attributes of MPI_COMM_SELF (MPI 4.0, 11.2.4): the place to finalise
// a library that was initialised on demand.
int finish_with_mpi(MPI_Comm, int, void*, void*) {
  finish();
  return MPI_SUCCESS;
}

}  // namespace

void check(int code, const char* what) {
  if (code == 0) return;
  throw RunError(std::string("PETSc could not ") + what + ": " + error_text(code));
}

void set_from_options(KSP solver) {
  last_error().clear();
  if (const int code = KSPSetFromOptions(solver); code != 0) refuse(code, "set up a solver");
  require_range(solver);
}

void set_up(KSP solver) {
  last_error().clear();
  const int code = KSPSetUp(solver);
  is_runtime_error(code) || code == 0 ? check(code, "set up the linear solver")
                                      : refuse(code, "set up the linear solver");
}

void set_up_factors(KSP solver) {
  PC factors = nullptr;
  check(KSPGetPC(solver, &factors), "get the preconditioner");
  last_error().clear();
  if (const int code = PCFactorSetUpMatSolverType(factors); code != 0)
    refuse(code, "select the direct solver");
}

Petsc::Petsc(const std::vector<std::string>& options) { start(options); }
Petsc::~Petsc() { finish(); }

std::vector<std::string> Petsc::unused_options() {
  PetscBool running = PETSC_FALSE;
  check(PetscInitialized(&running), "get its state");
  if (running != PETSC_TRUE) return {};
  PetscInt count = 0;
  char **names = nullptr, **values = nullptr;
  check(PetscOptionsLeftGet(nullptr, &count, &names, &values), "list its options");
  std::vector<std::string> unused;
  for (PetscInt i = 0; i < count; ++i) unused.emplace_back(names[i]);
  check(PetscOptionsLeftRestore(nullptr, &count, &names, &values), "return its list of options");
  return unused;
}

void Petsc::ensure() {
  PetscBool running = PETSC_FALSE;
  check(PetscInitialized(&running), "get its state");
  if (running == PETSC_TRUE) return;
  start({});
  int key = MPI_KEYVAL_INVALID;
  MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, finish_with_mpi, &key, nullptr);
  MPI_Comm_set_attr(MPI_COMM_SELF, key, nullptr);
}

}  // namespace trackbed::fem
