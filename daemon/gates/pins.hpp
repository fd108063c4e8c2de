// SPDX-License-Identifier: BSD-2-Clause
// Names in a bpffs that keep maps and programs alive when the daemon is not.
#pragma once
#include <cstdint>
#include <expected>
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
/// Puts a new object under a name at once, whether or not the name is in use.
Result<void> rename_pin(const std::string& from, const std::string& to);
void remove_pin(const std::string& path);
/// Removes all pins of the directory and the directory.
void remove_pin_directory(const std::string& path);

/// A map, program or link, and the name that keeps it.
struct Pin {
  int fd = -1;
  std::string path;
};
/// Pins again what has not its name any more, or whose name is another's now: the names of those,
/// without directory, which is made where it is missing. Error: a bpffs that is read-only, or
/// something else that stands in the way; nothing of that is listed as pinned again.
Result<std::vector<std::string>> keep_pinned(std::span<const Pin> pins);

/// Value size, entries and kind of a map fit; maps that differ have another layout.
bool is_mappable_array(int map_fd, std::uint32_t value_size, std::uint32_t entries);
std::uint32_t map_id(int map_fd);

struct ProgramInfo {
  std::uint32_t id = 0;
  std::string tag;  ///< the same for the same instructions, whatever maps they use
  std::vector<std::uint32_t> map_ids;
};
ProgramInfo program_info(int program_fd);

}  // namespace mlcca::enforce
