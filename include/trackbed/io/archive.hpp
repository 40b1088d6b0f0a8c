// The state of a class in a checkpoint: one function of the class names each value once, and serves
// to save it and to load it.
//   void Course::archive(io::Archive& a) { a("windows", windows, {"-", "windows done"}); }
// A new value needs a new `checkpoint_format`: one that a file does not have cannot be read.
#pragma once

#include <concepts>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "trackbed/io/file.hpp"

namespace trackbed::io {

// Values are the same on all ranks; rank 0 writes them, all ranks read them. All calls are
// collective; reading throws RunError where a value is missing, or a list is read as one value.
class Archive {
 public:
  // Into, or from, datasets of `group`.
  static Archive writer(const par::Comm& comm, File& file, const std::string& group) {
    return {&comm, &file, &file, group};
  }
  static Archive reader(const File& file, const std::string& group) {
    return {nullptr, nullptr, &file, group};
  }

  bool reads() const { return out_ == nullptr; }

  void operator()(const std::string& name, double& value, const Label& label);
  void operator()(const std::string& name, std::int64_t& value, const Label& label);
  void operator()(const std::string& name, std::vector<double>& values, const Label& label);
  // As UTF-8 characters, each text with a line feed; texts contain none.
  void operator()(const std::string& name, std::vector<std::string>& texts, const Label& label);

  // Other integers, flags and enumerators, as std::int64_t.
  template <class T>
  requires(std::integral<T> || std::is_enum_v<T>) void operator()(const std::string& name, T& value,
                                                                  const Label& label) {
    auto number = static_cast<std::int64_t>(value);
    (*this)(name, number, label);
    if (reads()) value = static_cast<T>(number);
  }

 private:
  Archive(const par::Comm* comm, File* out, const File* file, std::string group)
      : comm_(comm), out_(out), file_(file), group_(std::move(group)) {}
  std::string path(const std::string& name) const { return group_ + "/" + name; }
  template <class T>
  void array(const std::string& name, std::vector<T>& values, const Label& label);
  template <class T>
  void one(const std::string& name, T& value, const Label& label);

  const par::Comm* comm_;
  File* out_;  // none while reading
  const File* file_;
  std::string group_;
};

}  // namespace trackbed::io
