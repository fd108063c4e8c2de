// SPDX-License-Identifier: BSD-2-Clause
// Messages of our own programs to each other: little endian integers, and texts behind their
// length.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace mlcca {

class OctetWriter {
 public:
  void number(std::uint64_t value, std::size_t octets) {
    for (std::size_t i = 0; i < octets; ++i) out_ += static_cast<char>((value >> (8 * i)) & 0xffU);
  }
  /// Its length in so many octets, then what there is of it.
  void text(std::string_view value, std::size_t octets = 2) {
    number(value.size(), octets);
    out_ += value;
  }
  void append(std::string_view written) { out_ += written; }
  [[nodiscard]] std::size_t size() const { return out_.size(); }
  [[nodiscard]] std::string take() { return std::exchange(out_, {}); }

 private:
  std::string out_;
};

/// Once something is wrong, everything it gives is 0 or empty.
class OctetReader {
 public:
  explicit OctetReader(std::span<const char> message) : rest_(message) {}

  std::uint64_t number(std::size_t octets) {
    std::uint64_t value = 0;
    const auto from = take(octets);
    for (std::size_t i = 0; i < from.size(); ++i)
      value |= std::uint64_t{static_cast<unsigned char>(from[i])} << (8 * i);
    return value;
  }
  /// Of at most `most` bytes, behind its length in so many octets.
  std::string text(std::size_t most, std::size_t octets = 2) {
    const auto size = static_cast<std::size_t>(number(octets));
    if (size > most) right_ = false;
    const auto from = take(size);
    return {from.begin(), from.end()};
  }
  /// 0 or 1.
  bool flag() { return word<std::uint8_t>(1) == 1; }
  /// A word of an enumeration whose last one is `last`.
  template <class Word>
  Word word(Word last) {
    const auto value = number(1);
    if (value > static_cast<std::uint64_t>(last)) right_ = false;
    return right_ ? static_cast<Word>(value) : Word{};
  }
  void refuse() { right_ = false; }
  [[nodiscard]] bool right() const { return right_; }
  [[nodiscard]] bool ended_well() const { return right_ && rest_.empty(); }

 private:
  std::span<const char> take(std::size_t octets) {
    if (octets > rest_.size()) right_ = false;
    if (!right_) return {};
    const auto front = rest_.first(octets);
    rest_ = rest_.subspan(octets);
    return front;
  }

  std::span<const char> rest_;
  bool right_ = true;
};

}  // namespace mlcca
