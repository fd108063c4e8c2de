// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/output.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>

#include "base/handle.hpp"
#include "tools/design/safe_file.hpp"

namespace mlcca::tools::design {
namespace {

std::unexpected<Error> failed(const std::string& what) {
  return fail(fmt::format("{}: {}", what, std::strerror(errno)));
}

Result<void> write_through(const std::string& path, std::string_view text) {
  const Fd fd(::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY));
  if (!fd) return failed(path);
  while (!text.empty()) {
    const auto n = ::write(fd.get(), text.data(), text.size());
    if (n < 0 && errno != EINTR) return failed(path);
    if (n > 0) text.remove_prefix(static_cast<std::size_t>(n));
  }
  return {};
}

}  // namespace

void add_force(CLI::App& verb, CLI::Option* output, bool& force) {
  verb.add_flag("--force", force, "replace a file that exists")->needs(output);
}

void refuse_standard_input(CLI::Option* file) {
  file->check([](const std::string& text) {
    return text == "-" ? std::string("standard input is not read here: name a file")
                       : std::string();
  });
}

std::string path_of_output(const std::string& output) {
  return output == "-" || output == "/dev/stdout" ? "" : output;
}

Result<void> can_write(const std::string& path, Existing existing) {
  struct stat status{};
  if (::stat(path.c_str(), &status) == 0) {
    if (S_ISDIR(status.st_mode)) return fail(path + " is a folder: name a file");
    if (!S_ISREG(status.st_mode) || existing == Existing::replace) return {};
    return fail(existing_words(path) + (existing == Existing::ask ? ", or state --force" : ""));
  }
  std::string folder = std::filesystem::path(path).parent_path().string();
  if (folder.empty()) folder = ".";
  std::error_code error;
  const auto there = std::filesystem::status(folder, error);
  const auto wrong = [&](std::string_view text) {
    return fail(fmt::format("--output {}: {}", path, text));
  };
  if (!std::filesystem::exists(there))
    return wrong(fmt::format("there is no folder {}: make it, or name another", folder));
  if (!std::filesystem::is_directory(there))
    return wrong(fmt::format("{} is no folder: name another", folder));
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    return wrong(
        fmt::format("no file can be created in {}: name a folder that you may write to", folder));
  return {};
}

Result<void> write_output(const std::string& path, std::string_view text, Existing existing) {
  if (auto can = can_write(path, existing); !can) return can;
  FileContent old;
  if (::stat(path.c_str(), &old.status) != 0) {
    if (errno == ENOENT) return create_file(path, text);
    return failed(path);
  }
  if (!S_ISREG(old.status.st_mode)) return write_through(path, text);
  const std::unique_ptr<char, FreeWith<std::free>> real(::realpath(path.c_str(), nullptr));
  if (!real) return failed(path);
  old.path = real.get();
  return replace_file(old, text);
}

bool is_one_of(const std::string& path, const std::vector<std::string>& files) {
  struct stat own{};
  if (::stat(path.c_str(), &own) != 0) return false;
  return std::ranges::any_of(files, [&](const std::string& file) {
    struct stat other{};
    return ::stat(file.c_str(), &other) == 0 && other.st_dev == own.st_dev &&
           other.st_ino == own.st_ino;
  });
}

}  // namespace mlcca::tools::design
