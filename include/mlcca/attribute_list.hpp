// SPDX-License-Identifier: BSD-2-Clause
// Attributes as types, so that compile-time errors can name them with their values, and lists of
// such types: what an event channel requires, or what a network provides. C++14, freestanding.
#pragma once
#include "mlcca/attribute.hpp"
#include "mlcca/units.hpp"

namespace mlcca {
namespace detail {

/// The code byte of an attribute type: the index in the table, or kUserCode for a user-defined
/// attribute, combined with kDynamicCode for a best case.
constexpr uint8_t kUserCode = 0x40;
constexpr uint8_t kDynamicCode = 0x80;
constexpr uint8_t code_of(Attribute a) { return static_cast<uint8_t>(a); }

/// The content of an attribute list.
struct ListValues {
  AttributeSet set;
  uint8_t users = 0;  ///< number of user-defined attributes
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

/// Collects the values of a list. Element 0 is a dummy, because an array cannot be empty.
template <size_t N>
constexpr ListValues collect(const uint8_t (&codes)[N], const Value (&values)[N]) {
  ListValues list;
  for (size_t i = 1; i < N; ++i) list.add(codes[i], values[i]);
  return list;
}

}  // namespace detail

/// Latency in ns: the longest time from publication to delivery, jitter included.
template <Nanoseconds V>
struct Latency {
  static constexpr uint8_t kCode = detail::code_of(Attribute::latency);
  static constexpr Value kValue = static_cast<Value>(V);
};
/// Jitter in ns: the longest delay minus the shortest.
template <Nanoseconds V>
struct Jitter {
  static constexpr uint8_t kCode = detail::code_of(Attribute::jitter);
  static constexpr Value kValue = static_cast<Value>(V);
};
/// Deadline in ns, from publication to delivery. Used in requirements only; it is compared with the
/// provided Latency.
template <Nanoseconds V>
struct Deadline {
  static constexpr uint8_t kCode = detail::code_of(Attribute::deadline);
  static constexpr Value kValue = static_cast<Value>(V);
};
/// Period in ns between two events. A required Period without a Deadline implies a Deadline of the
/// same length.
template <Nanoseconds V>
struct Period {
  static constexpr uint8_t kCode = detail::code_of(Attribute::period);
  static constexpr Value kValue = static_cast<Value>(V);
};
/// Bandwidth in payload bytes/s.
template <BytesPerSecond V>
struct Bandwidth {
  static constexpr uint8_t kCode = detail::code_of(Attribute::bandwidth);
  static constexpr Value kValue = static_cast<Value>(V);
};
/// PacketLoss: the share of events that are lost, in 1e-9.
template <PerBillion V>
struct PacketLoss {
  static constexpr uint8_t kCode = detail::code_of(Attribute::packet_loss);
  static constexpr Value kValue = static_cast<Value>(V);
};
/// Omission: the most events that may be lost in a row. It is limited to 32 bits, so that a
/// negative number does not compile.
template <Value V>
struct Omission {
  static_assert(V <= 0xffffffff, "an Omission is a number of events from 0 to 4294967295");
  static constexpr uint8_t kCode = detail::code_of(Attribute::omission);
  static constexpr Value kValue = V;
};
/// MaxPayload: the payload bytes of one event that are sent, accepted, or can be carried.
template <Bytes V>
struct MaxPayload {
  static constexpr uint8_t kCode = detail::code_of(Attribute::max_payload);
  static constexpr Value kValue = static_cast<Value>(V);
};

namespace detail {

/// The attribute type for an attribute and a value, to be named in a compile-time error.
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

/// Marks a provision as a best case, as in Dynamic<Latency<5_ms>>. At compile time it can refute a
/// requirement, never grant one; the network decides each request at run time. It has no meaning in
/// a requirement.
template <class A>
struct Dynamic : A {
  static constexpr uint8_t kCode = A::kCode | detail::kDynamicCode;
};

/// Base of user-defined attributes. The name of your template is the name of the attribute, and its
/// values are in a unit of your choice:
///   template <mlcca::Value kelvin>
///   struct Temperature : mlcca::UserAttribute<Temperature, kelvin, mlcca::Better::smaller,
///                                             mlcca::Composition::slowest> {};
/// C is one of sum, slowest (the maximum), smallest (the minimum), survival (shares of 1e-9) and
/// consecutive. The attribute is compared with networks and gateways, not between publisher and
/// subscriber.
template <template <Value> class Name, Value V, Better B, Composition C>
struct UserAttribute {
  static_assert(C != Composition::not_provided && C != Composition::shared_medium,
                "an attribute of the user's own has no medium and is provided by networks");
  static constexpr uint8_t kCode = detail::kUserCode;
  static constexpr Value kValue = V;
  static constexpr Better kBetter = B;
  static constexpr Composition kComposition = C;
  using Tag = Name<0>;  ///< identifies the attribute, whatever its value
  template <Value W>
  using With = Name<W>;
};

/// The attributes of one channel, endpoint or network, each at most once:
/// AttributeList<Period<50_ms>, Omission<2>>.
template <class... As>
struct AttributeList {
  using type = AttributeList;

  static constexpr detail::ListValues kList =
      detail::collect<sizeof...(As) + 1>({0, As::kCode...}, {0, As::kValue...});
  static_assert(kList.distinct, "an attribute is given twice in one AttributeList");

  /// The values in the units of the table. User-defined attributes are not included.
  static constexpr AttributeSet set() {
    return detail::collect<sizeof...(As) + 1>({0, As::kCode...}, {0, As::kValue...}).set;
  }
};

/// Makes a set of attributes: make_set<Period<50_ms>, Omission<2>>().
template <class... As>
constexpr AttributeSet make_set() {
  return AttributeList<As...>::set();
}

}  // namespace mlcca
