// SPDX-License-Identifier: BSD-2-Clause
// Any frames of a CAN bus and of IEEE 802.15.4 and any datagrams, for followers of each profile.
// Each frame has an octet of flags, one that says which identifier, its length, and its octets. All
// of the input is a datagram, too, and a sequence of datagrams.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "relay/layers/can_layer.hpp"
#include "relay/layers/udp_layer.hpp"
#include "relay/layers/wpan_layer.hpp"
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

class Radio : public WpanSocket {
 public:
  [[nodiscard]] int fd() const override { return -1; }
  Got receive(Frame& to) override {
    if (in.empty()) return Got::nothing;
    to = in.front();
    in.pop_front();
    return Got::frame;
  }
  Sent send(Octets payload) override {
    demand(payload.size() <= kWpanPayload, "more than a frame holds");
    return Sent::sent;
  }
  [[nodiscard]] std::uint64_t dropped() const override { return 0; }

  std::deque<Frame> in;
};

class Network : public UdpSocket {
 public:
  [[nodiscard]] int fd() const override { return -1; }
  [[nodiscard]] mlcca::Result<void> join(std::uint32_t /*group*/) override { return {}; }
  void leave(std::uint32_t /*group*/) override {}
  Got receive(Datagram& to) override {
    if (in.empty()) return Got::nothing;
    octets_ = std::move(in.front().first);
    to = {.octets = octets_, .from = in.front().second, .unix_ns = 1};
    in.pop_front();
    return Got::datagram;
  }
  void read_errors() override {}
  Sent send(std::uint32_t /*to*/, Octets header, Octets data) override {
    demand(header.size() + data.size() <= kDatagram, "more than a datagram holds");
    return Sent::sent;
  }
  [[nodiscard]] std::uint32_t own_address() const override { return 0; }
  [[nodiscard]] std::uint64_t dropped() const override { return 0; }

  std::deque<std::pair<std::vector<std::uint8_t>, std::uint32_t>> in;  ///< octets and sender

 private:
  static constexpr std::size_t kDatagram = 65'507;
  std::vector<std::uint8_t> octets_;
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

/// Of J1939, of which longer ones come as messages.
mlcca::control::Endpoint message(std::uint32_t id, std::uint32_t mask) {
  mlcca::control::Endpoint out = endpoint("j1939", id, mask);
  out.fd = false;
  out.fragmented = true;
  out.frame_bytes = CAN_MAX_DLEN;
  return out;
}

std::vector<std::uint32_t> ids_of(const std::vector<mlcca::control::Endpoint>& followed) {
  std::vector<std::uint32_t> out;
  for (const auto& one : followed) out.push_back(one.id);
  for (const std::uint32_t carrier : {0x98ecff05U, 0x98ebff05U, 0x80ecff05U})
    out.push_back(carrier);
  return out;
}

/// Frames of 802.15.4: an octet of length each, and the subject of the second follower in some.
void send_by_radio(std::span<const std::uint8_t> rest) {
  auto socket = std::make_unique<Radio>();
  Radio& radio = *socket;
  WpanLayer layer(std::move(socket));
  constexpr std::array<std::uint64_t, 2> kSubjects{0, 0x44697374616e6365};
  for (std::uint32_t i = 0; i < kSubjects.size(); ++i)
    demand(layer.follow(i, {}, kSubjects.at(i), kLongest).has_value(), "it is not followed");
  while (!rest.empty()) {
    WpanSocket::Frame frame;
    frame.size = rest[0];
    const std::size_t length = std::min({frame.size, rest.size() - 1, kWpanPayload});
    std::ranges::copy(rest.subspan(1, length), frame.payload.begin());
    radio.in.push_back(frame);
    rest = rest.subspan(1 + length);
  }
  while (!radio.in.empty())
    layer.receive(16, [&](const Layer::Arrival& arrival) {
      demand(arrival.event.size() <= kLongest, "longer than its follower takes");
      demand(arrival.follower < kSubjects.size(), "nobody follows it");
      static_cast<void>(layer.send({}, kSubjects.at(arrival.follower), arrival.event));
    });
}

/// Datagrams of two senders: an octet of flags and one of the length each. Some get the header of a
/// whole event or of a fragment.
void send_by_udp(std::span<const std::uint8_t> rest) {
  auto socket = std::make_unique<Network>();
  Network& network = *socket;
  UdpLayer layer(std::move(socket), false, [] { return std::uint64_t{1}; });
  constexpr std::array<std::uint64_t, 2> kSubjects{0, 0x44697374616e6365};
  constexpr unsigned octet = 8;
  for (std::uint32_t i = 0; i < kSubjects.size(); ++i)
    demand(layer.follow(i, {}, kSubjects.at(i), kLongest).has_value(), "it is not followed");
  while (rest.size() >= 2) {
    const std::uint8_t flags = rest[0];
    const std::size_t length = std::min<std::size_t>(rest[1], rest.size() - 2);
    std::vector<std::uint8_t> datagram;
    if ((flags & 1U) != 0) {
      const std::uint64_t subject = kSubjects.at((flags & 2U) != 0 ? 1 : 0);
      for (unsigned shift = 64; shift != 0; shift -= octet)
        datagram.push_back(static_cast<std::uint8_t>(subject >> (shift - octet)));
      datagram.push_back((flags & 4U) != 0 ? 1 : 0);
    }
    const auto octets = rest.subspan(2, length);
    datagram.insert(datagram.end(), octets.begin(), octets.end());
    network.in.emplace_back(std::move(datagram), (flags & octet) != 0 ? 2 : 1);
    rest = rest.subspan(2 + length);
  }
  while (!network.in.empty())
    layer.receive(16, [&](const Layer::Arrival& arrival) {
      demand(arrival.event.size() <= kLongest, "longer than its follower takes");
      demand(arrival.follower < kSubjects.size(), "nobody follows it");
      static_cast<void>(layer.send({}, kSubjects.at(arrival.follower), arrival.event));
    });
  layer.expire();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::span<const std::uint8_t> rest(data, size);
  auto socket = std::make_unique<Frames>();
  Frames& frames = *socket;
  CanLayer layer(std::move(socket));
  const std::vector followed{endpoint("famouso", 0x9f414065, 0xdfffffff & ~kFragment),
                             endpoint("famouso", 0x80000066, 0xc0003fff),
                             endpoint("raw", 0x123, 0xc00007ff),
                             endpoint("raw", 0x120, 0xc00007f0),
                             endpoint("cyphal", 0x9000, 0xc000ffff),
                             message(0x98feca05, 0xdfffffff),
                             message(0x80120005, 0xc3ff00ff)};
  // What carries messages of the last two is none of theirs alone.
  const std::vector<std::uint32_t> ids = ids_of(followed);
  for (std::uint32_t i = 0; i < followed.size(); ++i)
    demand(layer.follow(i, followed[i], i, kLongest).has_value(), "a profile is not known");
  while (rest.size() >= 3) {
    const std::uint8_t flags = rest[0];
    FrameSocket::Frame frame;
    frame.fd = (flags & 1U) != 0;
    frame.local = (flags & 2U) != 0;
    frame.frame.can_id = ids[rest[1] % ids.size()];
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
  send_by_radio({data, size});
  send_by_udp({data, size});
  return 0;
}
