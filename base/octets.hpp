// SPDX-License-Identifier: BSD-2-Clause
// The encoding of messages between programs of this project: little-endian integers, and texts
// behind their length.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace mlcca {

/// Appends values to a message.
class OctetWriter {
 public:
  /// Writes the lowest `octets` octets of `value`, little-endian.
  void number(std::uint64_t value, std::size_t octets) {
    for (std::size_t i = 0; i < octets; ++i) out_ += static_cast<char>((value >> (8 * i)) & 0xffU);
  }
  /// Writes the length in `octets` octets, then the text. The caller limits the length.
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

/// Reads a message that may come from an untrusted process. After the first error every value is 0
/// or empty, so a caller reads all fields and checks ended_well() once. `message` must outlive the
/// reader.
class OctetReader {
 public:
  explicit OctetReader(std::span<const char> message) : rest_(message) {}

  /// Reads a little-endian integer of `octets` octets.
  std::uint64_t number(std::size_t octets) {
    std::uint64_t value = 0;
    const auto from = take(octets);
    for (std::size_t i = 0; i < from.size(); ++i)
      value |= std::uint64_t{static_cast<unsigned char>(from[i])} << (8 * i);
    return value;
  }
  /// Reads a length of `octets` octets and that many characters; more than `most` is an error.
  std::string text(std::size_t most, std::size_t octets = 2) {
    const auto size = static_cast<std::size_t>(number(octets));
    if (size > most) right_ = false;
    const auto from = take(size);
    return {from.begin(), from.end()};
  }
  /// Reads a boolean in one octet; a value other than 0 and 1 is an error.
  bool flag() { return word<std::uint8_t>(1) == 1; }
  /// Reads a value of an enumeration in one octet; a value beyond `last`, its largest one, is an
  /// error.
  template <class Word>
  Word word(Word last) {
    const auto value = number(1);
    if (value > static_cast<std::uint64_t>(last)) right_ = false;
    return right_ ? static_cast<Word>(value) : Word{};
  }
  /// Marks the message as wrong, for a check that the caller makes itself.
  void refuse() { right_ = false; }
  [[nodiscard]] bool right() const { return right_; }
  /// Whether everything was right and nothing follows: the check after the last field.
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
