// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/store/store.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <string_view>

#include "control/buffer.hpp"
#include "control/codec.hpp"
#include "core/handle.hpp"

namespace mlcca::store {
namespace {

// "MLCCA1 <next id> <checksum of the rest>\n", then the requests as on the control socket:
// admissions under their ids, releases under id 0.
constexpr std::string_view kMagic = "MLCCA1 ";

/// FNV-1a: finds a torn or bit-flipped file; it is no protection against an attacker, who would
/// need our user to write it.
std::uint64_t checksum(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return hash;
}

std::string encode(const Contents& contents) {
  std::string body = std::to_string(contents.next_id) + "\n";
  for (const control::Request& r : contents.admissions) body += control::encode(r);
  for (const std::string& subject : contents.released)
    body += control::encode(control::Request{0, control::ReleaseRequest{subject, 0}});
  return std::string(kMagic) + std::to_string(checksum(body)) + "\n" + body;
}

bool take_number(std::string_view& text, std::uint64_t& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end == text.data() + text.size() || *end != '\n') return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()) + 1);
  return true;
}

Result<Contents> decode(std::string_view text, const std::string& path) {
  const auto damaged = [&path](const std::string& how) {
    return fail(path + ": damaged (" + how +
                "): move it away to start without the run-time admissions");
  };
  if (!text.starts_with(kMagic)) return damaged("no MLCCA1 header");
  text.remove_prefix(kMagic.size());
  std::uint64_t sum = 0;
  if (!take_number(text, sum)) return damaged("no checksum");
  if (sum != checksum(text)) return damaged("checksum");
  Contents contents;
  if (!take_number(text, contents.next_id)) return damaged("no id");
  control::Buffer buffer;
  buffer.append(text);
  while (!buffer.content().empty()) {
    auto request = control::decode_request(buffer);
    if (!request) return damaged(request.error().text);
    if (!*request) return damaged("ends within a request");
    if (std::holds_alternative<control::Admit>((*request)->body))
      contents.admissions.push_back(std::move(**request));
    else if (const auto* release = std::get_if<control::ReleaseRequest>(&(*request)->body))
      contents.released.push_back(release->channel);
    else
      return damaged("a request that does not belong here");
  }
  return contents;
}

std::unexpected<Error> system_error(const std::string& what) {
  return fail(what + ": " + std::strerror(errno));  // NOLINT(concurrency-mt-unsafe)
}

Result<void> write_all(int fd, std::string_view bytes, const std::string& path) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return system_error(path);
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  return {};
}

}  // namespace

Result<Contents> Store::load() const {
  const Fd file(::open(path_.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file) {
    if (errno == ENOENT) return Contents{};
    return system_error(path_);
  }
  std::string text;
  std::string block(65536, '\0');
  for (;;) {
    const ssize_t n = ::read(file.get(), block.data(), block.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return system_error(path_);
    if (n == 0) break;
    text.append(block, 0, static_cast<std::size_t>(n));
  }
  return decode(text, path_);
}

Result<void> Store::save(const Contents& contents) const {
  const std::string fresh = path_ + ".new";
  const Fd file(::open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
  if (!file) return system_error(fresh);
  if (auto written = write_all(file.get(), encode(contents), fresh); !written) return written;
  if (::fsync(file.get()) < 0) return system_error(fresh);
  if (::rename(fresh.c_str(), path_.c_str()) < 0) return system_error(path_);
  const Fd directory(
      ::open(path_.substr(0, path_.rfind('/')).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!directory || ::fsync(directory.get()) < 0) return system_error(path_);
  return {};
}

}  // namespace mlcca::store
