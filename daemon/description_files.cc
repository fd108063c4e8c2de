// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/description_files.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <vector>

#include "base/handle.hpp"
#include "core/cluster/keys.hpp"
#include "description/bundle.hpp"

namespace mlcca {
namespace {

constexpr std::string_view kDescriptionPrefix = "description-";

std::string description_name(const Sha256::Digest& digest) {
  return std::string(kDescriptionPrefix) + core::cluster::hex_of(digest);
}

std::unexpected<Error> failed_with(const std::string& path) {
  return fail(fmt::format("{}: {}", path, std::strerror(errno)));  // NOLINT(concurrency-mt-unsafe)
}

bool write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const auto some = ::write(fd, text.data(), text.size());
    if (some < 0 && errno == EINTR) continue;
    if (some <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(some));
  }
  return true;
}

std::string path_of(const std::string& directory, const Sha256::Digest& digest) {
  return directory + '/' + description_name(digest);
}

Fd open_kept(const std::string& path) {
  return Fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
}

Result<std::string> content_of(const Fd& file, const std::string& path) {
  struct stat status{};
  if (!file || ::fstat(file.get(), &status) != 0) return failed_with(path);
  if (!S_ISREG(status.st_mode)) return fail(path + ": it is no file");
  if (static_cast<std::uint64_t>(status.st_size) > description::kMaxBundle)
    return fail(path + ": it is too long");
  std::string all(static_cast<std::size_t>(status.st_size), '\0');
  std::size_t read = 0;
  while (read < all.size()) {
    const auto some = ::read(file.get(), all.data() + read, all.size() - read);
    if (some < 0 && errno == EINTR) continue;
    if (some < 0) return failed_with(path);
    if (some == 0) return fail(path + ": it became shorter");
    read += static_cast<std::size_t>(some);
  }
  return all;
}

KeptText kept_in(const std::string& directory, const Sha256::Digest& digest) {
  const std::string path = path_of(directory, digest);
  const Fd file = open_kept(path);
  if (!file && errno == ENOENT) return {};
  auto text = content_of(file, path);
  if (text && description::digest_of(*text) != digest)
    text = fail(path + ": it is damaged: its digest is not that of its name");
  if (!text) return {.text = {}, .damage = std::move(text.error().text)};
  return {.text = std::move(*text), .damage = {}};
}

}  // namespace

/// Writes to another name first, so that a file with this name is always complete.
Result<void> DescriptionFiles::keep(const Digest& digest, const std::string& text) {
  if (description::digest_of(text) != digest)
    return fail("a description of another digest is not kept");
  const std::string path = path_of(directory_, digest);
  const Fd directory(::open(directory_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!directory) return failed_with(directory_);
  // An existing file may not have been synced to disk yet.
  if (kept_in(directory_, digest).text == text) {
    const Fd file = open_kept(path);
    if (file && ::fsync(file.get()) == 0 && ::fsync(directory.get()) == 0) return {};
    return failed_with(path);
  }
  const std::string fresh = path + ".new";
  {
    constexpr mode_t own = S_IRUSR | S_IWUSR;
    const Fd file(
        ::open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, own));
    if (!file || ::fchmod(file.get(), own) != 0 || !write_all(file.get(), text) ||
        ::fsync(file.get()) != 0)
      return failed_with(fresh);
  }
  if (::rename(fresh.c_str(), path.c_str()) != 0 || ::fsync(directory.get()) != 0)
    return failed_with(path);
  return {};
}

DescriptionTexts::Reader DescriptionFiles::reader() const {
  return [directory = directory_](const Digest& digest) { return kept_in(directory, digest); };
}

void DescriptionFiles::keep_only(const std::set<Digest>& digests) {
  std::set<std::string> names;
  for (const Digest& digest : digests) names.insert(description_name(digest));
  std::error_code ignored;
  std::vector<std::filesystem::path> others;
  for (const auto& entry : std::filesystem::directory_iterator(directory_, ignored)) {
    const std::string name = entry.path().filename();
    if (name.starts_with(kDescriptionPrefix) && !names.contains(name))
      others.push_back(entry.path());
  }
  for (const auto& path : others) std::filesystem::remove(path, ignored);
}

}  // namespace mlcca
