// SPDX-License-Identifier: BSD-2-Clause
// The attributes of communication: one table that defines every name, tag, unit and direction.
// C++14, freestanding: the same header serves the daemon and an 8-bit node.
#pragma once
#include <stddef.h>
#include <stdint.h>

namespace mlcca {

/// The type of every quantity: an unsigned integer in the unit that kAttributeTable states.
using Value = uint64_t;

/// The largest Value means "no bound". As a provision it satisfies no requirement for which smaller
/// is better (except one without a bound), and arithmetic saturates at it.
constexpr Value kUnbounded = ~Value{0};

/// The built-in attributes. docs/reference/units.md describes them.
enum class Attribute : uint8_t {
  latency,
  jitter,
  deadline,
  period,
  bandwidth,
  packet_loss,
  omission,
  max_payload,
};
constexpr size_t kAttributes = 8;

namespace detail {
template <bool FitsAnOctet>
struct AttributeBitsOf {
  using Type = uint8_t;
};
template <>
struct AttributeBitsOf<false> {
  using Type = uint16_t;
};
}  // namespace detail

/// One bit for each attribute, 1 << index. The type is as narrow as possible, because memory is
/// scarce on nodes.
using AttributeBits = detail::AttributeBitsOf<(kAttributes <= 8)>::Type;
static_assert(kAttributes <= 8 * sizeof(AttributeBits), "one bit for each attribute");

/// Which values of an attribute are better.
enum class Better : uint8_t { smaller, larger };

/// How the provision of a route is computed from the provisions of its hops.
enum class Composition : uint8_t {
  sum,            ///< sum, saturating
  not_provided,   ///< no hop provides it; a requirement is compared with another attribute
                  ///< (held_against())
  slowest,        ///< maximum
  shared_medium,  ///< reciprocal sum within each shared medium, then the minimum over the media
  survival,       ///< 1 - product(1 - p): an event is lost if any hop loses it
  consecutive,    ///< product(n + 1) - 1: the worst combination of consecutive losses
  smallest,       ///< minimum
};

/// What defines an attribute.
struct AttributeInfo {
  const char* name;  ///< name in XML, error texts, commands and logs
  uint8_t tag;       ///< DER context tag and protobuf field number
  const char* unit;  ///< the unit of its Values
  Better better;
  Composition composition;
};

/// The largest loss: all events, in units of 1e-9.
constexpr Value kCertainLoss = 1000000000;

/// Indexed by Attribute. Order and tags are part of the wire formats, so rows may only be appended.
constexpr AttributeInfo kAttributeTable[kAttributes] = {
    {"Latency", 1, "ns", Better::smaller, Composition::sum},
    {"Jitter", 2, "ns", Better::smaller, Composition::sum},
    {"Deadline", 3, "ns", Better::smaller, Composition::not_provided},
    {"Period", 4, "ns", Better::smaller, Composition::slowest},
    {"Bandwidth", 5, "bytes/s", Better::larger, Composition::shared_medium},
    {"PacketLoss", 6, "1e-9", Better::smaller, Composition::survival},
    {"Omission", 7, "events", Better::smaller, Composition::consecutive},
    {"MaxPayload", 8, "bytes", Better::larger, Composition::smallest},
};

constexpr size_t index_of(Attribute a) { return static_cast<size_t>(a); }
constexpr Attribute attribute_at(size_t i) { return static_cast<Attribute>(i); }
constexpr const AttributeInfo& info(Attribute a) { return kAttributeTable[index_of(a)]; }

/// Values for some of the attributes: a requirement, a provision or a traffic specification.
/// `dynamic` marks a provision that is only a best case: it can refute a requirement but never
/// grant one.
///
/// The members call few functions, because the compiler evaluates them in every compile-time check.
class AttributeSet {
 public:
  /// Whether the attribute has a value.
  constexpr bool has(Attribute a) const { return (present_ & (1U << static_cast<size_t>(a))) != 0; }
  /// Whether its value is a best case.
  constexpr bool is_dynamic(Attribute a) const {
    return (dynamic_ & (1U << static_cast<size_t>(a))) != 0;
  }
  constexpr bool empty() const { return present_ == 0; }

  /// The value, or 0 if the attribute is absent: ask has() first.
  constexpr Value operator[](Attribute a) const { return value_[static_cast<size_t>(a)]; }

  /// Sets an attribute; a former value is replaced.
  constexpr AttributeSet& set(Attribute a, Value v, bool dynamic = false) {
    const unsigned bit = 1U << static_cast<size_t>(a);
    value_[static_cast<size_t>(a)] = v;
    present_ = static_cast<AttributeBits>(present_ | bit);
    dynamic_ = static_cast<AttributeBits>(dynamic ? dynamic_ | bit : dynamic_ & ~bit);
    return *this;
  }
  /// Removes an attribute.
  constexpr AttributeSet& clear(Attribute a) {
    const unsigned bit = 1U << static_cast<size_t>(a);
    value_[static_cast<size_t>(a)] = 0;
    present_ = static_cast<AttributeBits>(present_ & ~bit);
    dynamic_ = static_cast<AttributeBits>(dynamic_ & ~bit);
    return *this;
  }
  /// Removes all dynamic marks. They have no meaning in a requirement.
  constexpr AttributeSet& clear_dynamic() {
    dynamic_ = 0;
    return *this;
  }

  friend constexpr bool operator==(const AttributeSet& a, const AttributeSet& b) {
    if (a.present_ != b.present_ || a.dynamic_ != b.dynamic_) return false;
    for (size_t i = 0; i < kAttributes; ++i)
      if (a.value_[i] != b.value_[i]) return false;
    return true;
  }
  friend constexpr bool operator!=(const AttributeSet& a, const AttributeSet& b) {
    return !(a == b);
  }

 private:
  Value value_[kAttributes] = {};
  AttributeBits present_ = 0;
  AttributeBits dynamic_ = 0;
};

}  // namespace mlcca
