// Restores a results file to its state at a checkpoint: histories are cut to its rows, snapshots of
// later stages are omitted, since the resumed run writes them again. The file of a finished run is
// copied in the same way, compressed.
// A copy is made in any case: the old file may be in another folder, and remains complete if the
// new run is killed at once. Rejected: cutting datasets in place, which would not free their space
// and could leave columns of different lengths if interrupted.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "observe/impl.hpp"
#include "observe/layout.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/io/replace.hpp"

namespace trackbed::observe {

namespace {

// Unit and meaning are copied with the data. They had other names up to November 2026; a dataset
// that another program has added may have none.
io::Label label_of(const io::File& file, const std::string& path) {
  const auto text = [&](const char* name, const char* former) -> std::string {
    for (const char* one : {name, former})
      if (file.has_attribute(path, one)) return file.text_attribute(path, one);
    return "";
  };
  return {text("units", "unit"), text("long_name", "meaning")};
}

// Numbers that one rank reads at a time: 32 MB.
constexpr std::size_t numbers_in_memory = 1 << 22;

// Copies the first `rows` rows of a dataset, a few at a time, each rank a fraction. Collective.
template <class T>
void copy_history(const par::Comm& comm, const io::File& from, io::File& to,
                  const std::string& path, std::size_t rows) {
  const std::size_t columns = from.extent(path).at(1);
  const io::Label label = label_of(from, path);
  const std::size_t at_once = std::max<std::size_t>(1, numbers_in_memory / columns);
  for (std::size_t done = 0; done < rows; done += at_once) {
    const auto [begin, count] =
        io::row_range(std::min(at_once, rows - done), comm.rank(), comm.size());
    to.append<T>(path, from.read_rows<T>(path, done + begin, count), columns, label);
  }
}

// Tables are not cut: they belong to a place or a finished stage as a whole.
void copy_table(const io::File& from, io::File& to, const std::string& path) {
  const std::size_t columns = from.extent(path).at(1);
  to.write<double>(path, from.read_own_rows<double>(path), columns, label_of(from, path));
}

void copy_histories(const par::Comm& comm, const io::File& from, io::File& to, std::size_t rows) {
  if (rows == 0) return;
  copy_history<double>(comm, from, to, "history/time", rows);
  copy_history<std::int64_t>(comm, from, to, "history/stage", rows);
  for (const std::string& path : histories(from)) copy_history<double>(comm, from, to, path, rows);
}

// By names of stages, not by time: a stage that was incomplete at the checkpoint has no snapshot.
void copy_snapshots(const par::Comm& comm, const io::File& from, io::File& to,
                    const std::vector<std::string>& stages) {
  for (const char* place : {"sleepers/x", "ground/x"})
    if (from.has(place)) copy_table(from, to, place);
  for (const std::string& stage : stages) {
    for (const char* group : {"chains/", "stones/", "surface/", "bonds/"})
      for (const std::string& path : columns(from, group + stage)) copy_table(from, to, path);
    set_axes_of_snapshot(comm, to, stage);
    if (const std::string breaks = "breaks/" + stage; from.has(breaks))
      copy_table(from, to, breaks);
  }
}

// Reads every number, each rank a fraction, so that damage is detected before any file is created
// or removed.
void read_through(const io::File& file) {
  for (const std::string& path : histories(file)) file.read_own_rows<double>(path);
  for (const char* group : {"envelope/sleeper", "envelope/ground"})
    for (const std::string& path : columns(file, group)) file.read_own_rows<double>(path);
  for (const char* place : {"history/time", "sleepers/x", "ground/x", "bed/grading"})
    if (file.has(place)) file.read_own_rows<double>(place);
  if (file.has("history/stage")) file.read_own_rows<std::int64_t>("history/stage");
  for (const char* list : {"chains", "stones", "surface", "bonds"})
    for (const std::string& one : members(file, list))
      for (const std::string& path : columns(file, one)) file.read_own_rows<double>(path);
  for (const std::string& path : members(file, "breaks")) file.read_own_rows<double>(path);
}

// A resumed run replaces the file, so the user has to decide what becomes of it.
[[noreturn]] void reject(const std::string& path, const std::string& why) {
  throw InputError({fmt::format(
      "{}: {}; restore this file from a copy; to resume a run without this file, move it away: the "
      "histories then begin at the checkpoint, and all earlier rows are lost",
      path, why)});
}

// `act` reads `path`. Messages of the reader begin with rank and file, which are removed here
// because the message names the file already.
template <class F>
auto reading(const std::string& path, F&& act) {
  try {
    return act();
  } catch (const RunError& error) {  // equal on all ranks
    const std::string words = error.what(), start = path + ": ";
    const std::size_t at = words.find(start);
    if (at == std::string::npos) throw;  // of another file
    reject(path, fmt::format("is damaged or is not a file of results ({})",
                             words.substr(at + start.size())));
  }
}

// An envelope that covers later rows is omitted.
void copy_envelope(const io::File& from, io::File& to, std::size_t rows) {
  if (!from.has("envelope")) return;
  const std::int64_t covered = from.integer_attribute("envelope", "rows");
  if (covered > static_cast<std::int64_t>(rows)) return;
  for (const char* group : {"envelope/sleeper", "envelope/ground"})
    for (const std::string& path : columns(from, group)) copy_table(from, to, path);
  to.attribute("envelope", "rows", covered);
  if (from.has_attribute("envelope", "stage"))
    to.attribute("envelope", "stage", from.integer_attribute("envelope", "stage"));
}

// `rows` of the histories, and the snapshots of the finished `stages`. Collective.
void copy_results(const par::Comm& comm, const io::File& from, io::File& to, std::size_t rows,
                  const std::vector<std::string>& stages) {
  copy_histories(comm, from, to, rows);
  copy_snapshots(comm, from, to, stages);
  copy_envelope(from, to, rows);
  set_axes(comm, to);
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

// Rank 0 decides for all whether there is a file, because a network file system may differ between
// ranks.
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
    reject(path, fmt::format("has only {} of the {} history rows before the checkpoint, so it "
                             "belongs to another run",
                             present, rows));
  return true;
}

// A checkpoint alone is sufficient for a restart: without the file the histories start again.
// Collective.
void Results::resume(const std::string& old_path, std::int64_t rows,
                     const std::vector<std::string>& finished) {
  Impl& impl = *impl_;
  const auto wanted = static_cast<std::size_t>(rows);
  std::error_code ignored;
  const bool there = impl.comm.root() && std::filesystem::exists(old_path, ignored);
  if (impl.comm.broadcast(there ? "there" : "").empty()) return;
  // Under another name until it is complete.
  const std::string part = impl.twin_path();
  try {
    reading(old_path, [&] {
      const io::File old = open_results(impl.comm, old_path);
      io::File file(impl.comm, part, io::Mode::create);
      impl.put_head(file);
      copy_results(impl.comm, old, file, wanted, finished);
      file.close();
    });
  } catch (const std::exception&) {  // the same on all ranks
    if (impl.comm.root()) std::filesystem::remove(part, ignored);
    throw;
  }
  impl.take_name(part);
  impl.resumed = true;
  impl.rows = rows;
}

// By one rank: see io::File::compress. The twin, which a reader may still have open, is removed and
// not overwritten.
std::string Results::compress() {
  flush();
  Impl& impl = *impl_;
  std::error_code ignored;
  if (impl.has_twin && impl.comm.root()) std::filesystem::remove(impl.twin_path(), ignored);
  impl.has_twin = false;
  try {
    io::replace_file_on_root(impl.comm, impl.path, [&](const std::string& part) {
      const par::Comm self = par::Comm::self();
      const io::File old(self, impl.path, io::Mode::read);
      io::File file(self, part, io::Mode::create);
      file.compress();
      impl.put_head(file);
      copy_results(self, old, file, static_cast<std::size_t>(impl.rows), impl.recorded.stages);
      if (impl.rows > 0) name_stages(file, impl.recorded.stages);
      file.close();
    });
  } catch (const RunError& failure) {  // the same on all ranks
    return failure.what();
  }
  return "";
}

}  // namespace trackbed::observe
