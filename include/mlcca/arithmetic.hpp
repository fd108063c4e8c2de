// SPDX-License-Identifier: BSD-2-Clause
// Integer arithmetic that saturates instead of wrapping and states its direction of rounding.
// C++14, freestanding; it needs no 128-bit type of the compiler.
#pragma once
#include <stddef.h>
#include <stdint.h>

#include "mlcca/attribute.hpp"

namespace mlcca {

/// How a value between two integers is rounded. Requirements are rounded towards harder values,
/// provisions towards worse ones.
enum class Rounding : uint8_t { down, up };

constexpr Value kNanosecondsPerSecond = 1000000000;

/// a + b, or kUnbounded if it does not fit.
constexpr Value add_saturating(Value a, Value b) { return b > kUnbounded - a ? kUnbounded : a + b; }

/// a - b, never below 0.
constexpr Value sub_floor(Value a, Value b) { return a > b ? a - b : 0; }

/// a * b, or kUnbounded if it does not fit.
constexpr Value mul_saturating(Value a, Value b) {
  if (((a | b) >> 32) == 0) return a * b;
  return b != 0 && a > kUnbounded / b ? kUnbounded : a * b;
}

/// a / b rounded up; kUnbounded if b == 0.
constexpr Value div_up(Value a, Value b) {
  return b == 0 ? kUnbounded : a / b + (a % b != 0 ? 1 : 0);
}

namespace detail {

constexpr Value kLowHalf = 0xffffffff;

struct Product {
  Value high;
  Value low;
};

/// The full 128-bit product a * b.
constexpr Product multiply(Value a, Value b) {
  const Value low = (a & kLowHalf) * (b & kLowHalf);
  const Value cross = (a >> 32) * (b & kLowHalf) + (low >> 32);
  const Value middle = (a & kLowHalf) * (b >> 32) + (cross & kLowHalf);
  return {(a >> 32) * (b >> 32) + (cross >> 32) + (middle >> 32),
          (middle << 32) | (low & kLowHalf)};
}

/// The number of bits up to the highest set one; 0 for 0.
constexpr unsigned bit_width(Value v) {
  unsigned bits = 0;
  for (unsigned step = 32; step != 0; step /= 2)
    if ((v >> step) != 0) {
      v >>= step;
      bits += step;
    }
  return bits + (v != 0 ? 1 : 0);
}

struct Division {
  Value quotient;
  Value remainder;
};

/// One digit of a long division in base 2^32: (high, digit) / divisor. Requires high < divisor and
/// that the highest bit of the divisor is set (Knuth, TAOCP 4.3.1, algorithm D).
constexpr Division divide_digit(Value high, Value digit, Value divisor) {
  // NOLINTNEXTLINE(clang-analyzer-core.DivideZero): its highest bit is set
  Value q = high / (divisor >> 32);
  Value rest = high % (divisor >> 32);
  while (q > kLowHalf || q * (divisor & kLowHalf) > ((rest << 32) | digit)) {
    --q;
    rest += divisor >> 32;
    if (rest > kLowHalf) break;
  }
  return {q, (high << 32) + digit - q * divisor};
}

/// (high * 2^64 + low) / divisor. Requires high < divisor, so that the quotient fits.
constexpr Division divide(Value high, Value low, Value divisor) {
  if (high == 0) return {low / divisor, low % divisor};
  const unsigned shift = 64 - bit_width(divisor);
  if (shift != 0) {
    divisor <<= shift;
    high = (high << shift) | (low >> (64 - shift));
    low <<= shift;
  }
  const Division upper = divide_digit(high, low >> 32, divisor);
  const Division lower = divide_digit(upper.remainder, low & kLowHalf, divisor);
  return {(upper.quotient << 32) | lower.quotient, lower.remainder >> shift};
}

constexpr Value mul_div(Value a, Value b, Value c, Rounding rounding) {
  const Product product = multiply(a, b);
  if (product.high >= c) return kUnbounded;
  const Division d = divide(product.high, product.low, c);
  return add_saturating(d.quotient, rounding == Rounding::up && d.remainder != 0 ? 1 : 0);
}

}  // namespace detail

/// a * b / c rounded down, computed with 128 bits; kUnbounded if it does not fit or c == 0.
constexpr Value mul_div_down(Value a, Value b, Value c) {
  return detail::mul_div(a, b, c, Rounding::down);
}

/// a * b / c rounded up, computed with 128 bits; kUnbounded if it does not fit or c == 0.
constexpr Value mul_div_up(Value a, Value b, Value c) {
  return detail::mul_div(a, b, c, Rounding::up);
}

}  // namespace mlcca
