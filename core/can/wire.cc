// SPDX-License-Identifier: BSD-2-Clause
#include "core/can/wire.hpp"

#include <algorithm>
#include <span>

namespace mlcca::core::can {
namespace {

constexpr unsigned kRun = 5;  // equal bits after which a stuff bit of the other value is sent
constexpr unsigned kCrcBits = 15;
constexpr unsigned kCrcPolynomial = 0x4599;
// CRC delimiter, acknowledgement and its delimiter, end of frame, intermission.
constexpr unsigned kTail = 1 + 1 + 1 + 7 + kIntermission;
// Stuff count and CRC with their fixed stuff bits, see frame.cc.
constexpr unsigned kShortCheck = 4 + 17 + 6;
constexpr unsigned kLongCheck = 4 + 21 + 7;
constexpr unsigned kShortCheckBytes = 16;
constexpr unsigned kLongestClassic = 8;

/// Appends bits, and counts them with the stuff bits that a sender inserts.
class Stuffed {
 public:
  void add(bool bit) {
    if (run_ == kRun) {
      last_ = !last_;
      run_ = 1;
      ++bits_;
    }
    crc_ = ((crc_ >> (kCrcBits - 1) & 1U) != 0) != bit ? (crc_ << 1U) ^ kCrcPolynomial : crc_ << 1U;
    crc_ &= (1U << kCrcBits) - 1;
    run_ = run_ > 0 && bit == last_ ? run_ + 1 : 1;
    last_ = bit;
    ++bits_;
  }
  void add(std::uint32_t value, unsigned width) {
    for (unsigned i = width; i-- > 0;) add((value >> i & 1U) != 0);
  }
  void add(std::span<const std::uint8_t> bytes) {
    for (const auto byte : bytes) add(byte, 8);
  }
  [[nodiscard]] unsigned bits() const { return bits_; }
  [[nodiscard]] unsigned crc() const { return crc_; }
  /// Includes the stuff bit that follows the last bit, if one does.
  [[nodiscard]] unsigned bits_at_end() const { return bits_ + (run_ == kRun ? 1 : 0); }

 private:
  unsigned bits_ = 0;
  unsigned run_ = 0;
  bool last_ = false;
  unsigned crc_ = 0;
};

/// Adds the start of frame up to IDE, or for a 29-bit identifier up to the bit behind it.
void add_head(Stuffed& out, const WireFrame& frame) {
  out.add(false);
  if (frame.extended) {
    out.add(frame.id >> 18U, 11);
    out.add(0b11, 2);  // SRR, IDE
    out.add(frame.id, 18);
    out.add(frame.remote && !frame.fd);
  } else {
    out.add(frame.id, 11);
    out.add(frame.remote && !frame.fd);
    out.add(false);  // IDE
  }
}

unsigned fd_code(unsigned size) {
  constexpr std::array<unsigned, 7> longer = {12, 16, 20, 24, 32, 48, 64};
  if (size <= kLongestClassic) return size;
  const auto* const at = std::ranges::lower_bound(longer, size);
  return kLongestClassic + 1 + static_cast<unsigned>(at - longer.begin());
}

WireLength classic_length(const WireFrame& frame) {
  Stuffed out;
  add_head(out, frame);
  out.add(0, frame.extended ? 2 : 1);  // reserved
  const unsigned size = std::min<unsigned>(frame.size, kLongestClassic);
  out.add(size, 4);
  if (!frame.remote) out.add(std::span(frame.data).first(size));
  const unsigned crc = out.crc();
  out.add(crc, kCrcBits);
  return {.slow = out.bits_at_end() + kTail, .fast = 0};
}

WireLength fd_length(const WireFrame& frame) {
  Stuffed out;
  add_head(out, frame);
  out.add(0b10, 2);  // FDF, reserved
  out.add(frame.switches);
  const unsigned head = out.bits();
  const unsigned size = fd_size(frame.size);
  out.add(frame.passive);
  out.add(fd_code(size), 4);
  out.add(std::span(frame.data).first(size));
  // A fixed stuff bit follows; it replaces a dynamic one after the last five bits. Of the tail, the
  // CRC delimiter belongs to the data phase.
  const unsigned body = out.bits() - head + (size <= kShortCheckBytes ? kShortCheck : kLongCheck);
  if (!frame.switches) return {.slow = head + body + kTail, .fast = 0};
  return {.slow = head + kTail - 1, .fast = body + 1};
}

}  // namespace

WireLength wire_length(const WireFrame& frame) {
  return frame.fd ? fd_length(frame) : classic_length(frame);
}

Time wire_time(const Timing& timing, WireLength length) {
  if (timing.bitrate == 0) return kNever;
  const auto time = [](Time bits, Time rate) { return (bits * 1'000'000'000 + rate / 2) / rate; };
  return time(length.slow, timing.bitrate) +
         time(length.fast, timing.data_bitrate == 0 ? timing.bitrate : timing.data_bitrate);
}

}  // namespace mlcca::core::can
