// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/bus_load.hpp"

#include <algorithm>

#include "mlcca/arithmetic.hpp"

namespace mlcca {
namespace {

/// Bits of a classic frame with an 11-bit identifier, without data and stuff bits, with the
/// intermission: ISO 11898-1.
constexpr std::uint64_t kFewestBits = 47;
constexpr std::uint64_t kBitsOfByte = 8;
constexpr std::uint64_t kWhole = 1'000'000;
constexpr std::uint64_t kSecond = 1'000'000'000;

/// The load of `frames` frames with `bytes` bytes of payload together in `ns`, in 1e-6 of the bus
/// time.
std::uint64_t load_of(std::uint64_t frames, std::uint64_t bytes, std::uint32_t bitrate,
                      std::uint64_t ns) {
  const std::uint64_t bits = frames * kFewestBits + bytes * kBitsOfByte;
  return mul_div_down(mul_div_down(bits, kSecond, ns), kWhole, bitrate);
}

std::uint32_t in_steps(std::uint64_t load) {
  constexpr std::uint64_t step = BusLoad::kStep;
  return static_cast<std::uint32_t>(std::min(kWhole, (load + step - 1) / step * step));
}

}  // namespace

std::uint32_t BusLoad::at_most(std::uint32_t load) {
  // 80 bits instead of 47 for a frame without data (Davis et al., 2007), relatively less for longer
  // ones: 160 instead of 111 for 8 bytes.
  constexpr std::uint64_t most_bits = 80;
  return static_cast<std::uint32_t>(
      std::min<std::uint64_t>((load * most_bits + kFewestBits - 1) / kFewestBits, kWhole));
}

std::uint32_t SenderLoad::measure(std::uint64_t frames, std::uint64_t bytes, std::uint32_t bitrate,
                                  std::uint64_t now_ns) {
  std::uint32_t now = 0;
  if (last_ && now_ns > last_ns_ && frames >= *last_ && bitrate != 0)
    now = in_steps(load_of(frames - *last_, (frames - *last_) * bytes, bitrate, now_ns - last_ns_));
  last_ = frames;
  last_ns_ = now_ns;
  const std::uint32_t difference = now > load_ ? now - load_ : load_ - now;
  if (now == 0 || load_ == 0 || difference > BusLoad::kStep) load_ = now;
  return load_;
}

std::uint32_t BusLoad::measure(const BusCounters& counters, std::uint32_t bitrate,
                               std::uint64_t analysed, std::uint64_t now_ns) {
  const bool usable = last_ && now_ns > last_ns_ && counters.frames >= last_->frames &&
                      counters.bytes >= last_->bytes && bitrate != 0;
  load_ = 0;
  if (usable)
    load_ = load_of(counters.frames - last_->frames, counters.bytes - last_->bytes, bitrate,
                    now_ns - last_ns_);
  last_ = counters;
  last_ns_ = now_ns;
  const std::uint64_t unaccounted = load_ > analysed ? load_ - analysed : 0;
  const std::uint32_t excess = in_steps(unaccounted);
  if (excess >= excess_ || ++lower_for_ >= kHold) {
    excess_ = excess;
    lower_for_ = 0;
  }
  return excess_;
}

}  // namespace mlcca
