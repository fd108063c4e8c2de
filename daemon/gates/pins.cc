// SPDX-License-Identifier: BSD-2-Clause
// Thin over the bpf system call and the file system.
#include "daemon/gates/pins.hpp"

#include <bpf/bpf.h>
#include <fmt/format.h>
#include <linux/magic.h>
#include <sys/vfs.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "daemon/gates/failure.hpp"

namespace mlcca::enforce {

namespace {

/// Where the mount unit of the service has it: --bpf-root without a word.
constexpr std::string_view kUsualRoot = "/run/mlcca/bpf";

}  // namespace

Result<void> make_pin_directory(const std::string& path) {
  std::error_code error;
  std::filesystem::path there(path);
  while (!std::filesystem::exists(there, error) && there.has_relative_path())
    there = there.parent_path();
  struct statfs info{};
  if (statfs(there.c_str(), &info) != 0) return failure("statfs " + there.string(), errno);
  if (info.f_type != BPF_FS_MAGIC)
    return fail(
        path.starts_with(kUsualRoot)
            ? fmt::format("{} is no bpffs: systemctl start run-mlcca-bpf.mount", kUsualRoot)
            : fmt::format("{} is on no bpffs: mount one (mount -t bpf bpf DIRECTORY) and name "
                          "it by --bpf-root, or leave that out for {}",
                          path, kUsualRoot));
  std::filesystem::create_directories(path, error);
  if (error) return failure("mkdir " + path, error.value());
  return {};
}

std::expected<std::vector<std::string>, std::error_code> names_in(const std::string& directory) {
  std::vector<std::string> names;
  std::error_code error;
  // A loop over the range would throw where a later entry cannot be read.
  for (std::filesystem::directory_iterator at(directory, error);
       !error && at != std::filesystem::directory_iterator(); at.increment(error))
    names.push_back(at->path().filename());
  if (error) return std::unexpected(error);
  return names;
}

Fd open_pin(const std::string& path) { return Fd(bpf_obj_get(path.c_str())); }

Result<bool> pin(int fd, const std::string& path) {
  if (bpf_obj_pin(fd, path.c_str()) == 0) return true;
  if (errno == EEXIST) return false;
  return failure("pin " + path, errno);
}

Result<void> rename_pin(const std::string& from, const std::string& to) {
  if (std::rename(from.c_str(), to.c_str()) != 0) return failure("rename " + from, errno);
  return {};
}

void remove_pin(const std::string& path) {
  std::error_code ignored;
  std::filesystem::remove(path, ignored);
}

void remove_pin_directory(const std::string& path) {
  std::error_code ignored;
  std::filesystem::remove_all(path, ignored);
}

namespace {

/// What the kernel says first of a map, program or link.
struct Object {
  std::uint32_t type = 0;
  std::uint32_t id = 0;
  bool operator==(const Object&) const = default;
};
Object object_of(int fd) {
  Object object;
  std::uint32_t size = sizeof(object);
  if (bpf_obj_get_info_by_fd(fd, &object, &size) != 0) return {};
  return object;
}

bpf_map_info map_info(int fd) {
  bpf_map_info info{};
  std::uint32_t size = sizeof(info);
  if (bpf_obj_get_info_by_fd(fd, &info, &size) != 0) return {};
  return info;
}

}  // namespace

Result<std::vector<std::string>> keep_pinned(std::span<const Pin> pins) {
  std::vector<std::string> again;
  for (const Pin& kept : pins) {
    const std::filesystem::path path(kept.path);
    const Fd there = open_pin(kept.path);
    if (there && object_of(there.get()) == object_of(kept.fd)) continue;
    if (auto made = make_pin_directory(path.parent_path()); !made)
      return std::unexpected(made.error());
    std::error_code error;
    std::filesystem::remove(path, error);
    if (error) return failure("pin " + kept.path + " anew", error.value());
    const auto pinned = pin(kept.fd, kept.path);
    if (!pinned) return std::unexpected(pinned.error());
    if (!*pinned) return fail("pin " + kept.path + ": somebody else pins there at this moment");
    again.push_back(path.filename());
  }
  return again;
}

bool is_mappable_array(int map_fd, std::uint32_t value_size, std::uint32_t entries) {
  const auto info = map_info(map_fd);
  return info.type == BPF_MAP_TYPE_ARRAY && info.key_size == sizeof(std::uint32_t) &&
         info.value_size == value_size && info.max_entries == entries &&
         (info.map_flags & BPF_F_MMAPABLE) != 0;
}

std::uint32_t map_id(int map_fd) { return map_info(map_fd).id; }

ProgramInfo program_info(int program_fd) {
  std::array<std::uint32_t, 16> maps{};
  bpf_prog_info info{};
  info.nr_map_ids = maps.size();
  info.map_ids = reinterpret_cast<std::uintptr_t>(maps.data());
  std::uint32_t size = sizeof(info);
  if (bpf_obj_get_info_by_fd(program_fd, &info, &size) != 0) return {};
  const std::size_t count = std::min<std::size_t>(info.nr_map_ids, maps.size());
  std::string tag;
  for (const auto byte : info.tag) tag += fmt::format("{:02x}", byte);
  return {.id = info.id,
          .tag = std::move(tag),
          .map_ids = {maps.begin(), maps.begin() + static_cast<std::ptrdiff_t>(count)}};
}

}  // namespace mlcca::enforce
