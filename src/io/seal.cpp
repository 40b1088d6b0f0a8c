// Layout after the end of the HDF5 file: the extents (offset, bytes) in ascending order, then the
// footer. Nothing read from a file is used before it is checked: a damaged count must not cause an
// allocation, a damaged extent must not exclude bytes from the hash. The seal is stored in the byte
// order of the machine: on a machine of the other byte order a file is refused as damaged.
#include "io/seal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <fstream>

#include "io/handle.hpp"
#include "trackbed/core/hash.hpp"

namespace trackbed::io {

namespace {

// Footer, written after the list of extents as it is in memory. The magic number is last in the
// file, where a reader looks first.
struct Footer {
  std::uint64_t extents = 0;     // how many
  std::uint64_t file_bytes = 0;  // before the seal
  std::uint64_t hash = 0;
  char magic[8] = {'t', 'b', 's', 'e', 'a', 'l', '0', '1'};
};

herr_t collect_dataset(hid_t, const char* name, const H5O_info_t* info, void* paths) {
  if (info->type == H5O_TYPE_DATASET)
    static_cast<std::vector<std::string>*>(paths)->push_back(fmt::format("/{}", name));
  return 0;
}

// Hash of all bytes outside of the extents, and of the extents themselves. Cost: one pass over the
// structure; the numbers are skipped.
std::uint64_t structure_hash(std::ifstream& in, std::uint64_t file_bytes,
                             std::vector<Extent> extents) {
  std::uint64_t hash = hash_bytes(extents.data(), extents.size() * sizeof(Extent));
  // An empty extent at the end: the loop hashes the gap before each extent.
  extents.push_back({file_bytes, 0});
  std::vector<char> buffer;
  std::uint64_t at = 0;
  for (const Extent& extent : extents) {
    buffer.resize(extent.offset - at);
    in.seekg(static_cast<std::streamoff>(at));
    in.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    hash = hash_bytes(buffer.data(), buffer.size(), hash);
    at = extent.offset + extent.bytes;
  }
  return hash;
}

// Extents are used only if they are ascending, disjoint and inside the file.
bool plausible(const std::vector<Extent>& extents, std::uint64_t file_bytes) {
  std::uint64_t at = 0;
  for (const Extent& extent : extents) {
    if (extent.offset < at || extent.offset > file_bytes) return false;
    if (extent.bytes > file_bytes - extent.offset) return false;
    at = extent.offset + extent.bytes;
  }
  return true;
}

// HDF5 File Format Specification 3.0, section II.A, superblock 2: the expected end of the HDF5 part
// of the file; the seal follows it.
std::string cut_or_foreign(std::ifstream& in, std::uint64_t present) {
  constexpr std::streamoff end_of_file_at = 28;
  std::uint64_t expected = 0;
  in.seekg(end_of_file_at);
  in.read(reinterpret_cast<char*>(&expected), sizeof expected);
  if (!in || present > expected) return "is cut short";
  if (present < expected)
    return fmt::format("is cut short (it has {} bytes and should have more than {})", present,
                       expected);
  return "is not a trackbed checkpoint (or its last bytes are missing)";
}

}  // namespace

std::vector<std::string> datasets_of(const File& file) {
  std::vector<std::string> paths;
  const bool ok = H5Ovisit2(file.handle().file.get(), H5_INDEX_NAME, H5_ITER_INC, collect_dataset,
                            &paths, H5O_INFO_BASIC) >= 0;
  file.handle().agree(ok, "", "the list of its datasets cannot be read");
  std::sort(paths.begin(), paths.end());
  return paths;
}

// Requires contiguous datasets; see create_dataset.
std::vector<Extent> extents_of(const File& file) {
  std::vector<Extent> extents;
  for (const std::string& path : datasets_of(file)) {
    const Dataset dataset = open_dataset(file.handle(), path);
    const haddr_t offset = H5Dget_offset(dataset.id.get());
    // Growing datasets have no single place: they have no checksum either and are refused.
    if (offset == HADDR_UNDEF || dataset.rows == 0) continue;
    extents.push_back({offset, dataset.rows * dataset.row_bytes()});
  }
  std::sort(extents.begin(), extents.end(),
            [](const Extent& a, const Extent& b) { return a.offset < b.offset; });
  return extents;
}

// The appended bytes are beyond the end stated in the superblock, which HDF5 does not read.
std::string seal(const std::string& path, const std::vector<Extent>& extents) {
  Footer footer;
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  const std::string unreadable = path + ": cannot be read back";
  // Lengths are computed only if the file exists and is complete: another process may have removed
  // or truncated it since.
  if (!in) return fmt::format("{} ({})", unreadable, std::strerror(errno));
  footer.file_bytes = static_cast<std::uint64_t>(in.tellg());
  if (!plausible(extents, footer.file_bytes))
    return unreadable + " (it is shorter than the data written to it)";
  footer.extents = extents.size();
  footer.hash = structure_hash(in, footer.file_bytes, extents);
  if (!in) return unreadable;
  std::ofstream out(path, std::ios::binary | std::ios::app);
  out.write(reinterpret_cast<const char*>(extents.data()),
            static_cast<std::streamsize>(extents.size() * sizeof(Extent)));
  out.write(reinterpret_cast<const char*>(&footer), sizeof footer);
  out.close();
  return out ? "" : path + ": cannot be completed (" + std::strerror(errno) + ")";
}

// Checks in this order: the file exists, is HDF5, has a footer, footer and length agree, the
// extents are valid, the hash agrees. The first failed check gives the message.
std::string defect_of(const std::string& path) {
  constexpr char hdf5_magic[] = "\211HDF\r\n\032\n";
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) return "cannot be read";
  const auto present = static_cast<std::uint64_t>(in.tellg());
  if (present == 0) return "is empty";
  char head[8] = {};
  const auto compared = std::min<std::uint64_t>(present, sizeof head);
  in.seekg(0);
  in.read(head, static_cast<std::streamsize>(compared));
  if (std::memcmp(head, hdf5_magic, compared) != 0) return "is not a trackbed checkpoint";
  Footer footer;
  if (present < sizeof footer) return "is cut short";
  in.seekg(static_cast<std::streamoff>(present - sizeof footer));
  in.read(reinterpret_cast<char*>(&footer), sizeof footer);
  if (std::memcmp(footer.magic, Footer{}.magic, sizeof footer.magic) != 0)
    return cut_or_foreign(in, present);
  const std::uint64_t available = present - sizeof footer;
  constexpr const char* damaged =
      "is damaged: its structure does not match the checksum at its end; an earlier checkpoint of "
      "the run may be intact";
  // By division: the product with a damaged count could overflow and appear correct.
  if (footer.extents > available / sizeof(Extent) ||
      footer.file_bytes != available - footer.extents * sizeof(Extent))
    return damaged;
  std::vector<Extent> extents(footer.extents);
  in.seekg(static_cast<std::streamoff>(footer.file_bytes));
  in.read(reinterpret_cast<char*>(extents.data()),
          static_cast<std::streamsize>(extents.size() * sizeof(Extent)));
  if (!plausible(extents, footer.file_bytes)) return damaged;
  const std::uint64_t hash = structure_hash(in, footer.file_bytes, extents);
  return in && hash == footer.hash ? "" : damaged;
}

}  // namespace trackbed::io
