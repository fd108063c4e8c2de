// SPDX-License-Identifier: BSD-2-Clause
// How much the contents of a flow say: those of a counter, and those that hardly change, are alike
// in many flows.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace mlcca::learn {

class Variety {
 public:
  static constexpr std::size_t kMost = 32;  // different steps that are kept
  static constexpr std::size_t kBytes = 8;  // of each event, the first ones

  /// The next event.
  void add(std::span<const std::uint8_t> data);

  /// The content was another one than before, several times.
  [[nodiscard]] bool changes() const { return changes_ >= kSeveral; }
  /// It is no counter. A counter, and a sum of it, change by few steps, as its CRC does by XOR.
  [[nodiscard]] bool is_rich() const { return sums_.is_full() && bits_.is_full(); }

 private:
  static constexpr std::uint8_t kSeveral = 8;
  struct Steps {
    std::array<std::uint64_t, kMost> all{};
    std::uint8_t count = 0;
    [[nodiscard]] bool is_full() const { return count == kMost; }
    void add(std::uint64_t step);
  };
  std::uint64_t last_ = 0;  ///< its bytes
  Steps sums_;              ///< what is added to each byte
  Steps bits_;              ///< which bits change
  std::uint8_t changes_ = 0;
  bool is_first_ = true;
};

}  // namespace mlcca::learn
