// SPDX-License-Identifier: BSD-2-Clause
// Traffic of CAN buses for tests, in the order of time.
#pragma once
#include <cstdint>
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

  [[nodiscard]] Frame frame() const {
    Frame out;
    out.ns = ns;
    out.interface = interface;
    out.id = id;
    out.fd = fd;
    out.local = local;
    out.data = data;
    return out;
  }
};

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
  /// What comes in on one interface leaves by another, 0.2 to 0.6 ms later.
  Traffic& forwarded(std::uint32_t from, std::uint32_t id, std::uint32_t to);

  /// In the order of time.
  [[nodiscard]] std::vector<Sent> sent() const;
  [[nodiscard]] std::uint64_t below(std::uint64_t n) { return random_() % n; }

 private:
  std::mt19937_64 random_;
  std::vector<Sent> all_;
  std::uint8_t counter_ = 0;
};

}  // namespace mlcca::learn::test
