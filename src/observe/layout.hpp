// Groups of results.h5. Private to the module.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "trackbed/io/file.hpp"

namespace trackbed::observe {

// Groups with one level of names below; those of `named_histories` have two.
inline constexpr std::array plain_histories = {
    "history/energy", "history/sleeper", "history/traffic", "history/ground",
    "history/platen", "history/wheel",   "history/rail",    "history/body",
    "history/seat",   "history/solid",   "history/total"};

inline constexpr std::array named_histories = {"history/region", "history/wall", "history/stone",
                                               "history/surface", "history/sensor"};

// Paths of the members of a group, sorted; none if there is no such group. Names are read from the
// file, so that columns of other versions of the program are kept. Collective.
std::vector<std::string> members(const io::File& file, const std::string& group);
// Without the axes of the datasets.
std::vector<std::string> columns(const io::File& file, const std::string& group);

// All histories except time and stage.
std::vector<std::string> histories(const io::File& file);

// Gives a history, which must not have them yet, its axes (io::File::set_axis): time, and positions
// or numbers of the columns, within its own group, where readers of netCDF look for them. The
// positions must be in the file. Collective.
void set_axes_of_history(const par::Comm& comm, io::File& file, const std::string& path);
// Gives an envelope the axis of its places.
void set_axis_of_envelope(const par::Comm& comm, io::File& file, const std::string& path);
// Gives the tables that a stage has their axes: numbers of rows and columns, within their own
// group, where those that exist are shared. Collective.
void set_axes_of_snapshot(const par::Comm& comm, io::File& file, const std::string& stage);
// Those of all histories and envelopes of a new file.
void set_axes(const par::Comm& comm, io::File& file);
// Stores the meaning of the numbers in history/stage, by the conventions of CF (section 3.5).
void name_stages(io::File& file, const std::vector<std::string>& names);

}  // namespace trackbed::observe
