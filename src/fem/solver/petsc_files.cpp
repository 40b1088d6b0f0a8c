#include "fem/solver/petsc_files.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>

namespace trackbed::fem {

namespace {

namespace fs = std::filesystem;

bool is_readable(const std::string& path) {
  std::error_code error;
  return fs::is_regular_file(path, error) && access(path.c_str(), R_OK) == 0;
}

// An existing file, or a new one in an existing folder.
bool is_writable(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return false;
  if (fs::exists(path, error)) return access(path.c_str(), W_OK) == 0;
  const fs::path folder = fs::path(path).parent_path();
  const std::string at = folder.empty() ? "." : folder.string();
  return fs::is_directory(at, error) && access(at.c_str(), W_OK) == 0;
}

// The file of a viewer, type:file:format:mode, or nothing; nothing for screens and sockets. For
// -info the file comes first: file:classes.
std::string viewed(const std::string& value) {
  const std::size_t colon = value.find(':');
  if (colon == std::string::npos) return "";
  constexpr std::array<const char*, 5> types = {"", "ascii", "binary", "hdf5", "vtk"};
  const std::string type = value.substr(0, colon), rest = value.substr(colon + 1);
  if (std::find(types.begin(), types.end(), type) == types.end()) return "";
  return rest.substr(0, rest.find(':'));
}

}  // namespace

std::string unusable_file(const std::vector<std::string>& words, const std::string& source) {
  for (std::size_t k = 0; k + 1 < words.size(); ++k) {
    const std::string &option = words[k], &value = words[k + 1];
    if (!option.starts_with('-') || value.starts_with('-')) continue;
    const bool is_read = option == "-options_file" || option == "-options_file_yaml";
    if (is_read && !is_readable(value))
      return fmt::format("{}: {} {}: this file cannot be read", source, option, value);
    const std::string written = option == "-log_trace" ? value
                                : option == "-info"    ? value.substr(0, value.find(':'))
                                                       : viewed(value);
    if (!is_read && !written.empty() && !is_writable(written))
      return fmt::format("{}: {} {}: this file cannot be written", source, option, value);
  }
  return "";
}

// With types other than ascii PETSc creates a second file beside the named one, or opens a window.
std::optional<std::string> unwritten(const std::string& name, const std::string& value) {
  if (!name.ends_with("_view") && viewed(value).empty()) return value;
  const std::size_t type = std::min(value.find(':'), value.size());
  if (type > 0 && value.substr(0, type) != "ascii") return std::nullopt;
  const std::size_t file = value.find(':', std::min(type + 1, value.size()));
  std::string nowhere = "ascii:/dev/null";
  if (file != std::string::npos) nowhere += value.substr(file);
  return nowhere;
}

}  // namespace trackbed::fem
