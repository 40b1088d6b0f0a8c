// A results file as it was at a checkpoint: histories cut to its rows, pictures of later stages
// left out, since the resumed run writes them again.
// It is a copy in any case: the old file may lie in another folder, and stays whole if the new run
// is killed at once. HDF5 could cut datasets in place, but their space would be lost and a kill in
// between would leave columns of different lengths.
#include <algorithm>
#include <filesystem>

#include "observe/room.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::observe {

namespace {

// Unit and meaning go along: the copy is as readable as the file.
io::Label label_of(const io::File& file, const std::string& path) {
  return {file.text_attribute(path, "unit"), file.text_attribute(path, "meaning")};
}

// A dataset's share of this rank, out of the first `rows` rows.
// Collective; the copy grows by one append, of any number of ranks.
template <class T>
void copy_history(const par::Comm& comm, const io::File& from, io::File& to,
                  const std::string& path, std::size_t rows) {
  const auto [begin, count] = io::share(rows, comm.rank(), comm.size());
  const std::size_t columns = from.extent(path).at(1);
  to.append<T>(path, from.read_rows<T>(path, begin, count), columns, label_of(from, path));
}

// Tables have no end to cut: they belong to a place or a finished stage as a whole.
void copy_table(const io::File& from, io::File& to, const std::string& path) {
  const std::size_t columns = from.extent(path).at(1);
  to.write<double>(path, from.read_share<double>(path), columns, label_of(from, path));
}

// Names are asked, not known: a file of another version may hold columns that this one does not
// make, and keeps them.
std::vector<std::string> members(const io::File& file, const std::string& group) {
  std::vector<std::string> paths;
  if (file.has(group))
    for (const std::string& name : file.names(group)) paths.push_back(group + "/" + name);
  return paths;
}

void copy_histories(const par::Comm& comm, const io::File& from, io::File& to, std::size_t rows) {
  if (rows == 0) return;
  copy_history<double>(comm, from, to, "history/time", rows);
  copy_history<std::int64_t>(comm, from, to, "history/stage", rows);
  for (const char* group : {"history/energy", "history/sleeper", "history/ground"})
    for (const std::string& path : members(from, group))
      copy_history<double>(comm, from, to, path, rows);
  for (const std::string& region : members(from, "history/region"))
    for (const std::string& path : members(from, region))
      copy_history<double>(comm, from, to, path, rows);
}

// By names of stages, not by time: a stage under way at the checkpoint has no snapshot yet.
void copy_snapshots(const io::File& from, io::File& to, const std::vector<std::string>& stages) {
  for (const char* place : {"sleepers/x", "ground/x"})
    if (from.has(place)) copy_table(from, to, place);
  for (const std::string& stage : stages)
    for (const char* group : {"chains/", "stones/"})
      for (const std::string& path : members(from, group + stage)) copy_table(from, to, path);
}

// As it is: which rows it knows is compared by who calls.
void copy_envelope(const io::File& from, io::File& to) {
  for (const char* group : {"envelope/sleeper", "envelope/ground"})
    for (const std::string& path : members(from, group)) copy_table(from, to, path);
}

}  // namespace

// Collective. Rows of the checkpoint that the file does not have mean that it is not the file of
// that run.
void Results::resume(const std::string& old_path, std::int64_t rows,
                     const std::vector<std::string>& finished) {
  Room& room = *room_;
  const auto wanted = static_cast<std::size_t>(rows);
  std::int64_t there = 0;
  if (room.comm.root()) there = std::filesystem::exists(old_path) ? 1 : 0;
  // A checkpoint alone is enough to go on: rank 0 decides for all whether there is a file, because
  // other ranks may see another state of a network file system.
  if (room.comm.max(there) == 0) return;  // histories begin anew
  // Under another name until it is whole.
  const std::string part = room.path + ".part";
  {
    const io::File old(room.comm, old_path, io::Mode::read);
    const std::size_t present = old.has("history/time") ? old.extent("history/time").at(0) : 0;
    if (present < wanted) return;  // of another run: begin anew
    io::File file(room.comm, part, io::Mode::create);
    room.put_head(file);
    copy_histories(room.comm, old, file, wanted);
    copy_snapshots(old, file, finished);
    const bool with_envelope =
        old.has("envelope") && old.integer_attribute("envelope", "rows") <= rows;
    if (with_envelope) copy_envelope(old, file);
    if (with_envelope)
      file.attribute("envelope", "rows", old.integer_attribute("envelope", "rows"));
    file.close();
  }
  room.take_name(part);
  room.goes_on = true;
  room.rows = rows;
}

}  // namespace trackbed::observe
