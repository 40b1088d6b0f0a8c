// Attributes of datasets and groups. All calls are collective: all ranks pass the same value, as
// parallel HDF5 requires for changes to metadata. Only scalars, short lists and text of fixed
// length; anything else in a file is refused when it is read.
#include <algorithm>

#include "io/handle.hpp"

namespace trackbed::io {

namespace {

std::string subject_of(const std::string& path, const std::string& name) {
  return "attribute " + name + " of " + path;
}

// The object named by `path`, a dataset or a group; a missing group is created if the file is open
// for writing.
Hid open_object(const File& file, const std::string& path) {
  const hid_t id = file.handle().file.get();
  if (file.handle().mode == Mode::read || file.has(path))
    return Hid(H5Oopen(id, path.c_str(), H5P_DEFAULT));
  const Hid links(H5Pcreate(H5P_LINK_CREATE));
  H5Pset_create_intermediate_group(links.get(), 1);
  return Hid(H5Gcreate2(id, path.c_str(), links.get(), H5P_DEFAULT, H5P_DEFAULT));
}

// Called on every rank: changes to metadata are collective in HDF5.
void write_attribute(const File& file, const std::string& path, const std::string& name,
                     const Hid& type, const Hid& space, const void* value) {
  const Hid object = open_object(file, path);
  bool ok = bool(object);
  // HDF5 cannot overwrite: an attribute of the same name may be of another type or length.
  if (ok && H5Aexists(object.get(), name.c_str()) > 0)
    ok = H5Adelete(object.get(), name.c_str()) >= 0;
  if (ok) {
    const Hid attribute(
        H5Acreate2(object.get(), name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT));
    ok = attribute && H5Awrite(attribute.get(), type.get(), value) >= 0;
  }
  file.handle().agree(ok, subject_of(path, name), "cannot be written");
}

// Two agreements: whether the attribute exists, then whether it is of the expected type.
Hid open_attribute(const File& file, const std::string& path, const std::string& name,
                   H5T_class_t expected) {
  const Hid object(H5Oopen(file.handle().file.get(), path.c_str(), H5P_DEFAULT));
  Hid attribute(object ? H5Aopen(object.get(), name.c_str(), H5P_DEFAULT) : H5I_INVALID_HID);
  file.handle().agree(bool(attribute), subject_of(path, name), "cannot be opened");
  const Hid type(H5Aget_type(attribute.get())), space(H5Aget_space(attribute.get()));
  // A foreign or damaged file must result in a message, not in a read beyond `value`.
  const bool ok = H5Tget_class(type.get()) == expected &&
                  H5Sget_simple_extent_npoints(space.get()) == 1 &&
                  H5Tis_variable_str(type.get()) <= 0;
  file.handle().agree(ok, subject_of(path, name), "is of another type than expected");
  return attribute;
}

template <class T>
T read_scalar(const File& file, const std::string& path, const std::string& name,
              H5T_class_t expected) {
  const Hid attribute = open_attribute(file, path, name, expected);
  T value{};
  const bool ok = H5Aread(attribute.get(), native_type<T>(), &value) >= 0;
  file.handle().agree(ok, subject_of(path, name), "cannot be read");
  return value;
}

// Text beyond ASCII is marked as UTF-8, so that h5py and h5dump show it as written.
bool is_ascii(const std::string& text) {
  for (const char c : text)
    if (static_cast<unsigned char>(c) > 127) return false;
  return true;
}

}  // namespace

// Of fixed length, stored with the attribute itself; text of variable length would need a heap in
// the file.
void File::attribute(const std::string& path, const std::string& name, const std::string& value) {
  const Hid type(H5Tcopy(H5T_C_S1)), space(H5Screate(H5S_SCALAR));
  // Without a terminating zero: ParaView 5.11 compares the type of a field file with all that is
  // stored. HDF5 needs a size of at least one.
  H5Tset_size(type.get(), std::max<std::size_t>(value.size(), 1));
  H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
  H5Tset_cset(type.get(), is_ascii(value) ? H5T_CSET_ASCII : H5T_CSET_UTF8);
  write_attribute(*this, path, name, type, space, value.c_str());
}

void File::attribute(const std::string& path, const std::string& name, double value) {
  const Hid type(H5Tcopy(H5T_NATIVE_DOUBLE)), space(H5Screate(H5S_SCALAR));
  write_attribute(*this, path, name, type, space, &value);
}

void File::attribute(const std::string& path, const std::string& name, std::int64_t value) {
  const Hid type(H5Tcopy(H5T_NATIVE_INT64)), space(H5Screate(H5S_SCALAR));
  write_attribute(*this, path, name, type, space, &value);
}

void File::attribute(const std::string& path, const std::string& name,
                     const std::vector<std::int64_t>& value) {
  const hsize_t length = value.size();
  const Hid type(H5Tcopy(H5T_NATIVE_INT64)), space(H5Screate_simple(1, &length, nullptr));
  write_attribute(*this, path, name, type, space, value.data());
}

bool File::has_attribute(const std::string& path, const std::string& name) const {
  return H5Aexists_by_name(handle_->file.get(), path.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

// Of fixed length; text of other writers may be padded or terminated with zeros, which are removed.
std::string File::text_attribute(const std::string& path, const std::string& name) const {
  const Hid attribute = open_attribute(*this, path, name, H5T_STRING);
  const Hid type(H5Aget_type(attribute.get()));
  std::string text(H5Tget_size(type.get()), '\0');
  const bool ok = H5Aread(attribute.get(), type.get(), text.data()) >= 0;
  handle_->agree(ok, subject_of(path, name), "cannot be read");
  return text.substr(0, text.find('\0'));
}

double File::number_attribute(const std::string& path, const std::string& name) const {
  return read_scalar<double>(*this, path, name, H5T_FLOAT);
}

std::int64_t File::integer_attribute(const std::string& path, const std::string& name) const {
  return read_scalar<std::int64_t>(*this, path, name, H5T_INTEGER);
}

}  // namespace trackbed::io
