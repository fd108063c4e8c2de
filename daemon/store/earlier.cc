// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/store/earlier.hpp"

#include <cstdint>
#include <utility>

#include "base/number.hpp"
#include "control/buffer.hpp"
#include "control/codec.hpp"

namespace mlcca::store {
namespace {

// "MLCCA1 <checksum of the rest>\n<next id>\n", then the requests as on the control socket:
// admissions under their ids, releases under id 0.
constexpr std::string_view kMagic = "MLCCA1 ";

/// FNV-1a, 64 bit.
std::uint64_t checksum(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return hash;
}

bool take_line(std::string_view& text, std::uint64_t& value) {
  const auto number = take_number<std::uint64_t>(text);
  if (!number || !text.starts_with('\n')) return false;
  value = *number;
  text.remove_prefix(1);
  return true;
}

}  // namespace

Result<Contents> read_earlier(std::string_view text, const std::string& path) {
  const auto damaged = [&path](const std::string& how) {
    return fail(path + ": damaged (" + how +
                "): move it away to start without the run-time admissions");
  };
  if (!text.starts_with(kMagic)) return damaged("no MLCCA1 header");
  text.remove_prefix(kMagic.size());
  std::uint64_t sum = 0;
  if (!take_line(text, sum)) return damaged("no checksum");
  if (sum != checksum(text)) return damaged("checksum");
  Contents contents;
  if (!take_line(text, contents.next_id) || contents.next_id == 0) return damaged("no id");
  control::Buffer buffer;
  buffer.append(text);
  while (!buffer.content().empty()) {
    auto request = control::decode_request(buffer);
    if (!request) return damaged(request.error().text);
    if (!*request) return damaged("ends within a request");
    if (std::holds_alternative<control::Admit>((*request)->body))
      contents.apply(Admitted{std::move(**request)});
    else if (const auto* release = std::get_if<control::ReleaseRequest>(&(*request)->body))
      contents.apply(Released{release->channel});
    else
      return damaged("a request that does not belong here");
  }
  return contents;
}

}  // namespace mlcca::store
