// SPDX-License-Identifier: BSD-2-Clause
// Names in a bpffs that keep maps and programs alive when the daemon is not.
#pragma once
#include <cstdint>
#include <expected>
#include <functional>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca::enforce {

/// Makes `path` and what is missing above it. Error: it is not in a bpffs.
Result<void> make_pin_directory(const std::string& path);

/// All names in a directory, without it, in no order. A list that is not complete is an error; a
/// directory that is not there is the error ENOENT.
std::expected<std::vector<std::string>, std::error_code> names_in(const std::string& directory);

/// The object pinned there, or an empty Fd.
Fd open_pin(const std::string& path);
/// Error EEXIST is reported as `false`.
Result<bool> pin(int fd, const std::string& path);
/// Puts a new object under a name at once, whether or not the name is in use. Error: as give_way().
Result<void> rename_pin(const std::string& from, const std::string& to);
void remove_pin(const std::string& path);

/// What has the name, for people: "a program", "a directory", "a map of type 1 …"; empty: nothing.
std::string what_is_at(const std::string& path);
/// What has the name, and does not belong there, loses it; gives what it was, as what_is_at().
/// Error: a directory that is not empty, with what is to be done; a bpffs that is read-only.
Result<std::string> give_way(const std::string& path);
/// The object that is pinned there, if it is one of ours: as `is_ours` says of its descriptor.
/// Nothing where there is none, or where what was there has given way: `was`. Error: as give_way(),
/// or it cannot be found out what it is; then it stays.
Result<Fd> open_own(const std::string& path, const std::function<bool(int)>& is_ours,
                    std::string& was);
/// Gives this object the name, whatever else has it. Where that was something, gives what it was.
Result<std::string> pin_instead(int fd, const std::string& path);
/// Other objects have other numbers of their own: what says "type 2, id 7" of a map may do so of a
/// program as well.
bool is_map(int fd);
bool is_program(int fd);
/// Removes all pins of the directory and the directory.
void remove_pin_directory(const std::string& path);

/// A map, program or link, and the name that keeps it.
struct Pin {
  int fd = -1;
  std::string path;
};
/// The name leads to this very object.
bool is_pinned(const Pin& kept);
/// Pins again what has not its name any more, or whose name is another's now: the names of those,
/// without directory, which is made where it is missing. Error: a bpffs that is read-only, or
/// something else that stands in the way; nothing of that is listed as pinned again.
Result<std::vector<std::string>> keep_pinned(std::span<const Pin> pins);

/// Value size, entries and kind of a map fit; maps that differ have another layout.
bool is_array(int map_fd, std::uint32_t value_size, std::uint32_t entries);
/// The same of one that can be mapped.
bool is_mappable_array(int map_fd, std::uint32_t value_size, std::uint32_t entries);
bool is_ring(int map_fd, std::uint32_t size);
bool is_hash(int map_fd, std::uint32_t key_size, std::uint32_t value_size);
std::uint32_t map_id(int map_fd);
std::string map_name(int map_fd);

struct ProgramInfo {
  std::uint32_t id = 0;
  std::string tag;  ///< the same for the same instructions, whatever maps they use
  std::vector<std::uint32_t> map_ids;
};
ProgramInfo program_info(int program_fd);

}  // namespace mlcca::enforce
