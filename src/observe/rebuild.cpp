// A results file as it was at a checkpoint: histories cut to its rows, pictures of later stages
// left out, since the resumed run writes them again.
// It is a copy in any case: the old file may lie in another folder, and stays whole if the new run
// is killed at once. HDF5 could cut datasets in place, but their space would be lost and a kill in
// between would leave columns of different lengths.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "observe/room.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::observe {

namespace {

// With one level of names below; those of `named_histories` have two.
constexpr std::array plain_histories = {
    "history/energy", "history/sleeper", "history/ground", "history/platen", "history/wheel",
    "history/rail",   "history/body",    "history/seat",   "history/solid",  "history/total"};

constexpr std::array named_histories = {"history/region", "history/wall", "history/stone",
                                        "history/surface"};

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
  for (const char* group : plain_histories)
    for (const std::string& path : members(from, group))
      copy_history<double>(comm, from, to, path, rows);
  for (const char* list : named_histories)
    for (const std::string& one : members(from, list))
      for (const std::string& path : members(from, one))
        copy_history<double>(comm, from, to, path, rows);
}

// By names of stages, not by time: a stage under way at the checkpoint has no snapshot yet.
void copy_snapshots(const io::File& from, io::File& to, const std::vector<std::string>& stages) {
  for (const char* place : {"sleepers/x", "ground/x"})
    if (from.has(place)) copy_table(from, to, place);
  for (const std::string& stage : stages)
    for (const char* group : {"chains/", "stones/", "surface/"})
      for (const std::string& path : members(from, group + stage)) copy_table(from, to, path);
}

// Every number, each rank its share: damage is met before anything is made or removed.
void read_through(const io::File& file) {
  for (const char* group : plain_histories)
    for (const std::string& path : members(file, group)) file.read_share<double>(path);
  for (const char* group : {"envelope/sleeper", "envelope/ground"})
    for (const std::string& path : members(file, group)) file.read_share<double>(path);
  for (const char* place : {"history/time", "sleepers/x", "ground/x", "bed/grading"})
    if (file.has(place)) file.read_share<double>(place);
  if (file.has("history/stage")) file.read_share<std::int64_t>("history/stage");
  const auto read_all_of = [&](const char* list) {
    for (const std::string& one : members(file, list))
      for (const std::string& path : members(file, one)) file.read_share<double>(path);
  };
  for (const char* list : {"chains", "stones", "surface"}) read_all_of(list);
  for (const char* list : named_histories) read_all_of(list);
}

// A resumed run replaces the file, so it must not be guessed that it may go.
[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw InputError({fmt::format(
      "{}: {}; put back a copy of it, or move it away and resume again: the run then goes on, but "
      "its histories begin at the checkpoint and those before it are lost",
      path, why)});
}

// `act` reads `path` alone. What the reader says begins with rank and file: they are said already.
template <class F>
auto reading(const std::string& path, F&& act) {
  try {
    return act();
  } catch (const RunError& error) {  // equal on all ranks
    const std::string words = error.what(), start = path + ": ";
    const std::size_t at = words.find(start);
    refuse(path, fmt::format("is damaged or no file of results ({})",
                             at == std::string::npos ? words : words.substr(at + start.size())));
  }
}

// As it is: which rows it knows is compared by who calls.
void copy_envelope(const io::File& from, io::File& to) {
  for (const char* group : {"envelope/sleeper", "envelope/ground"})
    for (const std::string& path : members(from, group)) copy_table(from, to, path);
}

}  // namespace

io::File open_results(const par::Comm& comm, const std::string& path) {
  return reading(path, [&] {
    io::File file(comm, path, io::Mode::read);
    if (file.text_attribute("/", "kind") != results_kind)
      throw RunError(path + ": it is of another kind");
    return file;
  });
}

// Rank 0 decides for all whether there is a file, because other ranks may see another state of a
// network file system.
bool has_histories(const par::Comm& comm, const std::string& path, std::int64_t rows) {
  std::error_code ignored;
  const bool there = comm.root() && std::filesystem::exists(path, ignored);
  if (comm.broadcast(there ? "there" : "").empty()) return rows == 0;
  const io::File file = open_results(comm, path);
  const auto present = reading(path, [&] {
    read_through(file);
    return static_cast<std::int64_t>(file.has("history/time") ? file.extent("history/time").at(0)
                                                              : 0);
  });
  if (present < rows)
    refuse(path, fmt::format("holds {} of the {} history rows before the checkpoint, so it is "
                             "that of another run",
                             present, rows));
  return true;
}

// A checkpoint alone is enough to go on: without the file histories begin anew. Collective.
void Results::resume(const std::string& old_path, std::int64_t rows,
                     const std::vector<std::string>& finished) {
  Room& room = *room_;
  const auto wanted = static_cast<std::size_t>(rows);
  std::error_code ignored;
  const bool there = room.comm.root() && std::filesystem::exists(old_path, ignored);
  if (room.comm.broadcast(there ? "there" : "").empty()) return;
  // Under another name until it is whole.
  const std::string part = room.path + ".part";
  {
    const io::File old = open_results(room.comm, old_path);
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
