// SPDX-License-Identifier: BSD-2-Clause
// Exact intermediate results of fixed size, for the two compositions that need more than 64 bits:
// reciprocal sums of rates and products of survival probabilities. C++14, freestanding.
#pragma once
#include "mlcca/arithmetic.hpp"

namespace mlcca {

/// The most hops that compose() accepts; core::kMaxHops has the same value.
constexpr size_t kMaxComposedHops = 16;

namespace detail {

/// An unsigned integer that can hold the product of kMaxComposedHops Values, in limbs of 32 bits.
class Wide {
 public:
  constexpr explicit Wide(Value v) : size_(2) {
    limb_[0] = static_cast<uint32_t>(v & kLowHalf);
    limb_[1] = static_cast<uint32_t>(v >> 32);
    trim();
  }

  /// *this = *this * factor + term. The result must fit.
  constexpr void multiply_add(Value factor, const Wide& term) {
    const Value low = factor & kLowHalf;
    const Value high = factor >> 32;
    const size_t most = (size_ > term.size_ ? size_ : term.size_) + (high != 0 ? 3 : 2);
    const size_t limbs = most < kLimbs ? most : kLimbs;
    Value carry = 0;  // 34 bits
    Value previous = 0;
    for (size_t i = 0; i < limbs; ++i) {
      const Value digit = limb(i);
      const Value first = digit * low + term.limb(i) + (carry & kLowHalf);
      const Value second = previous * high + (first & kLowHalf);
      limb_[i] = static_cast<uint32_t>(second & kLowHalf);
      carry = (carry >> 32) + (first >> 32) + (second >> 32);
      previous = digit;
    }
    size_ = limbs;
    trim();
  }

  friend constexpr bool operator<(const Wide& a, const Wide& b) {
    if (a.size_ != b.size_) return a.size_ < b.size_;
    for (size_t i = a.size_; i-- > 0;)
      if (a.limb_[i] != b.limb_[i]) return a.limb_[i] < b.limb_[i];
    return false;
  }

  /// n / d rounded down. d must not be 0, and the result must fit. Each round subtracts a multiple
  /// of d that is never too large and at most 2^-30 (relative) too small.
  friend constexpr Value quotient(Wide n, const Wide& d) {
    Value result = 0;
    while (!(n < d)) {
      const auto n_shift = static_cast<size_t>(sub_floor(n.bits(), 64));
      const auto d_shift = static_cast<size_t>(sub_floor(d.bits(), 32));
      // NOLINTNEXTLINE(clang-analyzer-core.DivideZero): d is not 0
      const Value ratio = n.from_bit(n_shift) / (d.from_bit(d_shift) + (d_shift != 0 ? 1 : 0));
      Value part = n_shift >= d_shift ? ratio << (n_shift - d_shift) : ratio >> (d_shift - n_shift);
      if (part == 0) part = 1;
      n.subtract_product(d, part);
      result += part;
    }
    return result;
  }

 private:
  static constexpr size_t kLimbs = 2 * kMaxComposedHops + 1;

  constexpr void trim() {
    while (size_ > 0 && limb_[size_ - 1] == 0) --size_;
  }
  constexpr Value limb(size_t i) const { return i < size_ ? limb_[i] : 0; }
  constexpr size_t bits() const {
    return size_ == 0 ? 0 : 32 * (size_ - 1) + bit_width(limb_[size_ - 1]);
  }
  /// The lowest 64 bits of *this >> shift.
  constexpr Value from_bit(size_t shift) const {
    const size_t first = shift / 32;
    const unsigned rest = shift % 32;
    const Value low = limb(first) | (limb(first + 1) << 32);
    return rest == 0 ? low : (low >> rest) | (limb(first + 2) << (64 - rest));
  }
  /// *this -= d * factor, which must not exceed *this.
  constexpr void subtract_product(const Wide& d, Value factor) {
    subtract_shifted(d, factor & kLowHalf, 0);
    subtract_shifted(d, factor >> 32, 1);
    trim();
  }
  constexpr void subtract_shifted(const Wide& d, Value factor, size_t offset) {
    if (factor == 0) return;
    Value borrow = 0;
    for (size_t i = 0; i + offset < size_; ++i) {
      const Value taken = d.limb(i) * factor + borrow;
      const Value have = limb_[i + offset];
      limb_[i + offset] = static_cast<uint32_t>((have - taken) & kLowHalf);
      borrow = (taken >> 32) + ((taken & kLowHalf) > have ? 1 : 0);
    }
  }

