// The state of a class in a checkpoint: one function of the class names each value once, and serves
// to save it and to load it.
//   void Course::archive(io::Archive& a) { a("windows", windows, {"-", "windows done"}); }
// A new value needs a new `checkpoint_format`: one that a file does not have cannot be read.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "trackbed/core/types.hpp"
#include "trackbed/io/file.hpp"

namespace trackbed::io {

// Values are the same on all ranks; rank 0 writes them, all ranks read them. All calls are
// collective; reading throws RunError where a value is missing or has another shape than the model.
class Archive {
 public:
  static Archive writer(const par::Comm& comm, File& file) { return {&comm, &file, &file}; }
  static Archive reader(const File& file) { return {nullptr, nullptr, &file}; }

  bool reads() const { return out_ == nullptr; }
  // Whether there is a value or group that some states do not have: in the file, or when saving, as
  // `now` says.
  bool has(const std::string& name, bool now) const {
    return reads() ? file_->has(group_ + name) : now;
  }

  Archive group(const std::string& name) const {
    Archive inner = *this;
    inner.group_ += name + "/";
    return inner;
  }
  // A part of the model as a group. One that is distributed over ranks has `save` and `load`.
  template <class Part>
  void part(const std::string& name, Part& object) {
    Archive inner = group(name);
    if constexpr (requires { object.archive(inner); })
      object.archive(inner);
    else if (reads())
      object.load(*file_, group_ + name);
    else
      object.save(*out_, group_ + name);
  }

  void operator()(const std::string& name, double& value, const Label& label);
  void operator()(const std::string& name, std::int64_t& value, const Label& label);
  void operator()(const std::string& name, Vec3& value, const Label& label);
  // Their number follows from the model.
  void operator()(const std::string& name, Eigen::VectorXd& values, const Label& label);
  // Their number is that of the file.
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

  // Rows of `columns` values each. Their number follows from the model.
  void table(const std::string& name, std::span<double> values, std::size_t columns,
             const Label& label);
  // One quantity of each item as a row: `of` is a member of the item or returns a reference, to a
  // number, a vector or a quaternion (x y z w). The number of items follows from the model.
  template <class Item, class Of = std::identity>
  void rows(const std::string& name, std::vector<Item>& items, const Label& label, Of of = {}) {
    const auto row = [&](Item& item) { return numbers_of(std::invoke(of, item)); };
    constexpr std::size_t columns = decltype(row(items[0]))::extent;
    std::vector<double> values;
    for (Item& item : items) values.insert(values.end(), row(item).begin(), row(item).end());
    table(name, values, columns, label);
    if (!reads()) return;
    const double* next = values.data();
    for (Item& item : items) std::copy_n(next, columns, row(item).begin()), next += columns;
  }

 private:
  Archive(const par::Comm* comm, File* out, const File* file)
      : comm_(comm), out_(out), file_(file) {}
  static std::span<double, 1> numbers_of(double& x) { return std::span<double, 1>(&x, 1); }
  static std::span<double, 3> numbers_of(Vec3& v) { return std::span<double, 3>(v.data(), 3); }
  static std::span<double, 4> numbers_of(Quat& q) {
    return std::span<double, 4>(q.coeffs().data(), 4);
  }
  template <class T>
  void fixed(const std::string& name, std::span<T> values, std::size_t columns, const Label& label);
  template <class T>
  void list(const std::string& name, std::vector<T>& values, const Label& label);
  template <class T>
  void write(const std::string& name, std::span<T> values, std::size_t columns, const Label& label);

  const par::Comm* comm_;
  File* out_;  // none while reading
  const File* file_;
  std::string group_;  // empty, or ends with a slash
};

}  // namespace trackbed::io
