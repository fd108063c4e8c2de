// SPDX-License-Identifier: BSD-2-Clause
// Quantities that know their unit, literals that refuse at compile time what does not fit, and
// attribute sets made from them: a Period cannot be set from bytes, nor from a bare number.
#pragma once
#include "mlcca/arithmetic.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca {

/// A value in the unit that `Unit` names.
template <class Unit>
struct Quantity {
  Value count = 0;

  constexpr Quantity() = default;
  constexpr explicit Quantity(Value v) : count(v) {}

  friend constexpr bool operator==(Quantity a, Quantity b) { return a.count == b.count; }
  friend constexpr bool operator!=(Quantity a, Quantity b) { return a.count != b.count; }
  friend constexpr bool operator<(Quantity a, Quantity b) { return a.count < b.count; }
  friend constexpr bool operator>(Quantity a, Quantity b) { return a.count > b.count; }
  friend constexpr bool operator<=(Quantity a, Quantity b) { return a.count <= b.count; }
  friend constexpr bool operator>=(Quantity a, Quantity b) { return a.count >= b.count; }
  /// Saturates at kUnbounded.
  friend constexpr Quantity operator+(Quantity a, Quantity b) {
    return Quantity(add_saturating(a.count, b.count));
  }
};

using Nanoseconds = Quantity<struct NanosecondUnit>;
using Bytes = Quantity<struct ByteUnit>;
using BytesPerSecond = Quantity<struct BytePerSecondUnit>;
using Events = Quantity<struct EventUnit>;           ///< a number of consecutive events
using PerBillion = Quantity<struct PerBillionUnit>;  ///< a share of events, 1e-9

/// The value of one attribute, in the attribute's own unit.
template <Attribute A, class Unit>
struct Given {
  static constexpr Attribute kAttribute = A;
  Quantity<Unit> quantity;

  constexpr Given(Quantity<Unit> q) : quantity(q) {}  // NOLINT(google-explicit-constructor)
};

using Latency = Given<Attribute::latency, NanosecondUnit>;
using Jitter = Given<Attribute::jitter, NanosecondUnit>;
using Deadline = Given<Attribute::deadline, NanosecondUnit>;
using Period = Given<Attribute::period, NanosecondUnit>;
using Bandwidth = Given<Attribute::bandwidth, BytePerSecondUnit>;
using PacketLoss = Given<Attribute::packet_loss, PerBillionUnit>;
using Omission = Given<Attribute::omission, EventUnit>;
using MaxPayload = Given<Attribute::max_payload, ByteUnit>;

/// Sets one attribute: assign(set, Period{50_ms}).
template <Attribute A, class Unit>
constexpr AttributeSet& assign(AttributeSet& set, Given<A, Unit> given, bool dynamic = false) {
  return set.set(A, given.quantity.count, dynamic);
}

namespace detail {

constexpr bool is_one_of(Attribute) { return false; }
template <class... Rest>
constexpr bool is_one_of(Attribute a, Attribute first, Rest... rest) {
  return a == first || is_one_of(a, rest...);
}

}  // namespace detail

constexpr AttributeSet make_set() { return {}; }

/// The set of the given attributes: make_set(Period{50_ms}, Omission{2_events}). Each attribute
/// at most once.
template <Attribute A, class Unit, class... Rest>
constexpr AttributeSet make_set(Given<A, Unit> given, Rest... rest) {
  static_assert(!detail::is_one_of(A, Rest::kAttribute...), "attribute given twice");
  AttributeSet set = make_set(rest...);
  return assign(set, given);
}

namespace detail {

/// The number that the characters of a decimal literal spell. False for anything else: another
/// base, a fraction, or a value that is too large.
constexpr bool parse_decimal(const char* digits, size_t size, Value* out) {
  if (size > 1 && digits[0] == '0') return false;
  Value v = 0;
  for (size_t i = 0; i < size; ++i) {
    if (digits[i] == '\'') continue;
    if (digits[i] < '0' || digits[i] > '9') return false;
    const auto digit = static_cast<Value>(digits[i] - '0');
    if (v > (kUnbounded - digit) / 10) return false;
    v = v * 10 + digit;
  }
  *out = v;
  return true;
}

template <char... Digits>
struct Literal {
  static constexpr bool fits(Value scale, Value limit) {
    const char digits[] = {Digits...};
    Value v = 0;
    return parse_decimal(digits, sizeof...(Digits), &v) && v <= limit / scale;
  }
  static constexpr Value value() {
    const char digits[] = {Digits...};
    Value v = 0;
    parse_decimal(digits, sizeof...(Digits), &v);
    return v;
  }
};

template <class Result, Value Scale, Value Limit, char... Digits>
constexpr Result literal() {
  static_assert(Literal<Digits...>::fits(Scale, Limit),
                "not a whole decimal number, or too large for its unit");
  return Result(Literal<Digits...>::value() * Scale);
}

}  // namespace detail

inline namespace literals {

template <char... D>
constexpr Nanoseconds operator""_ns() {
  return detail::literal<Nanoseconds, 1, kUnbounded - 1, D...>();
}
template <char... D>
constexpr Nanoseconds operator""_us() {
  return detail::literal<Nanoseconds, 1000, kUnbounded - 1, D...>();
}
template <char... D>
constexpr Nanoseconds operator""_ms() {
  return detail::literal<Nanoseconds, 1000000, kUnbounded - 1, D...>();
}
template <char... D>
constexpr Nanoseconds operator""_s() {
  return detail::literal<Nanoseconds, 1000000000, kUnbounded - 1, D...>();
}
template <char... D>
constexpr Bytes operator""_bytes() {
  return detail::literal<Bytes, 1, kUnbounded - 1, D...>();
}
template <char... D>
constexpr BytesPerSecond operator""_bytes_per_s() {
  return detail::literal<BytesPerSecond, 1, kUnbounded - 1, D...>();
}
template <char... D>
constexpr BytesPerSecond operator""_kB_per_s() {
  return detail::literal<BytesPerSecond, 1000, kUnbounded - 1, D...>();
}
template <char... D>
constexpr BytesPerSecond operator""_kbit_per_s() {
  return detail::literal<BytesPerSecond, 125, kUnbounded - 1, D...>();
}
template <char... D>
constexpr BytesPerSecond operator""_Mbit_per_s() {
  return detail::literal<BytesPerSecond, 125000, kUnbounded - 1, D...>();
}
template <char... D>
constexpr Events operator""_events() {
  return detail::literal<Events, 1, kUnbounded - 1, D...>();
}
/// 1e-9
template <char... D>
constexpr PerBillion operator""_ppb() {
  return detail::literal<PerBillion, 1, kCertainLoss, D...>();
}
/// 1e-6
template <char... D>
constexpr PerBillion operator""_ppm() {
  return detail::literal<PerBillion, 1000, kCertainLoss, D...>();
}
template <char... D>
constexpr PerBillion operator""_percent() {
  return detail::literal<PerBillion, 10000000, kCertainLoss, D...>();
}

}  // namespace literals
}  // namespace mlcca
