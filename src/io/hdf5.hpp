// HDF5 helpers of the io module: handles that close themselves, suppression of the library's own
// error output, and the element types. Private to the module.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <string>
#include <utility>

namespace trackbed::io {

// Owns one HDF5 identifier of any kind; since identifiers are reference-counted, one function
// closes all kinds. Moved, never copied: two owners would close it twice.
class Hid {
 public:
  Hid() = default;
  explicit Hid(hid_t id) : id_(id) {}
  ~Hid() { close(); }
  Hid(Hid&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)) {}
  Hid& operator=(Hid&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }

  hid_t get() const { return id_; }
  explicit operator bool() const { return id_ >= 0; }
  // False if the library reports an error; the handle is released in either case.
  bool close() {
    const hid_t id = std::exchange(id_, H5I_INVALID_HID);
    return id < 0 || H5Idec_ref(id) >= 0;
  }

 private:
  hid_t id_ = H5I_INVALID_HID;
};

// HDF5 prints every failure to stderr by default; this program reports failures in its own
// messages.
void silence_hdf5();
// The reason of the library's last failure: the innermost message, in brackets, or nothing.
std::string hdf5_reason();

// The native element type of T; owned by the library, never closed.
template <class T>
hid_t native_type();
template <>
hid_t native_type<double>();
template <>
hid_t native_type<float>();
template <>
hid_t native_type<std::int64_t>();
template <>
hid_t native_type<std::uint64_t>();
template <>
hid_t native_type<std::int32_t>();
template <>
hid_t native_type<std::int8_t>();
template <>
hid_t native_type<std::uint8_t>();
// "64-bit real numbers", for messages about a dataset of another type than expected.
std::string type_name(hid_t type);

}  // namespace trackbed::io
