// SPDX-License-Identifier: BSD-2-Clause
// Any frames of a CAN bus and any datagrams, for followers of each profile. Each frame has an octet
// of flags, one that says which identifier, its length, and its octets; what is left is a datagram.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "relay/layers/can_layer.hpp"
#include "relay/layers/udp_layer.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using namespace mlcca::relay;
using mlcca::fuzz::demand;

constexpr std::size_t kLongest = 40;
constexpr std::uint32_t kFragment = 1U << 21U;

class Frames : public FrameSocket {
 public:
  [[nodiscard]] int fd() const override { return -1; }
  [[nodiscard]] mlcca::Result<void> filter(const std::vector<can_filter>& /*filters*/) override {
    return {};
  }
  Got receive(Frame& to) override {
    if (in.empty()) return Got::nothing;
    to = in.front();
    in.pop_front();
    return Got::frame;
  }
  Sent send(const canfd_frame& frame, bool fd) override {
    demand(frame.len <= (fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN), "a frame that is none");
    return Sent::sent;
  }
  [[nodiscard]] std::uint64_t dropped() const override { return 0; }

  std::deque<Frame> in;
};

mlcca::control::Endpoint endpoint(const char* profile, std::uint32_t id, std::uint32_t mask) {
  mlcca::control::Endpoint out;
  out.can = out.classic = out.fd = true;
  out.profile = profile;
  out.id = id;
  out.mask = mask;
  out.frame_bytes = CANFD_MAX_DLEN;
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::span<const std::uint8_t> rest(data, size);
  auto socket = std::make_unique<Frames>();
  Frames& frames = *socket;
  CanLayer layer(std::move(socket));
  const std::vector followed{endpoint("famouso", 0x9f414065, 0xdfffffff & ~kFragment),
                             endpoint("famouso", 0x80000066, 0xc0003fff),
                             endpoint("raw", 0x123, 0xc00007ff), endpoint("raw", 0x120, 0xc00007f0),
                             endpoint("cyphal", 0x9000, 0xc000ffff)};
  for (std::uint32_t i = 0; i < followed.size(); ++i)
    demand(layer.follow(i, followed[i], i, kLongest).has_value(), "a profile is not known");
  while (rest.size() >= 3) {
    const std::uint8_t flags = rest[0];
    FrameSocket::Frame frame;
    frame.fd = (flags & 1U) != 0;
    frame.local = (flags & 2U) != 0;
    frame.frame.can_id = followed[rest[1] % followed.size()].id;
    if ((flags & 4U) != 0) frame.frame.can_id |= kFragment;
    if ((flags & 8U) != 0) frame.frame.can_id ^= flags;
    if ((flags & 16U) != 0) frame.frame.can_id |= CAN_RTR_FLAG;
    const std::size_t most = frame.fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN;
    const std::size_t length = std::min({std::size_t{rest[2]}, rest.size() - 3, most});
    std::ranges::copy(rest.subspan(3, length), frame.frame.data);
    frame.frame.len = static_cast<std::uint8_t>(length);
    frames.in.push_back(frame);
    rest = rest.subspan(3 + length);
  }
  while (!frames.in.empty())
    layer.receive(16, [&](const Layer::Arrival& arrival) {
      demand(arrival.event.size() <= kLongest, "longer than its follower takes");
      demand(arrival.follower < followed.size(), "nobody follows it");
      static_cast<void>(layer.send(followed[arrival.follower], 1, arrival.event));
    });
  if (const auto datagram = parse_datagram({data, size}))
    demand(datagram->data.size() + kDatagramHeader == size, "octets are lost");
  return 0;
}
