// SPDX-License-Identifier: BSD-2-Clause
// Traffic of CAN buses and Ethernets for tests, in the order of time.
#pragma once
#include <algorithm>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tools/learn/frame.hpp"

namespace mlcca::learn::test {

inline constexpr std::uint64_t kMs = 1'000'000;
inline constexpr std::uint64_t kSecond = 1'000 * kMs;

/// A frame that keeps its data.
struct Sent {
  std::uint64_t ns = 0;
  std::uint32_t interface = 0;
  std::uint32_t id = 0;
  std::vector<std::uint8_t> data;
  bool fd = false;
  bool local = false;
  std::optional<Datagram> datagram = {};

  [[nodiscard]] Frame frame() const {
    Frame out;
    out.ns = ns;
    out.interface = interface;
    out.id = id;
    out.fd = fd;
    out.local = local;
    out.datagram = datagram;
    out.data = data;
    return out;
  }
};

inline constexpr std::uint64_t kDistance = 0x44697374616e6365;  // "Distance"

/// 192.0.2.N
[[nodiscard]] constexpr std::uint32_t station(std::uint8_t number) { return 0xc0000200U | number; }
/// An event in one datagram, to the group of its subject.
[[nodiscard]] Sent event(std::uint64_t ns, std::uint32_t interface, std::uint64_t subject,
                         std::uint32_t sender, const std::vector<std::uint8_t>& data,
                         bool is_fragment = false);
/// The same as an Ethernet frame with so many VLAN tags.
[[nodiscard]] std::vector<std::uint8_t> frame_of(const Sent& datagram, unsigned tags = 0);
/// What is behind the ethertype of such a frame: IPv4, UDP and its data.
[[nodiscard]] std::vector<std::uint8_t> packet_of(const Sent& datagram);

[[nodiscard]] inline std::vector<Sent> in_order(std::vector<Sent> sent) {
  std::ranges::stable_sort(sent, {}, &Sent::ns);
  return sent;
}

class Traffic {
 public:
  explicit Traffic(std::uint64_t seed) : random_(seed) {}

  /// Every `period`, late by up to `jitter`; one in `lost` does not come, 0: all come.
  Traffic& periodic(std::uint32_t interface, std::uint32_t id, std::uint64_t period,
                    std::uint64_t jitter, std::size_t bytes, std::uint64_t seconds,
                    unsigned lost = 0);
  /// Bursts of 1 to `most` frames, `apart` from each other, after pauses of about `pause`.
  Traffic& bursts(std::uint32_t interface, std::uint32_t id, unsigned most, std::uint64_t apart,
                  std::uint64_t pause, std::uint64_t seconds);
  /// Events of a subject, as periodic().
  Traffic& events(std::uint32_t interface, std::uint64_t subject, std::uint32_t sender,
                  std::uint64_t period, std::uint64_t jitter, std::size_t bytes,
                  std::uint64_t seconds, unsigned lost = 0);
  /// Frames of an identifier are carried to an Ethernet, as events of a subject that a program of
  /// this host sends.
  Traffic& to_ethernet(std::uint32_t from, std::uint32_t id, std::uint32_t to,
                       std::uint64_t subject);
  /// And back, of one sender.
  Traffic& to_bus(std::uint32_t from, std::uint64_t subject, std::uint32_t sender, std::uint32_t to,
                  std::uint32_t id);
  /// What comes in on one interface leaves by another, 0.2 to 0.6 ms later.
  Traffic& forwarded(std::uint32_t from, std::uint32_t id, std::uint32_t to);

  /// In the order of time.
  [[nodiscard]] std::vector<Sent> sent() const;
  [[nodiscard]] std::uint64_t below(std::uint64_t n) { return random_() % n; }

 private:
  void put(std::vector<Sent> copies);
  std::mt19937_64 random_;
  std::vector<Sent> all_;
  std::uint8_t counter_ = 0;
};

}  // namespace mlcca::learn::test
