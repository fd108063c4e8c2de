// SPDX-License-Identifier: BSD-2-Clause
// Measures how distinctive the contents of a flow are: contents that hardly change and counters are
// alike in many flows.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace mlcca::learn {

/// The variety of one flow.
class Variety {
 public:
  static constexpr std::size_t kMost = 32;  // different steps that are kept
  static constexpr std::size_t kBytes = 8;  // first bytes of each event that are compared

  /// Adds the next event.
  void add(std::span<const std::uint8_t> data);

  /// Whether the content has changed several times.
  [[nodiscard]] bool changes() const { return changes_ >= kSeveral; }
  /// Whether the content is not that of a counter. A counter and a checksum of it change by few
  /// different steps, and its CRC by few different XORs.
  [[nodiscard]] bool is_rich() const { return sums_.is_full() && bits_.is_full(); }

 private:
  static constexpr std::uint8_t kSeveral = 8;
  struct Steps {
    std::array<std::uint64_t, kMost> all{};
    std::uint8_t count = 0;
    [[nodiscard]] bool is_full() const { return count == kMost; }
    void add(std::uint64_t step);
  };
  std::uint64_t last_ = 0;  ///< bytes of the latest event
  Steps sums_;              ///< differences of each byte
  Steps bits_;              ///< changed bits
  std::uint8_t changes_ = 0;
  bool is_first_ = true;
};

}  // namespace mlcca::learn
