// SPDX-License-Identifier: BSD-2-Clause
// Thin wrappers of the bpf system call and the file system.
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

#include "base/many.hpp"
#include "daemon/gates/failure.hpp"

namespace mlcca::gates {

namespace {

constexpr int kTries = 4;

/// The bpffs that the mount unit of the service makes, and the default of --bpf-root.
constexpr std::string_view kUsualRoot = "/run/mlcca/bpf";

bpf_map_info map_info(int fd) {
  bpf_map_info info{};
  std::uint32_t size = sizeof(info);
  if (bpf_obj_get_info_by_fd(fd, &info, &size) != 0) return {};
  return info;
}

/// The kind of the object of a descriptor, as the kernel names it: "bpf-map", "bpf-prog", …
std::string kind_of(int fd) {
  std::error_code error;
  const std::string target =
      std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(fd), error).string();
  const auto colon = target.find(':');
  return error || colon == std::string::npos ? "" : target.substr(colon + 1);
}

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
  if (std::filesystem::symlink_status(path, error).type() !=
          std::filesystem::file_type::not_found &&
      !std::filesystem::is_directory(path, error))
    if (auto way = give_way(path); !way) return std::unexpected(way.error());
  std::filesystem::create_directories(path, error);
  if (error) return failure("mkdir " + path, error.value());
  return {};
}

bool is_map(int fd) {
  const std::string kind = kind_of(fd);
  return kind.empty() || kind == "bpf-map";
}
bool is_program(int fd) {
  const std::string kind = kind_of(fd);
  return kind.empty() || kind == "bpf-prog";
}

/// Calls can fail temporarily, which says nothing about the object, so they are repeated.
Result<Fd> open_own(const std::string& path, const std::function<bool(int)>& is_ours,
                    std::string& was) {
  int error = 0;
  for (int i = 0; i < kTries; ++i) {
    Fd there = open_pin(path);
    error = errno;
    if (there && is_ours(there.get())) return there;
    std::error_code unknown;
    const auto type = std::filesystem::symlink_status(path, unknown).type();
    if (type == std::filesystem::file_type::not_found) return Fd();
    const bool is_object = type == std::filesystem::file_type::regular;
    if (is_object && (!there || map_info(there.get()).type == 0)) continue;
    auto way = give_way(path);
    if (!way) return std::unexpected(way.error());
    was = std::move(*way);
    return Fd();
  }
  return failure("open " + path, error);
}

std::string what_is_at(const std::string& path) {
  std::error_code error;
  const auto type = std::filesystem::symlink_status(path, error).type();
  if (type == std::filesystem::file_type::not_found) return {};
  if (type == std::filesystem::file_type::directory) return "a directory";
  if (type == std::filesystem::file_type::symlink) return "a symbolic link";
  const Fd there = open_pin(path);
  if (!there) return "something that cannot be opened";
  if (is_program(there.get())) return "a program";
  if (!is_map(there.get())) return "a link or another object";
  const auto info = map_info(there.get());
  return fmt::format("a map of type {} ({}, {} of {})", info.type,
                     static_cast<const char*>(info.name),
                     many(info.max_entries, "entry", "entries"), many(info.value_size, "byte"));
}

Result<std::string> give_way(const std::string& path) {
  std::string was = what_is_at(path);
  if (was.empty()) return was;
  std::error_code error;
  std::filesystem::remove(path, error);
  if (error == std::errc::directory_not_empty)
    return fail(
        fmt::format("{0} is {1} that is not empty, where mlccad pins an object of its own: "
                    "remove it (rm -r {0}) and start mlccad again",
                    path, was));
  if (error) return failure("remove " + path, error.value());
  return was;
}

Result<std::string> pin_instead(int fd, const std::string& path) {
  if (is_pinned({fd, path})) return std::string();
  auto was = give_way(path);
  if (!was) return was;
  const auto pinned = pin(fd, path);
  if (!pinned) return std::unexpected(pinned.error());
  if (!*pinned) return fail("pin " + path + ": another program pins there at this moment");
  return was;
}

std::expected<std::vector<std::string>, std::error_code> names_in(const std::string& directory) {
  std::vector<std::string> names;
  std::error_code error;
  // A range-based for would throw if a later entry cannot be read.
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
  if (std::rename(from.c_str(), to.c_str()) == 0) return {};
  if (errno != EISDIR) return failure("rename " + from, errno);
  if (auto way = give_way(to); !way) return std::unexpected(way.error());
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

/// The first fields that the kernel states for a map, program or link alike.
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

}  // namespace

bool is_pinned(const Pin& kept) {
  const Fd there = open_pin(kept.path);
  return there && object_of(there.get()) == object_of(kept.fd);
}

Result<std::vector<std::string>> keep_pinned(std::span<const Pin> pins) {
  std::vector<std::string> again;
  for (const Pin& kept : pins) {
    if (is_pinned(kept)) continue;
    const std::filesystem::path path(kept.path);
    if (auto made = make_pin_directory(path.parent_path()); !made)
      return std::unexpected(made.error());
    if (auto pinned = pin_instead(kept.fd, kept.path); !pinned)
      return std::unexpected(pinned.error());
    again.push_back(path.filename());
  }
  return again;
}

bool is_array(int map_fd, std::uint32_t value_size, std::uint32_t entries) {
  const auto info = map_info(map_fd);
  return is_map(map_fd) && info.type == BPF_MAP_TYPE_ARRAY &&
         info.key_size == sizeof(std::uint32_t) && info.value_size == value_size &&
         info.max_entries == entries;
}

bool is_mappable_array(int map_fd, std::uint32_t value_size, std::uint32_t entries) {
  return is_array(map_fd, value_size, entries) &&
         (map_info(map_fd).map_flags & BPF_F_MMAPABLE) != 0;
}

bool is_ring(int map_fd, std::uint32_t size) {
  const auto info = map_info(map_fd);
  return is_map(map_fd) && info.type == BPF_MAP_TYPE_RINGBUF && info.max_entries == size;
}

bool is_hash(int map_fd, std::uint32_t key_size, std::uint32_t value_size) {
  const auto info = map_info(map_fd);
  return is_map(map_fd) && info.type == BPF_MAP_TYPE_LRU_HASH && info.key_size == key_size &&
         info.value_size == value_size;
}

std::string map_name(int map_fd) { return static_cast<const char*>(map_info(map_fd).name); }

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

}  // namespace mlcca::gates
