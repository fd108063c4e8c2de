// SPDX-License-Identifier: BSD-2-Clause
// Quantities that know their unit, and literals that refuse at compile time what does not fit: a
// Period cannot be made from bytes, nor from a bare number. Each quantity is an enumeration,
// because a template of C++14 takes one as its argument and a compiler prints it with its name and
// value.
#pragma once
#include "mlcca/arithmetic.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca {

enum class Nanoseconds : Value {};
enum class Bytes : Value {};
enum class BytesPerSecond : Value {};
enum class PerBillion : Value {};  ///< a share of events, 1e-9

/// The number in the unit of the attribute table.
constexpr Value count(Nanoseconds q) { return static_cast<Value>(q); }
constexpr Value count(Bytes q) { return static_cast<Value>(q); }
constexpr Value count(BytesPerSecond q) { return static_cast<Value>(q); }
constexpr Value count(PerBillion q) { return static_cast<Value>(q); }

/// Saturates at kUnbounded.
constexpr Nanoseconds operator+(Nanoseconds a, Nanoseconds b) {
  return static_cast<Nanoseconds>(add_saturating(count(a), count(b)));
}

namespace detail {

/// Never defined: a literal that gets here is no constant, which is the compiler's error message.
Value NOT_A_WHOLE_DECIMAL_NUMBER_OR_TOO_LARGE_FOR_ITS_UNIT();

/// The number that `text` spells, in units of `scale`. Any other base, a fraction, and more than
/// `limit` after scaling are refused.
constexpr Value decimal(const char* text, Value scale, Value limit) {
  const Value most = limit / scale;
  bool good = text[0] != '0' || text[1] == '\0';
  Value v = 0;
  for (; *text != '\0'; ++text) {
    if (*text == '\'') continue;
    const Value digit = static_cast<Value>(*text) - '0';  // far above 9 for what is no digit
    good = good && digit <= 9 && digit <= most && v <= (most - digit) / 10;
    v = v * 10 + digit;
  }
  return good ? v * scale : NOT_A_WHOLE_DECIMAL_NUMBER_OR_TOO_LARGE_FOR_ITS_UNIT();
}

}  // namespace detail

/// Whole decimal numbers below kUnbounded, shares up to one. They see the characters as they are
/// written, so that 1.5_ms, 010_ms and 0x10_ms are refused: by the compiler where a constant is
/// asked for, as in Period<50_ms>, and by the linker anywhere else.
inline namespace literals {

constexpr Nanoseconds operator""_ns(const char* text) {
  return static_cast<Nanoseconds>(detail::decimal(text, 1, kUnbounded - 1));
}
constexpr Nanoseconds operator""_us(const char* text) {
  return static_cast<Nanoseconds>(detail::decimal(text, 1000, kUnbounded - 1));
}
constexpr Nanoseconds operator""_ms(const char* text) {
  return static_cast<Nanoseconds>(detail::decimal(text, 1000000, kUnbounded - 1));
}
constexpr Nanoseconds operator""_s(const char* text) {
  return static_cast<Nanoseconds>(detail::decimal(text, 1000000000, kUnbounded - 1));
}
constexpr Bytes operator""_bytes(const char* text) {
  return static_cast<Bytes>(detail::decimal(text, 1, kUnbounded - 1));
}
constexpr BytesPerSecond operator""_bytes_per_s(const char* text) {
  return static_cast<BytesPerSecond>(detail::decimal(text, 1, kUnbounded - 1));
}
constexpr BytesPerSecond operator""_kB_per_s(const char* text) {
  return static_cast<BytesPerSecond>(detail::decimal(text, 1000, kUnbounded - 1));
}
constexpr BytesPerSecond operator""_kbit_per_s(const char* text) {
  return static_cast<BytesPerSecond>(detail::decimal(text, 125, kUnbounded - 1));
}
constexpr BytesPerSecond operator""_Mbit_per_s(const char* text) {
  return static_cast<BytesPerSecond>(detail::decimal(text, 125000, kUnbounded - 1));
}
/// 1e-9
constexpr PerBillion operator""_ppb(const char* text) {
  return static_cast<PerBillion>(detail::decimal(text, 1, kCertainLoss));
}
/// 1e-6
constexpr PerBillion operator""_ppm(const char* text) {
  return static_cast<PerBillion>(detail::decimal(text, 1000, kCertainLoss));
}
constexpr PerBillion operator""_percent(const char* text) {
  return static_cast<PerBillion>(detail::decimal(text, 10000000, kCertainLoss));
}

}  // namespace literals
}  // namespace mlcca
