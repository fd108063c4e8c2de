// SPDX-License-Identifier: BSD-2-Clause
// Quantities with a unit, and literals for them that do not compile if they do not fit: a Period
// cannot be made from bytes or from a plain number. Each quantity is an enumeration, because C++14
// allows that as a template argument and compilers print it with its name and value. C++14,
// freestanding.
#pragma once
#include "mlcca/arithmetic.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca {

enum class Nanoseconds : Value {};
enum class Bytes : Value {};
enum class BytesPerSecond : Value {};
enum class PerBillion : Value {};  ///< a share of events, in 1e-9

/// The number in the unit of the attribute table.
constexpr Value count(Nanoseconds q) { return static_cast<Value>(q); }
constexpr Value count(Bytes q) { return static_cast<Value>(q); }
constexpr Value count(BytesPerSecond q) { return static_cast<Value>(q); }
constexpr Value count(PerBillion q) { return static_cast<Value>(q); }

/// The sum; it saturates at kUnbounded.
constexpr Nanoseconds operator+(Nanoseconds a, Nanoseconds b) {
  return static_cast<Nanoseconds>(add_saturating(count(a), count(b)));
}

namespace detail {

/// Declared, never defined. A literal that calls it is not constant, and the compiler's error
/// message shows its name.
Value NOT_A_WHOLE_DECIMAL_NUMBER_OR_TOO_LARGE_FOR_ITS_UNIT();

/// The number that `text` spells, times `scale`. Other bases, fractions, and results above `limit`
/// are refused.
constexpr Value decimal(const char* text, Value scale, Value limit) {
  const Value most = limit / scale;
  bool good = text[0] != '0' || text[1] == '\0';
  Value v = 0;
  for (; *text != '\0'; ++text) {
    if (*text == '\'') continue;
    const Value digit = static_cast<Value>(*text) - '0';  // far above 9 for other characters
    good = good && digit <= 9 && digit <= most && v <= (most - digit) / 10;
    v = v * 10 + digit;
  }
  return good ? v * scale : NOT_A_WHOLE_DECIMAL_NUMBER_OR_TOO_LARGE_FOR_ITS_UNIT();
}

}  // namespace detail

/// Literals are decimal integers; quantities must be below kUnbounded, shares at most one. The
/// operators get the characters as written, so that 1.5_ms, 010_ms and 0x10_ms are refused: by the
/// compiler where a constant is needed, as in Period<50_ms>, otherwise by the linker.
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
/// A share in units of 1e-9.
constexpr PerBillion operator""_ppb(const char* text) {
  return static_cast<PerBillion>(detail::decimal(text, 1, kCertainLoss));
}
/// A share in units of 1e-6.
constexpr PerBillion operator""_ppm(const char* text) {
  return static_cast<PerBillion>(detail::decimal(text, 1000, kCertainLoss));
}
constexpr PerBillion operator""_percent(const char* text) {
  return static_cast<PerBillion>(detail::decimal(text, 10000000, kCertainLoss));
}

}  // namespace literals
}  // namespace mlcca
