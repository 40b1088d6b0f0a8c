// Axes of datasets as HDF5 dimension scales, and names of one dataset in several groups. All calls
// are collective: all ranks pass the same values, as parallel HDF5 requires for changes to
// metadata.
//
// The library stores in each dataset a reference to its axes and in each axis the references to all
// its datasets, and rewrites the latter with each dataset: quadratic in the number of datasets, of
// which most results have some hundred, and each stone that a deck places by name adds eleven.
#include <hdf5_hl.h>

#include "io/handle.hpp"

namespace trackbed::io {

namespace {

std::string subject_of(const std::string& path, std::size_t dimension) {
  return "dimension " + std::to_string(dimension) + " of dataset " + path;
}

}  // namespace

// The name of an axis is that of the dimension for readers of netCDF, which take it from the path,
// too.
void File::make_axis(const std::string& axis) {
  const Dataset dataset = open_dataset(*handle_, axis);
  const hid_t id = dataset.id.get();
  const std::string name = axis.substr(axis.rfind('/') + 1);
  handle_->agree(H5DSis_scale(id) > 0 || H5DSset_scale(id, name.c_str()) >= 0, "dataset " + axis,
                 "cannot be made an HDF5 dimension scale");
}

void File::set_axis(const std::string& path, std::size_t dimension, const std::string& axis) {
  make_axis(axis);
  const Dataset dataset = open_dataset(*handle_, path), scale = open_dataset(*handle_, axis);
  handle_->agree(
      H5DSattach_scale(dataset.id.get(), scale.id.get(), static_cast<unsigned>(dimension)) >= 0,
      subject_of(path, dimension), "cannot be attached to the HDF5 dimension scale " + axis);
}

bool File::has_axis(const std::string& path, std::size_t dimension) const {
  const Dataset dataset = open_dataset(*handle_, path);
  const int axes = H5DSget_num_scales(dataset.id.get(), static_cast<unsigned>(dimension));
  handle_->agree(axes >= 0, subject_of(path, dimension), "cannot be read");
  return axes > 0;
}

bool File::is_axis(const std::string& path) const {
  return H5DSis_scale(open_dataset(*handle_, path).id.get()) > 0;
}

void File::link(const std::string& path, const std::string& existing) {
  const hid_t file = handle_->file.get();
  const Hid links(H5Pcreate(H5P_LINK_CREATE));
  H5Pset_create_intermediate_group(links.get(), 1);
  const bool ok =
      H5Lcreate_hard(file, existing.c_str(), file, path.c_str(), links.get(), H5P_DEFAULT) >= 0;
  handle_->agree(ok, "dataset " + existing, "cannot have the second name " + path);
}

}  // namespace trackbed::io
