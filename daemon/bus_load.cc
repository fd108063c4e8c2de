// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/bus_load.hpp"

#include <algorithm>

#include "mlcca/arithmetic.hpp"

namespace mlcca {
namespace {

/// Bits of a classic frame with an 11-bit identifier and no data, without stuffing, with the
/// intermission: ISO 11898-1.
constexpr std::uint64_t kFewestBits = 47;
constexpr std::uint64_t kBitsOfByte = 8;
constexpr std::uint64_t kWhole = 1'000'000;
constexpr std::uint64_t kSecond = 1'000'000'000;

}  // namespace

std::uint32_t BusLoad::measure(const BusCounters& counters, std::uint32_t bitrate,
                               std::uint64_t analysed, std::uint64_t now_ns) {
  const bool usable = last_ && now_ns > last_ns_ && counters.frames >= last_->frames &&
                      counters.bytes >= last_->bytes && bitrate != 0;
  load_ = 0;
  if (usable) {
    const std::uint64_t bits = (counters.frames - last_->frames) * kFewestBits +
                               (counters.bytes - last_->bytes) * kBitsOfByte;
    const std::uint64_t per_second = mul_div_down(bits, kSecond, now_ns - last_ns_);
    load_ = mul_div_down(per_second, kWhole, bitrate);
  }
  last_ = counters;
  last_ns_ = now_ns;
  const std::uint64_t beyond = load_ > analysed ? load_ - analysed : 0;
  const auto excess =
      static_cast<std::uint32_t>(std::min(kWhole, (beyond + kStep - 1) / kStep * kStep));
  if (excess >= excess_) {
    excess_ = excess;
    lower_for_ = 0;
  } else if (++lower_for_ >= kHold) {
    excess_ = excess;
    lower_for_ = 0;
  }
  return excess_;
}

}  // namespace mlcca
