// Command line by CLI11. Arguments after `--` are passed to PETSc, so that any of its options can
// be used. Every exception ends here, as a message of rank 0 and an exit code for scripts. Input
// and run errors are equal on all ranks when they arrive; any other exception belongs to one rank.
#include "app/command/program.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <map>
#include <optional>

#include "app/command/commands.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/fem/petsc.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/model/effective.hpp"
#include "trackbed/par/meeting.hpp"

namespace trackbed::app {

namespace {

using Command = std::function<int(const par::Comm&, const Arguments&)>;

// Arguments after `--` are for PETSc and must be removed before CLI11 parses the others: PETSc's
// options have one dash and would be parsed as bundled letters.
std::vector<std::string> split_off_petsc(int& argc, char** argv) {
  std::vector<std::string> petsc;
  for (int i = 1; i < argc; ++i)
    if (std::string(argv[i]) == "--") {
      petsc.assign(argv + i + 1, argv + argc);
      argc = i;
    }
  return petsc;
}

// Ranges are those of the module geom, whose own error messages are less helpful.
void declare_shapes(CLI::App* sub, ShapeArguments& shapes) {
  sub->add_option("file", shapes.files, "Decks (.toml), libraries (.h5), meshes (.stl .ply .obj)");
  sub->add_option("--stones", shapes.stones, "Number of parametric stones, each 1 m long")
      ->check(CLI::Range(0, 100000));
  sub->add_option("--elongation", shapes.stone.elongation,
                  "Elongation of the stones, I/L: width divided by length")
      ->check(CLI::Range(0.1, 0.995))
      ->capture_default_str();
  sub->add_option("--flatness", shapes.stone.flatness,
                  "Flatness of the stones, S/I: thickness divided by width")
      ->check(CLI::Range(0.1, 0.995))
      ->capture_default_str();
  sub->add_option("--spread", shapes.stone.spread,
                  "Half-width of the distributions of elongation and flatness of the stones")
      ->check(CLI::Range(0.0, 0.5))
      ->capture_default_str();
  sub->add_option("--angularity", shapes.stone.angularity,
                  "Angularity of the stones, from 0 (ellipsoid) to 1")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  sub->add_option("--seed", shapes.seed,
                  "Seed of the first stone; each further stone takes the next number")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  sub->add_option("--vertices", shapes.mesh.vertices,
                  "Number of vertices of a parametric stone; for a mesh, at most this number in "
                  "each convex piece")
      ->check(CLI::Range(6, 200))
      ->capture_default_str();
  sub->add_option("--rounding", shapes.mesh.rounding,
                  "Rounding radius divided by the diameter of the sphere of the same volume")
      ->check(CLI::Range(0.0, 0.4))
      ->capture_default_str();
  sub->add_option("--unit", shapes.mesh.unit,
                  "Length unit of the meshes in m, for example 0.001 for mm")
      ->capture_default_str();
  sub->add_option("--parts", shapes.mesh.pieces, "Largest number of convex pieces of a mesh")
      ->check(CLI::Range(1, 200))
      ->capture_default_str();
  sub->add_option("--spheres", shapes.mesh.spheres,
                  "Largest number of spheres that represent a mesh, instead of convex pieces")
      ->check(CLI::Range(0, 1000));
  sub->add_option("--library", shapes.library, "Write the shapes into this library (.h5)");
  sub->add_option("--picture", shapes.picture,
                  "Write the surfaces of the shapes into this mesh (.obj)");
}

void declare_kernel(CLI::App* sub, Arguments& arguments) {
  model::KernelParameters& kernel = arguments.kernel;
  sub->add_option("deck", arguments.deck, "Input file (TOML) of a track alone")->required();
  sub->add_option("-o,--output", arguments.folder, "File for the functions (.h5)")->required();
  sub->add_option("--sensor", kernel.sensor, "x of the sensor, m; the nearest sleeper carries it")
      ->required();
  sub->add_option("--side", kernel.rail,
                  "Rail of the sensor and of the wheel, on a track with two rails")
      ->check(CLI::IsMember({"left", "right"}))
      ->capture_default_str();
  sub->add_option("--rate", kernel.rate, "Samples per second of the responses")
      ->check(CLI::Range(100.0, 1e5))
      ->capture_default_str();
  sub->add_option("--duration", kernel.duration, "Duration of the responses, s")
      ->check(CLI::Range(1e-3, 10.0))
      ->capture_default_str();
  sub->add_option("--apart", kernel.apart, "Distance of the positions of the force, m")
      ->check(CLI::Range(1e-3, 1.0))
      ->capture_default_str();
  const auto moving = sub->add_option("--speed", kernel.speed,
                                      "Speed, m/s, of the moving response: the rail below the "
                                      "first wheel")
                          ->check(CLI::Range(1.0, 200.0));
  sub->add_option("--axles", kernel.bogie,
                  "Number of axles, from the first one, whose forces deflect the rail below the "
                  "first wheel; unless given, those within 4 m of it, the bogie")
      ->needs(moving)
      ->check(CLI::Range(1, 16));
  sub->add_option("--from", kernel.from, "Range of the force of the moving response, m")
      ->needs(moving)
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  sub->add_option("--to", kernel.to, "End of that range, m; 0: end of the track")
      ->needs(moving)
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
}

// Adds the commands to `line`; the chosen one is stored by its callback.
void declare_commands(CLI::App& line, Arguments& arguments, std::optional<Command>& chosen) {
  const auto command = [&](const char* name, const char* words, const Command& what) {
    CLI::App* sub = line.add_subcommand(name, words);
    sub->callback([&chosen, what] { chosen = what; });
    return sub;
  };
  const auto with_overrides = [&](CLI::App* sub) {
    sub->add_option("override", arguments.overrides,
                    "Change of a parameter as key=value, for example dem.safety=0.1");
    return sub;
  };
  CLI::App* sub = command(
      "run", "Run a deck from its first stage, or after the checkpoint named by `start`", run);
  sub->add_option("deck", arguments.deck, "Input file (TOML)")->required();
  with_overrides(sub)->add_option("-o,--output", arguments.folder,
                                  "Result folder; default results/<name of the deck>");
  CLI::Option* force =
      sub->add_flag("--force", arguments.force,
                    "First remove the results of an earlier run from the result folder");
  sub->add_flag("--or-resume", arguments.or_resume,
                "Continue the run if the result folder has a checkpoint of it, for jobs that a "
                "queue may start again; a finished run is left as it is")
      ->excludes(force);
  sub = command("resume", "Continue a run that was stopped", resume);
  sub->add_option("checkpoint", arguments.file, "Checkpoint, or the folder that contains it")
      ->required();
  with_overrides(sub)->add_option("-o,--output", arguments.folder,
                                  "Result folder; default that of the stopped run");
  sub->add_flag(
      "--force", arguments.force,
      "In another folder (-o): first remove the results of an earlier run. In the run's own "
      "folder: continue from a checkpoint that is not the newest, and replace all later results");
  sub = command("check", "Validate a deck and estimate its cost", check);
  sub->add_option("deck", arguments.deck, "Input file (TOML)")->required();
  with_overrides(sub)->add_option("--draw", arguments.drawing,
                                  "Draw the model, seen from the side, into this file (.svg)");
  sub->add_option("--ranks", arguments.ranks,
                  "Numbers of ranks, separated by commas, for which the work is stated (decks with "
                  "bed.cell)")
      ->delimiter(',')
      ->check(CLI::Range(1, 65536));
  sub = command("describe", "List the sections of a deck, or print the reference of one", describe);
  sub->add_option("section", arguments.section,
                  "A section or parameter, for example ground or train.speed, a word to look for, "
                  "or all");
  command("schema", "Print the JSON schema of decks", schema);
  sub = command("info", "Print how far a run is, or the contents of a checkpoint or a results file",
                info);
  sub->add_option("file", arguments.file, "Folder of a run, checkpoint or results.h5")->required();
  sub = command("shapes", "Print measures of stones, write a library or a picture of them",
                [&](const par::Comm& comm, const Arguments&) {
                  arguments.shapes.stone.vertices = arguments.shapes.mesh.vertices;
                  for (const CLI::Option* option : line.get_subcommand("shapes")->get_options())
                    if (option->count() > 0) arguments.shapes.given.push_back(option->get_name());
                  return shapes(comm, arguments.shapes);
                });
  declare_shapes(sub, arguments.shapes);
  sub = command("kernel",
                "Write Green's functions of a track: of a sleeper, and of the rail below a wheel",
                kernel);
  declare_kernel(sub, arguments);
  with_overrides(sub);
  line.require_subcommand(1);
}

// Why the first argument is not a command, or empty. CLI11 would only report that a command is
// missing, also if one is misspelt.
std::string why_no_command(const CLI::App& line, int argc, char** argv) {
  const std::string word = argc > 1 ? argv[1] : "";
  if (word.starts_with('-')) return "";  // an option, --help for example
  std::vector<std::string> names;
  for (const CLI::App* sub : line.get_subcommands(nullptr)) names.push_back(sub->get_name());
  if (std::find(names.begin(), names.end(), word) != names.end()) return "";
  const std::string near = input::nearest(word, names);
  return fmt::format(
      "trackbed: {} (commands: {}){}",
      word.empty() ? "no command is given" : fmt::format("\"{}\" is not a command", word),
      fmt::join(names, ", "), near.empty() ? "" : fmt::format("; did you mean {}?", near));
}

// Prints a message that is the same on all ranks; rank 0 alone prints.
int complain(const par::Comm& comm, const std::string& text, ExitCode code) {
  if (comm.root()) fmt::print(stderr, "{}\n", text);
  return static_cast<int>(code);
}

// Exit code of a command whose answer is on stdout: an answer that could not be written, for
// example on a full disk, is a failure. Not for runs, whose results are files.
int answered(const par::Comm& comm, int code) {
  const bool lost =
      comm.root() && (!std::cout.flush() || std::fflush(stdout) != 0 || std::ferror(stdout) != 0);
  if (comm.broadcast(lost ? "lost" : "").empty() || code != 0) return code;
  return complain(comm,
                  "trackbed: standard output cannot be written (is the disk full, or a pipe "
                  "closed?)",
                  ExitCode::run_failed);
}

// What failed; a failed allocation states nothing by itself.
std::string words_of(const std::exception& error) {
  if (dynamic_cast<const std::bad_alloc*>(&error) == nullptr) return error.what();
  return "there is no more memory on this rank; use a smaller model, more nodes, or fewer ranks on "
         "each node";
}

// Ends the process of a rank that alone has an error: the others wait for it elsewhere, and mpirun
// ends them when one process exits without finalising MPI.
void leave_if_alone(const par::Comm& comm, par::Meeting& meeting, const std::exception& error,
                    ExitCode code) {
  constexpr double patience = 20;  // s: ranks reach a common error at nearly the same time
  if (comm.size() == 1 || meeting.all_arrive(patience)) return;
  fmt::print(stderr, "trackbed: only on rank {}: {}\n", comm.rank(), error.what());
  std::fflush(stderr);
  std::_Exit(static_cast<int>(code));
}

// PETSc is finalised after the model, whose matrices and solvers must be destroyed before;
// finalising it is collective, so a rank that is alone exits before.
int run_command(const par::Comm& comm, par::Meeting& meeting,
                const std::vector<std::string>& petsc_options, const Command& command,
                const Arguments& arguments) {
  const fem::Petsc petsc(petsc_options);
  try {
    return command(comm, arguments);
  } catch (const InputError& error) {
    leave_if_alone(comm, meeting, error, ExitCode::bad_input);
    throw;
  } catch (const RunError& error) {
    leave_if_alone(comm, meeting, error, ExitCode::run_failed);
    throw;
  } catch (const std::exception& error) {
    if (comm.size() == 1) throw;
    // No agreement between ranks: the others may wait for this one.
    fmt::print(stderr, "trackbed: rank {}: {}\n", comm.rank(), words_of(error));
    std::fflush(stderr);
    std::_Exit(static_cast<int>(ExitCode::run_failed));
  }
}

// --help and --version are errors to CLI11, with exit code 0.
// CLI11 prints in `exit`: on rank 0 only.
int parse_error(const par::Comm& comm, const CLI::App& line, const CLI::ParseError& error) {
  if (!comm.root()) return error.get_exit_code() == 0 ? 0 : static_cast<int>(ExitCode::bad_input);
  return line.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::bad_input);
}

}  // namespace