  uint32_t limb_[kLimbs] = {};
  size_t size_ = 0;
};

/// Computes 1 / (1/rate[0] + 1/rate[1] + ...), rounded down once, for at most kMaxComposedHops
/// rates. It is 0 if a rate is 0, and kUnbounded without rates.
class ReciprocalSum {
 public:
  constexpr void add(Value rate) {
    if (count_++ == 0) only_ = rate;
    if (rate == 0) stopped_ = true;
    if (stopped_ || count_ < 2) return;
    if (count_ == 2) {
      product_ = Wide(only_);
      sum_ = Wide(1);
    }
    // sum/product + 1/rate = (sum * rate + product) / (product * rate)
    sum_.multiply_add(rate, product_);
    product_.multiply_add(rate, Wide(0));
  }
  constexpr Value value() const {
    if (stopped_) return 0;
    return count_ < 2 ? only_ : quotient(product_, sum_);
  }

 private:
  Wide product_ = Wide(1);
  Wide sum_ = Wide(0);
  Value only_ = kUnbounded;  ///< without any rate there is no bound
  size_t count_ = 0;
  bool stopped_ = false;
};

/// The product of survival probabilities, exact in base 1e9. The survival of an event of several
/// frames is rounded down to units of 1e-18.
class Survival {
 public:
  static constexpr Value kFine = kCertainLoss * kCertainLoss;  ///< one, in units of 1e-18

  /// Adds a hop: an event has `frames` frames, each of which is lost with probability `loss`
  /// (1e-9). 0 frames: their number is unknown, so the loss is certain.
  constexpr void add(Value loss, uint16_t frames) {
    if (loss == 0) return;
    if (loss >= kCertainLoss || frames == 0) {
      certain_loss_ = true;
      return;
    }
    const Value frame = kCertainLoss - loss;
    if (frames == 1) {
      multiply(frame, 0);
    } else {
      const Value event = power(frame * kCertainLoss, frames);
      // If less than 1e-9 survives, the loss rounds up to certain, whatever the other hops do.
      certain_loss_ = certain_loss_ || event < kCertainLoss;
      multiply(event % kCertainLoss, event / kCertainLoss);
    }
  }
  /// One minus the product, in units of 1e-9, rounded up once.
  constexpr Value loss() const {
    if (certain_loss_) return kCertainLoss;
    return size_ == 0 ? 0 : kCertainLoss - limb_[size_ - 1];
  }

 private:
  /// Multiplies by low/1e9, or if high is not 0 by (high * 1e9 + low)/1e18.
  constexpr void multiply(Value low, Value high) {
    const size_t growth = high != 0 ? 2 : 1;
    const size_t limbs = size_ == 0 ? 0 : size_ + growth;
    Value carry = 0;
    Value previous = 0;
    for (size_t i = 0; i < limbs; ++i) {
      const Value digit = i < size_ ? limb_[i] : 0;
      const Value sum = digit * low + previous * high + carry;
      limb_[i] = static_cast<uint32_t>(sum % kCertainLoss);
      carry = sum / kCertainLoss;
      previous = digit;
    }
    size_ += growth;
    if (limbs != 0) return;
    limb_[0] = static_cast<uint32_t>(low);
    limb_[growth - 1] = static_cast<uint32_t>(high != 0 ? high : low);
  }
  /// The product of two probabilities in units of 1e-18, rounded down.
  static constexpr Value multiply_fine(Value a, Value b) {
    const Value a_high = a / kCertainLoss;
    const Value a_low = a % kCertainLoss;
    const Value b_high = b / kCertainLoss;
    const Value b_low = b % kCertainLoss;
    const Value middle = a_high * b_low + a_low * b_high + a_low * b_low / kCertainLoss;
    return a_high * b_high + middle / kCertainLoss;
  }
  /// The n-th power of a probability in units of 1e-18, rounded down in each step.
  static constexpr Value power(Value base, uint16_t n) {
    Value result = kFine;
    for (; n != 0; n = static_cast<uint16_t>(n / 2)) {
      if (n % 2 != 0) result = multiply_fine(result, base);
      base = multiply_fine(base, base);
    }
    return result;
  }

  uint32_t limb_[2 * kMaxComposedHops] = {};  ///< lowest first; the product is 0.limb...limb
  size_t size_ = 0;
  bool certain_loss_ = false;
};

}  // namespace detail
}  // namespace mlcca
