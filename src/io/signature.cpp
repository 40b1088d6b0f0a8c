#include "io/signature.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "io/handle.hpp"
#include "trackbed/core/hash.hpp"

namespace trackbed::io {

namespace {

struct Object {
  std::string path;
  H5O_type_t type;
};

herr_t collect_object(hid_t, const char* name, const H5O_info_t* info, void* objects) {
  const std::string path = std::string(name) == "." ? "/" : fmt::format("/{}", name);
  static_cast<std::vector<Object>*>(objects)->push_back({path, info->type});
  return 0;
}

std::vector<Object> objects_of(const File& file) {
  std::vector<Object> objects;
  const bool ok = H5Ovisit2(file.handle().file.get(), H5_INDEX_NAME, H5_ITER_INC, collect_object,
                            &objects, H5O_INFO_BASIC) >= 0;
  file.handle().agree(ok, "", "cannot be listed");
  std::sort(objects.begin(), objects.end(),
            [](const Object& a, const Object& b) { return a.path < b.path; });
  return objects;
}

void add(std::uint64_t& hash, const std::string& text) {
  hash = hash_bytes(text.c_str(), text.size() + 1, hash);
}

bool add_attribute(std::uint64_t& hash, hid_t object, const std::string& name) {
  const Hid attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT));
  if (!attribute) return false;
  const Hid type(H5Aget_type(attribute.get())), space(H5Aget_space(attribute.get()));
  const hssize_t count = H5Sget_simple_extent_npoints(space.get());
  if (!type || count < 0 || H5Tis_variable_str(type.get()) > 0) return false;
  std::vector<std::byte> value(H5Tget_size(type.get()) * static_cast<std::size_t>(count));
  if (!value.empty() && H5Aread(attribute.get(), type.get(), value.data()) < 0) return false;
  add(hash, name + " " + type_name(type.get()));
  hash = hash_bytes(value.data(), value.size(), hash);
  return true;
}

herr_t collect_attribute(hid_t, const char* name, const H5A_info_t*, void* names) {
  static_cast<std::vector<std::string>*>(names)->emplace_back(name);
  return 0;
}

bool add_attributes(std::uint64_t& hash, hid_t object, bool is_root) {
  std::vector<std::string> names;
  if (H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect_attribute, &names) < 0)
    return false;
  std::sort(names.begin(), names.end());
  for (const std::string& name : names)
    if (!(is_root && name == signature_name) && !add_attribute(hash, object, name)) return false;
  return true;
}

}  // namespace

std::vector<std::string> datasets_of(const File& file) {
  std::vector<std::string> paths;
  for (const Object& object : objects_of(file))
    if (object.type == H5O_TYPE_DATASET) paths.push_back(object.path);
  return paths;
}

bool has_attribute(const File& file, const std::string& path, const std::string& name) {
  return H5Aexists_by_name(file.handle().file.get(), path.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

std::uint64_t signature(const File& file) {
  std::uint64_t hash = hash_bytes("", 0);
  for (const Object& object : objects_of(file)) {
    add(hash, object.path);
    const Hid id(H5Oopen(file.handle().file.get(), object.path.c_str(), H5P_DEFAULT));
    const bool ok = id && add_attributes(hash, id.get(), object.path == "/");
    file.handle().agree(ok, object.path, "has attributes that cannot be read");
    if (object.type != H5O_TYPE_DATASET) continue;
    const Dataset dataset = open_dataset(file.handle(), object.path);
    add(hash, std::to_string(dataset.rows) + "x" + std::to_string(dataset.columns) + " " +
                  type_name(dataset.type.get()));
  }
  return hash;
}

}  // namespace trackbed::io
