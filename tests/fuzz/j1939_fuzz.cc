// SPDX-License-Identifier: BSD-2-Clause
// Any announcements and packets of J1939, of any sources, at any times. Each has its source, the
// time since the one before it in 16 ms, what it is, and eight octets; bits of what it is say that
// it is shorter, or that nobody wants it. What is put together is sent again, and is the same.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "relay/j1939.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using namespace mlcca::relay::j1939;
using mlcca::fuzz::demand;

constexpr std::uint64_t kStep = 16'000'000;
constexpr std::size_t kRecord = 11;

void send_again(const Reassembly::Message& message) {
  const auto frames = frames_of(message.event, message.id);
  demand(frames.size() == 1 + (message.event.size() + 6) / 7, "frames that are none");
  Reassembly again;
  demand(Reassembly::announced(announcement_of(message.id), frames[0]) == message.id,
         "another message is announced");
  again.announce(announcement_of(message.id), frames[0], true, 0);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const auto whole = again.take(packet_of(message.id), frames[i], i);
    demand(whole.has_value() == (i + 1 == frames.size()), "a message of another length");
    demand(!whole || (whole->event == message.event && whole->id == message.id), "another message");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::span<const std::uint8_t> rest(data, size);
  Reassembly reassembly;
  std::uint64_t now = 0;
  for (; rest.size() >= kRecord; rest = rest.subspan(kRecord)) {
    now += rest[1] * kStep;
    const std::uint32_t id = 0x18ebff00U | rest[0];
    const std::span octets = rest.subspan(3, (rest[2] & 2U) != 0 ? rest[2] % 9 : 8);
    if ((rest[2] & 1U) == 0)
      reassembly.announce(announcement_of(id), octets, (rest[2] & 4U) == 0, now);
    else if (const auto whole = reassembly.take(id, octets, now)) {
      demand(whole->event.size() >= kLeast && whole->event.size() <= kMost,
             "a message that there is not");
      send_again(*whole);
    }
    demand(reassembly.sessions() <= 256, "too many messages are begun");
  }
  return 0;
}
