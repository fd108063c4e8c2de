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

Result<void> failed_with(const std::string& path) {
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

}  // namespace

std::string DescriptionFiles::path_of(const Digest& digest) const {
  return directory_ + '/' + description_name(digest);
}

/// Under another name first, so that one of this name is complete.
Result<void> DescriptionFiles::keep(const Digest& digest, const std::string& text) {
  const std::string path = path_of(digest);
  if (this->text(digest) == text) return {};
  const std::string fresh = path + ".new";
  {
    constexpr mode_t own = S_IRUSR | S_IWUSR;
    const Fd file(
        ::open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, own));
    if (!file || ::fchmod(file.get(), own) != 0 || !write_all(file.get(), text) ||
        ::fsync(file.get()) != 0)
      return failed_with(fresh);
  }
  const Fd directory(::open(directory_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (::rename(fresh.c_str(), path.c_str()) != 0 || !directory || ::fsync(directory.get()) != 0)
    return failed_with(path);
  return {};
}

std::optional<std::string> DescriptionFiles::text(const Digest& digest) const {
  const Fd file(::open(path_of(digest).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  struct stat status{};
  if (!file || ::fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode) ||
      static_cast<std::uint64_t>(status.st_size) > description::kMaxBundle)
    return std::nullopt;
  std::string all(static_cast<std::size_t>(status.st_size), '\0');
  std::size_t read = 0;
  while (read < all.size()) {
    const auto some = ::read(file.get(), all.data() + read, all.size() - read);
    if (some < 0 && errno == EINTR) continue;
    if (some <= 0) return std::nullopt;
    read += static_cast<std::size_t>(some);
  }
  return all;
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
