// Layout behind the end of the HDF5 file: the extents (offset, bytes) in ascending order, then the
// foot. Nothing read from a file is believed before it is checked: a damaged count must not ask
// for memory, a damaged extent must not hide bytes.
// The seal is stored as it stands in memory: on a machine of the other byte order a file is refused
// as damaged.
#include "io/seal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <fstream>

#include "io/handle.hpp"
#include "trackbed/core/hash.hpp"

namespace trackbed::io {

namespace {

// Written after the list of extents, as it stands in memory.
// The magic is last in the file, where a reader looks first.
struct Foot {
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

// Hash of all bytes outside of the extents, and of the extents themselves.
// Cost: one pass over the structure; the numbers are jumped over.
std::uint64_t structure_hash(std::ifstream& in, std::uint64_t file_bytes,
                             std::vector<Extent> extents) {
  std::uint64_t hash = hash_bytes(extents.data(), extents.size() * sizeof(Extent));
  // An empty extent at the end: the loop hashes the gap in front of each.
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

// Ascending, apart from each other and inside the file: only then may they be used.
bool plausible(const std::vector<Extent>& extents, std::uint64_t file_bytes) {
  std::uint64_t at = 0;
  for (const Extent& extent : extents) {
    if (extent.offset < at || extent.offset > file_bytes) return false;
    if (extent.bytes > file_bytes - extent.offset) return false;
    at = extent.offset + extent.bytes;
  }
  return true;
}

// HDF5 File Format Specification 3.0, section II.A, superblock 2: where its own part of the file
// should end; the seal lies behind it.
std::string cut_or_foreign(std::ifstream& in, std::uint64_t present) {
  constexpr std::streamoff end_of_file_at = 28;
  std::uint64_t expected = 0;
  in.seekg(end_of_file_at);
  in.read(reinterpret_cast<char*>(&expected), sizeof expected);
  if (!in || present > expected) return "is cut short";
  if (present < expected)
    return fmt::format("is cut short ({} of more than {} bytes)", present, expected);
  return "is not a trackbed checkpoint (or its last bytes are missing)";
}

}  // namespace

std::vector<std::string> datasets_of(const File& file) {
  std::vector<std::string> paths;
  const bool ok = H5Ovisit2(file.handle().file.get(), H5_INDEX_NAME, H5_ITER_INC, collect_dataset,
                            &paths, H5O_INFO_BASIC) >= 0;
  file.handle().agree(ok, "", "cannot be listed");
  std::sort(paths.begin(), paths.end());
  return paths;
}

// Needs contiguous datasets; see create_dataset.
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

// Appended bytes lie behind the end that the superblock states: HDF5 never looks there.
std::string seal(const std::string& path, const std::vector<Extent>& extents) {
  Foot foot;
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  const std::string unreadable = path + ": cannot be read back";
  // Lengths are only computed from a file that is there and holds all that was written: others may
  // have removed or cut it since.
  if (!in) return fmt::format("{} ({})", unreadable, std::strerror(errno));
  foot.file_bytes = static_cast<std::uint64_t>(in.tellg());
  if (!plausible(extents, foot.file_bytes)) return unreadable + " (it is shorter than its data)";
  foot.extents = extents.size();
  foot.hash = structure_hash(in, foot.file_bytes, extents);
  if (!in) return unreadable;
  std::ofstream out(path, std::ios::binary | std::ios::app);
  out.write(reinterpret_cast<const char*>(extents.data()),
            static_cast<std::streamsize>(extents.size() * sizeof(Extent)));
  out.write(reinterpret_cast<const char*>(&foot), sizeof foot);
  out.close();
  return out ? "" : path + ": cannot be completed (" + std::strerror(errno) + ")";
}

// From the outside in: is there a file, is it HDF5, is there a foot, do foot and length agree, do
// the extents, does the hash. The first "no" is the sentence.
std::string why_not_whole(const std::string& path) {
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
  Foot foot;
  if (present < sizeof foot) return "is cut short";
  in.seekg(static_cast<std::streamoff>(present - sizeof foot));
  in.read(reinterpret_cast<char*>(&foot), sizeof foot);
  if (std::memcmp(foot.magic, Foot{}.magic, sizeof foot.magic) != 0)
    return cut_or_foreign(in, present);
  const std::uint64_t room = present - sizeof foot;
  constexpr const char* damaged = "is damaged: its structure does not match its seal";
  // By division: a product of a damaged count could wrap around and look right.
  if (foot.extents > room / sizeof(Extent) ||
      foot.file_bytes != room - foot.extents * sizeof(Extent))
    return damaged;
  std::vector<Extent> extents(foot.extents);
  in.seekg(static_cast<std::streamoff>(foot.file_bytes));
  in.read(reinterpret_cast<char*>(extents.data()),
          static_cast<std::streamsize>(extents.size() * sizeof(Extent)));
  if (!plausible(extents, foot.file_bytes)) return damaged;
  const std::uint64_t hash = structure_hash(in, foot.file_bytes, extents);
  return in && hash == foot.hash ? "" : damaged;
}

}  // namespace trackbed::io
