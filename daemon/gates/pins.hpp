// SPDX-License-Identifier: BSD-2-Clause
// Pins: names in a bpffs that keep maps and programs alive without the daemon.
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

namespace mlcca::gates {

/// Makes the directory `path` and its missing parents. The error: it is not in a bpffs.
Result<void> make_pin_directory(const std::string& path);

/// All names in a directory, without the directory and in no order. An incomplete list is an error;
/// a missing directory is the error ENOENT.
std::expected<std::vector<std::string>, std::error_code> names_in(const std::string& directory);

/// The object that is pinned at `path`; an empty Fd if there is none.
Fd open_pin(const std::string& path);
/// Pins an object. False if the name is in use (EEXIST).
Result<bool> pin(int fd, const std::string& path);
/// Moves a pin to another name in one step, whether or not that name is in use. Errors as
/// give_way().
Result<void> rename_pin(const std::string& from, const std::string& to);
void remove_pin(const std::string& path);

/// A description of what has the name: "a program", "a directory", "a map of type 1 …"; empty:
/// nothing.
std::string what_is_at(const std::string& path);
/// Removes what has the name and does not belong there. Returns what it was, as what_is_at(). The
/// error: a directory that is not empty, with what to do about it; a bpffs that is read-only.
Result<std::string> give_way(const std::string& path);
/// The object that is pinned at `path`, if `is_ours` accepts its descriptor. An empty Fd if there
/// is none, or if what was there was removed; then `was` says what it was. Errors as give_way(); or
/// it cannot be found out what it is, and it stays.
Result<Fd> open_own(const std::string& path, const std::function<bool(int)>& is_ours,
                    std::string& was);
/// Gives this object the name. Returns what had the name before and was replaced; empty if nothing
/// had.
Result<std::string> pin_instead(int fd, const std::string& path);
/// Whether the descriptor is a map, or a program. The two have separate numbers, so "type 2, id 7"
/// alone may describe either.
bool is_map(int fd);
bool is_program(int fd);
/// Removes all pins of the directory, and the directory.
void remove_pin_directory(const std::string& path);

/// A map, program or link, and the path of the pin that keeps it.
struct Pin {
  int fd = -1;
  std::string path;
};
/// Whether the path leads to this very object.
bool is_pinned(const Pin& kept);
/// Pins again the objects whose pin is missing or names another object. Returns their names without
/// the directory, which is made if it is missing. The error: a read-only bpffs, or something else
/// is in the way; then no names are returned.
Result<std::vector<std::string>> keep_pinned(std::span<const Pin> pins);

/// Whether the kind, value size and entries of a map fit. Maps that differ have another layout.
bool is_array(int map_fd, std::uint32_t value_size, std::uint32_t entries);
/// The same for a map that can be mapped into memory.
bool is_mappable_array(int map_fd, std::uint32_t value_size, std::uint32_t entries);
bool is_ring(int map_fd, std::uint32_t size);
bool is_hash(int map_fd, std::uint32_t key_size, std::uint32_t value_size);
std::uint32_t map_id(int map_fd);
std::string map_name(int map_fd);

/// What the kernel reports about a loaded program.
struct ProgramInfo {
  std::uint32_t id = 0;
  std::string tag;  ///< the same for the same instructions, whatever maps they use
  std::vector<std::uint32_t> map_ids;
};
ProgramInfo program_info(int program_fd);

}  // namespace mlcca::gates
