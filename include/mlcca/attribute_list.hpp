// SPDX-License-Identifier: BSD-2-Clause
// Attributes as types, so that a compiler can name them with their values, and lists of them: what
// an event channel requires and what a network provides. C++14, freestanding.
#pragma once
#include "mlcca/attribute.hpp"
#include "mlcca/units.hpp"

namespace mlcca {
namespace detail {

/// What an attribute type says of itself in one byte: the index of the table, or that it is the
/// user's own, and the dynamic mark.
constexpr uint8_t kUserCode = 0x40;
constexpr uint8_t kDynamicCode = 0x80;
constexpr uint8_t code_of(Attribute a) { return static_cast<uint8_t>(a); }

/// What a list says.
struct ListValues {
  AttributeSet set;
  uint8_t users = 0;  ///< how many attributes of the user
  bool distinct = true;

  constexpr void add(uint8_t code, Value value) {
    if ((code & kUserCode) != 0) {
      ++users;
      return;
    }
    const auto a = static_cast<Attribute>(code & ~kDynamicCode);
    if (set.has(a)) distinct = false;
    set.set(a, value, (code & kDynamicCode) != 0);
  }
};

/// The values of a list. Element 0 is not looked at: an array has at least one.
template <size_t N>
constexpr ListValues collect(const uint8_t (&codes)[N], const Value (&values)[N]) {
  ListValues list;
  for (size_t i = 1; i < N; ++i) list.add(codes[i], values[i]);
  return list;
}

}  // namespace detail

/// Worst case, jitter included.
template <Nanoseconds V>
struct Latency {
  static constexpr uint8_t kCode = detail::code_of(Attribute::latency);
  static constexpr Value kValue = static_cast<Value>(V);
};
/// Longest delay minus shortest delay.
template <Nanoseconds V>
struct Jitter {
  static constexpr uint8_t kCode = detail::code_of(Attribute::jitter);
  static constexpr Value kValue = static_cast<Value>(V);
};
/// From publication to delivery. Required only: held against the provided Latency.
template <Nanoseconds V>
struct Deadline {
  static constexpr uint8_t kCode = detail::code_of(Attribute::deadline);
  static constexpr Value kValue = static_cast<Value>(V);
};
/// Between two events. A required one without a Deadline implies a Deadline of the same length.
template <Nanoseconds V>
struct Period {
  static constexpr uint8_t kCode = detail::code_of(Attribute::period);
  static constexpr Value kValue = static_cast<Value>(V);
};
/// Of payload.
template <BytesPerSecond V>
struct Bandwidth {
  static constexpr uint8_t kCode = detail::code_of(Attribute::bandwidth);
  static constexpr Value kValue = static_cast<Value>(V);
};
/// Share of the events that are lost.
template <PerBillion V>
struct PacketLoss {
  static constexpr uint8_t kCode = detail::code_of(Attribute::packet_loss);
  static constexpr Value kValue = static_cast<Value>(V);
};
/// Events lost in a row, at most; below 2^32, so that no compiler takes a negative number.
template <Value V>
struct Omission {
  static_assert(V <= 0xffffffff, "an Omission is a number of events from 0 to 4294967295");
  static constexpr uint8_t kCode = detail::code_of(Attribute::omission);
  static constexpr Value kValue = V;
};
/// Of one event: to be carried, accepted, or possible.
template <Bytes V>
struct MaxPayload {
  static constexpr uint8_t kCode = detail::code_of(Attribute::max_payload);
  static constexpr Value kValue = static_cast<Value>(V);
};

namespace detail {

/// The type that states a value of an attribute: the words of a compile-time error.
template <Attribute A, Value V>
struct Named;
template <Value V>
struct Named<Attribute::latency, V> {
  using Type = Latency<static_cast<Nanoseconds>(V)>;
};
template <Value V>
struct Named<Attribute::jitter, V> {
  using Type = Jitter<static_cast<Nanoseconds>(V)>;
};
template <Value V>
struct Named<Attribute::deadline, V> {
  using Type = Deadline<static_cast<Nanoseconds>(V)>;
};
template <Value V>
struct Named<Attribute::period, V> {
  using Type = Period<static_cast<Nanoseconds>(V)>;
};
template <Value V>
struct Named<Attribute::bandwidth, V> {
  using Type = Bandwidth<static_cast<BytesPerSecond>(V)>;
};
template <Value V>
struct Named<Attribute::packet_loss, V> {
  using Type = PacketLoss<static_cast<PerBillion>(V)>;
};
template <Value V>
struct Named<Attribute::omission, V> {
  using Type = Omission<V>;
};
template <Value V>
struct Named<Attribute::max_payload, V> {
  using Type = MaxPayload<static_cast<Bytes>(V)>;
};

}  // namespace detail

/// A provision that is a best case, as in Dynamic<Latency<5_ms>>: the network decides each request
/// at run time. It can refute at compile time, never grant. Means nothing in a requirement.
template <class A>
struct Dynamic : A {
  static constexpr uint8_t kCode = A::kCode | detail::kDynamicCode;
};

/// An attribute of the user's own. Its name is the name of the template, its value counts in
/// whatever unit the user says:
///   template <mlcca::Value kelvin>
///   struct Temperature : mlcca::UserAttribute<Temperature, kelvin, mlcca::Better::smaller,
///                                             mlcca::Composition::slowest> {};
/// C is one of sum, slowest (the maximum), smallest (the minimum), survival (shares of 1e-9) and
/// consecutive. Networks and gateways provide it; it is not compared between publisher and
/// subscriber.
template <template <Value> class Name, Value V, Better B, Composition C>
struct UserAttribute {
  static_assert(C != Composition::not_provided && C != Composition::shared_medium,
                "an attribute of the user's own has no medium and is provided by networks");
  static constexpr uint8_t kCode = detail::kUserCode;
  static constexpr Value kValue = V;
  static constexpr Better kBetter = B;
  static constexpr Composition kComposition = C;
  using Tag = Name<0>;  ///< the same whatever the value
  template <Value W>
  using With = Name<W>;
};

/// Attributes of one channel, end or network, each at most once:
///   AttributeList<Period<50_ms>, Omission<2>>
template <class... As>
struct AttributeList {
  using type = AttributeList;

  static constexpr detail::ListValues kList =
      detail::collect<sizeof...(As) + 1>({0, As::kCode...}, {0, As::kValue...});
  static_assert(kList.distinct, "an attribute is given twice in one AttributeList");

  /// The values in the units of the table, without the user's own attributes.
  static constexpr AttributeSet set() {
    return detail::collect<sizeof...(As) + 1>({0, As::kCode...}, {0, As::kValue...}).set;
  }
};

/// The set of the given attributes: make_set<Period<50_ms>, Omission<2>>().
template <class... As>
constexpr AttributeSet make_set() {
  return AttributeList<As...>::set();
}

}  // namespace mlcca
