// SPDX-License-Identifier: BSD-2-Clause
#include "relay/famouso/dealt_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string_view>

#include "base/number.hpp"
#include "base/text.hpp"
#include "relay/famouso/node_numbers.hpp"
#include "relay/famouso/tag_broker.hpp"
#include "relay/layers/sockets.hpp"

namespace mlcca::relay {
namespace {

/// Largest size of the file: all tags and node numbers of a bus are 16,500 lines of about 30
/// octets.
constexpr off_t kMostFileBytes = off_t{1} << 20U;

struct Line {
  bool is_tag = false;
  std::uint16_t number = 0;
  std::uint64_t of = 0;
};

/// Parses a line like "tag 0x3ffe 0x44697374616e6365".
std::optional<Line> line_in(std::string_view text) {
  Line out;
  const auto first = text.find(' ');
  const auto second = first == std::string_view::npos ? first : text.find(' ', first + 1);
  if (second == std::string_view::npos) return std::nullopt;
  const auto kind = text.substr(0, first);
  out.is_tag = kind == "tag";
  if (!out.is_tag && kind != "node") return std::nullopt;
  const auto number = prefixed_number_in<std::uint16_t>(text.substr(first + 1, second - first - 1));
  const auto of = prefixed_number_in<std::uint64_t>(text.substr(second + 1));
  if (!number || !of || *of == 0 || *number > (out.is_tag ? kHighestTag : kHighestNode))
    return std::nullopt;
  out.number = *number;
  out.of = *of;
  return out;
}

}  // namespace

Result<DealtFile> DealtFile::open(const std::string& path) {
  Fd file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  struct stat about{};
  if (!file || ::fstat(file.get(), &about) != 0) return system_error(path);
  if (about.st_size > kMostFileBytes) return fail(path + ": too large: no broker writes so much");
  std::string text(static_cast<std::size_t>(about.st_size), '\0');
  if (::pread(file.get(), text.data(), text.size(), 0) != about.st_size) return system_error(path);
  const auto end = text.rfind('\n');
  text.resize(end == std::string::npos ? 0 : end + 1);
  DealtFile out(std::move(file), path);
  if (auto read = out.read(text); !read) return std::unexpected(read.error());
  out.size_ = text.size();
  if (::ftruncate(out.file_.get(), static_cast<off_t>(out.size_)) != 0) return system_error(path);
  return out;
}

Result<void> DealtFile::read(std::string_view text) {
  std::set<std::uint64_t> known;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto end = text.find('\n');
    const auto line = line_in(text.substr(0, end));
    if (!line)
      return fail(fmt::format(
          "{}:{}: '{}' must be such as 'tag 0x3ffe 0x44697374616e6365' or 'node 0x7d 0x{:016x}'",
          path_, number, cut(text.substr(0, end), 60), 1));
    // No broker of ours has written that, so it is unknown what the nodes of the bus were answered.
    if (const std::uint64_t kind = line->is_tag ? 0 : kHighestTag + 1U;
        !known.insert(kind + line->number).second)
      return fail(fmt::format("{}:{}: {:#x} was dealt before", path_, number, line->number));
    (line->is_tag ? tags_ : nodes_).emplace_back(line->of, line->number);
    text.remove_prefix(end + 1);
  }
  return {};
}

Result<void> DealtFile::append(const std::string& line) {
  const auto size = static_cast<ssize_t>(line.size());
  if (::pwrite(file_.get(), line.data(), line.size(), static_cast<off_t>(size_)) == size &&
      ::fdatasync(file_.get()) == 0) {
    size_ += line.size();
    return {};
  }
  auto failed = system_error(path_);
  // If this fails as well, the next line overwrites the incomplete one.
  static_cast<void>(::ftruncate(file_.get(), static_cast<off_t>(size_)) != 0);
  return failed;
}

Result<void> DealtFile::add_node(std::uint64_t uid, std::uint16_t number) {
  if (auto done = append(fmt::format("node {:#x} {:#018x}\n", number, uid)); !done) return done;
  nodes_.emplace_back(uid, number);
  return {};
}

Result<void> DealtFile::add_tag(std::uint64_t subject, std::uint16_t tag) {
  if (auto done = append(fmt::format("tag {:#x} {:#018x}\n", tag, subject)); !done) return done;
  tags_.emplace_back(subject, tag);
  return {};
}

}  // namespace mlcca::relay
