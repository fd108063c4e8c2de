// SPDX-License-Identifier: BSD-2-Clause
// Opens only regular files, so that no other kind can block the program.
#include "description/source.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <initializer_list>

namespace mlcca::description {
namespace {

constexpr std::size_t kBuffer = std::size_t{64} << 10U;  // bytes

}  // namespace

Result<Source> Source::open(const std::string& path) {
  Source out;
  // O_NONBLOCK, because opening a FIFO would block the daemon; it is refused below.
  out.fd_.reset(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (!out.fd_) return fail(fmt::format("cannot open the file: {}", std::strerror(errno)));
  struct stat status{};
  if (::fstat(out.fd_.get(), &status) != 0)
    return fail(fmt::format("cannot examine the file: {}", std::strerror(errno)));
  if (!S_ISREG(status.st_mode)) return fail("not a regular file: a description must be one");
  out.size_ = static_cast<std::uint64_t>(std::max<off_t>(status.st_size, 0));
  out.identity_ = {status.st_dev, status.st_ino};
  out.buffer_ = std::make_unique_for_overwrite<char[]>(kBuffer);
  if (out.fill() < 0) return fail(fmt::format("cannot read the file: {}", std::strerror(errno)));
  return out;
}

ssize_t Source::fill() {
  for (;;) {
    const auto got = ::read(fd_.get(), buffer_.get(), kBuffer);
    if (got < 0 && errno == EINTR) continue;
    if (got >= 0) left_ = {buffer_.get(), static_cast<std::size_t>(got)};
    return got;
  }
}

ssize_t Source::read(char* to, std::size_t size) {
  if (left_.empty() && fd_ && fill() < 0) return -1;
  const auto got = std::min(left_.size(), size);
  std::ranges::copy(left_.substr(0, got), to);
  if (copy_) copy_(left_.substr(0, got));
  left_.remove_prefix(got);
  return static_cast<ssize_t>(got);
}

namespace {

/// The encoding of a text that begins with a byte order mark, or with '<' in wider characters (XML
/// 1.0, appendix F.1); nullopt for others.
std::optional<std::string_view> other_encoding(std::string_view xml) {
  using namespace std::string_view_literals;
  struct Start {
    std::string_view bytes;
    std::string_view encoding;
  };
  // UTF-32 comes first, because its mark begins with that of UTF-16.
  for (const auto& [bytes, encoding] : std::initializer_list<Start>{{"\xff\xfe\0\0"sv, "UTF-32"},
                                                                    {"\0\0\xfe\xff"sv, "UTF-32"},
                                                                    {"<\0\0\0"sv, "UTF-32LE"},
                                                                    {"\0\0\0<"sv, "UTF-32BE"},
                                                                    {"\xff\xfe"sv, "UTF-16"},
                                                                    {"\xfe\xff"sv, "UTF-16"},
                                                                    {"<\0"sv, "UTF-16LE"},
                                                                    {"\0<"sv, "UTF-16BE"}})
    if (xml.starts_with(bytes)) return encoding;
  return std::nullopt;
}

}  // namespace

std::optional<std::string> wrong_start(std::string_view xml, bool whole) {
  if (xml.starts_with("\xef\xbb\xbf")) xml.remove_prefix(3);
  const auto first = xml.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos && !whole) return std::nullopt;
  if (first == std::string_view::npos) return "the file is empty: a root element is needed";
  if (const auto other = other_encoding(xml))
    return fmt::format(
        "this is text in {0}, and a description is read in UTF-8: save it in UTF-8, or convert it "
        "(iconv -f {0} -t UTF-8), and let its XML declaration name no other encoding",
        *other);
  if (xml[first] != '<' || xml.substr(0, 4).contains('\0'))
    return "this is not XML in UTF-8: the first character must be '<'";
  if (!xml.starts_with("<?xml")) return std::nullopt;
  auto declaration = xml.substr(0, xml.find("?>"));
  const auto at = declaration.find("encoding");
  if (at == std::string_view::npos) return std::nullopt;
  declaration.remove_prefix(at);
  const auto quote = declaration.find_first_of("\"'");
  if (quote == std::string_view::npos) return std::nullopt;
  auto encoding = declaration.substr(quote + 1);
  encoding = encoding.substr(0, encoding.find_first_of("\"'"));
  const bool utf8 = std::ranges::equal(encoding, std::string_view("utf-8"), [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == b;
  });
  if (utf8) return std::nullopt;
  return fmt::format("encoding {} is not read: save the file in UTF-8 and declare that", encoding);
}

}  // namespace mlcca::description