// InputError: the user must correct the input; RunError: the run failed; all else is unexpected.
// Each kind has its own exit code.
int program(const par::Comm& comm, int argc, char** argv) {
  const std::vector<std::string> petsc_options = split_off_petsc(argc, argv);
  CLI::App line("Ballasted railway track, from the train to the subgrade", "trackbed");
  line.set_version_flag(
      "--version", fmt::format("trackbed {}\n{}", model::version(), model::build_description()));
  line.footer(
      "Run in parallel with mpirun -n N. Give PETSc options after --. Exit codes: 0 done, 2 bad "
      "input, 3 stopped early on request, with a checkpoint unless a message says otherwise, 4 "
      "error while running.");
  Arguments arguments;
  std::optional<Command> chosen;
  declare_commands(line, arguments, chosen);
  if (const std::string problem = why_no_command(line, argc, argv); !problem.empty())
    return complain(comm, problem, ExitCode::bad_input);
  try {
    line.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return answered(comm, parse_error(comm, line, error));
  }
  try {
    par::Meeting meeting(comm);
    const int code = run_command(comm, meeting, petsc_options, *chosen, arguments);
    return line.got_subcommand("run") || line.got_subcommand("resume") ? code
                                                                       : answered(comm, code);
  } catch (const InputError& error) {
    return complain(comm, error.what(), ExitCode::bad_input);
  } catch (const RunError& error) {
    return complain(comm, std::string("trackbed: ") + error.what(), ExitCode::run_failed);
  } catch (const std::exception& error) {
    fmt::print(stderr, "trackbed: rank {}: {}\n", comm.rank(), words_of(error));
    return static_cast<int>(ExitCode::run_failed);
  }
}

}  // namespace trackbed::app
