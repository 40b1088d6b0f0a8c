#include "trackbed/io/archive.hpp"

#include <sstream>

#include "trackbed/core/error.hpp"

namespace trackbed::io {

template <class T>
void Archive::array(const std::string& name, std::vector<T>& values, const Label& label) {
  if (reads())
    values = file_->read_all<T>(path(name));
  else
    out_->write<T>(path(name), std::span(values).first(comm_->root() ? values.size() : 0), 1,
                   label);
}

template <class T>
void Archive::one(const std::string& name, T& value, const Label& label) {
  std::vector<T> values{value};
  array(name, values, label);
  if (values.size() != 1)
    throw RunError(path(name) + ": holds " + std::to_string(values.size()) + " values, not one");
  value = values[0];
}

void Archive::operator()(const std::string& name, double& value, const Label& label) {
  one(name, value, label);
}

void Archive::operator()(const std::string& name, std::int64_t& value, const Label& label) {
  one(name, value, label);
}

void Archive::operator()(const std::string& name, std::vector<double>& values, const Label& label) {
  array(name, values, label);
}

// A dataset, since attributes of HDF5 are limited to 64 kB.
void Archive::operator()(const std::string& name, std::vector<std::string>& texts,
                         const Label& label) {
  std::vector<std::uint8_t> letters;
  for (const std::string& text : texts) {
    letters.insert(letters.end(), text.begin(), text.end());
    letters.push_back('\n');
  }
  array(name, letters, label);
  if (!reads()) return;
  texts.clear();
  std::istringstream lines(std::string(letters.begin(), letters.end()));
  for (std::string line; std::getline(lines, line);) texts.push_back(line);
}

}  // namespace trackbed::io
