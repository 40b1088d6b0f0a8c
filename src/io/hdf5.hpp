// What the io room knows of HDF5: handles that close themselves, the library's own printing of
// errors switched off, and the element types. Private to the room.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <string>
#include <utility>

namespace trackbed::io {

// Owns one HDF5 identifier of any kind; the reference count decides, so one function closes all.
// Moved, never copied: two owners would close it twice.
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
  // False if the library reports trouble; the handle is given up either way.
  bool close() {
    const hid_t id = std::exchange(id_, H5I_INVALID_HID);
    return id < 0 || H5Idec_ref(id) >= 0;
  }

 private:
  hid_t id_ = H5I_INVALID_HID;
};

// HDF5 prints every failure to stderr unless told not to; we put failures into sentences.
void silence_hdf5();
// What the library says about its last failure: the innermost message, in brackets, or nothing.
std::string hdf5_reason();

// The native element type of T; owned by the library, never closed.
template <class T>
hid_t native_type();
// "64-bit real numbers", for messages about a dataset of another type than expected.
std::string type_name(hid_t type);

}  // namespace trackbed::io
