// SPDX-License-Identifier: BSD-2-Clause
// Any octets as what a daemon says to mlccactl, in pieces: read or refused, and whatever was read
// is said again in the same words, and is shown without a character that could steer the terminal.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "control/codec.hpp"
#include "tests/fuzz/demand.hpp"
#include "tools/audit.hpp"
#include "tools/json.hpp"
#include "tools/render.hpp"

namespace {

using namespace mlcca;
using fuzz::demand;

void check_shown(std::string_view text, std::string_view steering) {
  for (const char c : text) {
    const auto octet = static_cast<unsigned char>(c);
    demand(octet >= 0x20 || c == '\n' || steering.contains(c), "a control character is shown");
    demand(octet != 0x7f, "DEL is shown");
  }
  // In UTF-8 the control characters of C1 are two octets.
  for (std::size_t at = text.find('\xc2'); at < text.size(); at = text.find('\xc2', at + 1))
    demand(at + 1 < text.size() && static_cast<unsigned char>(text[at + 1]) >= 0xa0,
           "a control character of C1 is shown");
}

void show(const control::Reply& reply) {
  std::visit(
      [](const auto& body) {
        check_shown(tools::render(body, tools::Color::no), "");
        check_shown(tools::render(body, tools::Color::yes), "\x1b");
        if constexpr (std::is_same_v<std::decay_t<decltype(body)>, control::Channels>) {
          check_shown(tools::explain(body, tools::Color::no, true), "");
          check_shown(tools::explain(body, tools::Color::no, false), "");
        }
      },
      reply.body);
  const std::string json = tools::to_json(reply);
  check_shown(json, "");
  demand(json.ends_with('\n') && std::ranges::count(json, '\n') == 1, "not one line of JSON");
}

void check_again(const control::Reply& reply) {
  control::Buffer buffer;
  buffer.append(control::encode(reply));
  const auto again = control::decode_reply(buffer);
  demand(again && *again && **again == reply, "a reply is not what it was when it is sent again");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view octets(reinterpret_cast<const char*>(data) + 1, size - 1);
  const std::size_t piece = std::size_t{data[0]} + 1;
  control::Buffer buffer;
  for (std::size_t at = 0; at < octets.size(); at += piece) {
    buffer.append(octets.substr(at, piece));
    for (;;) {
      const auto reply = control::decode_reply(buffer);
      if (!reply) {
        demand(!reply.error().text.empty(), "a refusal without a word");
        return 0;
      }
      if (!*reply) break;
      check_again(**reply);
      show(**reply);
    }
  }
  return 0;
}
