// SPDX-License-Identifier: BSD-2-Clause
// The attributes: one table from which every name, tag, unit and direction comes.
// C++14, freestanding: usable from an 8-bit node to the daemon.
#pragma once
#include <stddef.h>
#include <stdint.h>

namespace mlcca {

/// Every quantity is an unsigned integer in the unit of the table below.
using Value = uint64_t;

/// The largest value stands for "no bound": it never satisfies a "smaller is better" requirement
/// other than itself, and arithmetic saturates at it.
constexpr Value kUnbounded = ~Value{0};

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

/// A bit for each attribute, 1 << index: as narrow as holds all of them, since nodes count octets.
using AttributeBits = detail::AttributeBitsOf<(kAttributes <= 8)>::Type;
static_assert(kAttributes <= 8 * sizeof(AttributeBits), "one bit for each attribute");

enum class Better : uint8_t { smaller, larger };

/// How the provision of a route follows from the provisions of its hops.
enum class Composition : uint8_t {
  sum,            ///< saturating sum
  not_provided,   ///< nobody provides it; it is held against another attribute
  slowest,        ///< maximum of the periods
  shared_medium,  ///< reciprocal sum within a medium, then minimum over media
  survival,       ///< 1 - product(1 - p)
  consecutive,    ///< (a + 1)(b + 1) - 1
  smallest,       ///< minimum
};

struct AttributeInfo {
  const char* name;  ///< as in XML, errors, command line and log
  uint8_t tag;       ///< DER context tag and protobuf number
  const char* unit;  ///< unit of Value
  Better better;
  Composition composition;
};

/// Largest loss: one, as 1e-9 units.
constexpr Value kCertainLoss = 1000000000;

/// Indexed by Attribute. The order and the tags are part of the wire formats: append only.
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

/// Values of some of the attributes. `dynamic` marks a provision that is only a best case: it can
/// refute, never grant. The members call as little as they can: a compiler evaluates them for every
/// compile-time check.
class AttributeSet {
 public:
  constexpr bool has(Attribute a) const { return (present_ & (1U << static_cast<size_t>(a))) != 0; }
  constexpr bool is_dynamic(Attribute a) const {
    return (dynamic_ & (1U << static_cast<size_t>(a))) != 0;
  }
  constexpr bool empty() const { return present_ == 0; }

  /// The value, or 0 where the attribute is absent: ask has() first.
  constexpr Value operator[](Attribute a) const { return value_[static_cast<size_t>(a)]; }

  constexpr AttributeSet& set(Attribute a, Value v, bool dynamic = false) {
    const unsigned bit = 1U << static_cast<size_t>(a);
    value_[static_cast<size_t>(a)] = v;
    present_ = static_cast<AttributeBits>(present_ | bit);
    dynamic_ = static_cast<AttributeBits>(dynamic ? dynamic_ | bit : dynamic_ & ~bit);
    return *this;
  }
  constexpr AttributeSet& clear(Attribute a) {
    const unsigned bit = 1U << static_cast<size_t>(a);
    value_[static_cast<size_t>(a)] = 0;
    present_ = static_cast<AttributeBits>(present_ & ~bit);
    dynamic_ = static_cast<AttributeBits>(dynamic_ & ~bit);
    return *this;
  }
  /// Takes every value as it is: a best case means nothing in a requirement.
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
