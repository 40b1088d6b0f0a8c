// A writer to be killed: writes checkpoints 1, 2, 3 ... into a folder and prints the number of each
// finished one. With `check` it opens the latest instead and prints its number. See kill_writer.py.
#include <cstdio>
#include <vector>

#include "trackbed/core/error.hpp"
#include "trackbed/io/checkpoint.hpp"

namespace {

constexpr std::size_t values = 200000;  // 1.6 MB: long enough to be killed in the middle

void write_for_ever(const trackbed::par::Comm& comm, const std::string& folder) {
  for (int number = 1;; ++number) {
    const std::vector<double> x(values, number);
    trackbed::io::write_checkpoint(
        comm, folder, number % 2 == 0 ? "even.h5" : "odd.h5", [&](trackbed::io::File& file) {
          file.write<double>("/x", x, 1, {"-", "its number, many times"});
          file.attribute("/", "number", static_cast<double>(number));
        });
    std::printf("%d\n", number);
    std::fflush(stdout);
  }
}

int check(const trackbed::par::Comm& comm, const std::string& folder) {
  const trackbed::io::File file = trackbed::io::open_checkpoint(
      comm, trackbed::io::choose_checkpoint(comm, folder, trackbed::io::IfDamaged::refuse).file);
  const double number = file.number_attribute("/", "number");
  for (const double x : file.read_all<double>("/x"))
    if (x != number) return 1;
  std::printf("%d\n", static_cast<int>(number));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const trackbed::par::Environment environment(argc, argv);
  const auto comm = trackbed::par::Comm::world();
  try {
    if (argc == 3 && std::string(argv[1]) == "check") return check(comm, argv[2]);
    if (argc == 3 && std::string(argv[1]) == "write") write_for_ever(comm, argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
  }
  return 2;
}
