// SPDX-License-Identifier: BSD-2-Clause
// Attribute sets for nodes that cannot afford 64-bit nanoseconds: values of 16 or 32 bits in units
// that the node chooses, and check 1 (figure 5 of the paper) over them. C++14, freestanding, no
// heap; the check needs neither a division nor anything wider than the node's own value.
#pragma once
#include "mlcca/attribute.hpp"
#include "mlcca/satisfies.hpp"
#include "mlcca/values_of.hpp"

namespace mlcca {

/// Units for 16-bit values: times up to 65.5 s, rates up to 1 MB/s (a CAN bus carries 0.1), any
/// loss.
struct Units16 {
  using Value = uint16_t;                     ///< uint16_t or uint32_t
  static constexpr uint32_t kTime = 1000000;  ///< ns per unit of all four times
  static constexpr uint32_t kRate = 16;       ///< bytes/s per unit of Bandwidth
  static constexpr uint32_t kLoss = 100000;   ///< 1e-9 per unit of PacketLoss
  static constexpr uint32_t kEvents = 1;      ///< events per unit of Omission
  static constexpr uint32_t kSize = 1;        ///< bytes per unit of MaxPayload
};

/// Units for 32-bit values: times up to 4294 s in microseconds, rates up to 4.29 GB/s, any loss.
struct Units32 {
  using Value = uint32_t;
  static constexpr uint32_t kTime = 1000;
  static constexpr uint32_t kRate = 1;
  static constexpr uint32_t kLoss = 1;
  static constexpr uint32_t kEvents = 1;
  static constexpr uint32_t kSize = 1;
};

/// Whether a set is a requirement or a provision. It decides how values are rounded, what an absent
/// value means, and what follows from a Period.
enum class Side : uint8_t { requirement, provision };

namespace detail {

/// 1 << index_of(a) as AttributeBits. A processor that shifts one place at a time needs fewer steps
/// for so few bits.
constexpr AttributeBits narrow_bit(Attribute a) {
  AttributeBits bit = 1;
  for (auto i = static_cast<uint8_t>(a); i != 0; --i) bit = static_cast<AttributeBits>(bit + bit);
  return bit;
}

/// The set of attributes for which larger is better, one bit each.
constexpr AttributeBits larger_is_better() {
  unsigned bits = 0;
  for (size_t i = 0; i < kAttributes; ++i)
    if (kAttributeTable[i].better == Better::larger) bits |= 1U << i;
  return static_cast<AttributeBits>(bits);
}
constexpr AttributeBits kLargerIsBetter = larger_is_better();

constexpr bool narrow_larger(Attribute a) { return (kLargerIsBetter & narrow_bit(a)) != 0; }

/// The size of the node's unit in units of the table. It consists of comparisons, because a table
/// would occupy RAM on an AVR.
template <class Units>
constexpr uint32_t narrow_unit(Attribute a) {
  if (a < Attribute::bandwidth) return Units::kTime;
  if (a == Attribute::bandwidth) return Units::kRate;
  if (a == Attribute::packet_loss) return Units::kLoss;
  return a == Attribute::omission ? Units::kEvents : Units::kSize;
}
static_assert(kAttributes == 8, "a new attribute needs its unit");

constexpr bool is_unit(uint32_t unit) { return unit != 0 && unit < 0x80000000; }

/// magnitude / unit, where magnitude has `size` octets, the highest first. It divides bit by bit,
/// which is the smallest code of all ways to divide 64 bits. Rounded up or down; the largest Count
/// if the quotient does not fit below it.
///
/// Not inlined, so that it uses only registers that a function need not save.
template <class Count>
__attribute__((noinline)) constexpr Count divide_magnitude(const uint8_t* magnitude, uint8_t size,
                                                           uint32_t unit, bool up) {
  constexpr auto no_bound = static_cast<Count>(~Count{0});
  Count quotient = 0;
  uint32_t rest = 0;
  for (; size != 0; --size, ++magnitude) {
    uint8_t octet = *magnitude;
    for (uint8_t bit = 0; bit < 8; ++bit) {
      if (quotient > no_bound / 2) return no_bound;
      quotient = static_cast<Count>(quotient << 1);
      rest <<= 1;
      if ((octet & 0x80) != 0) rest |= 1;
      octet = static_cast<uint8_t>(octet << 1);
      if (rest >= unit) {
        rest -= unit;
        ++quotient;
      }
    }
  }
  if (up && rest != 0 && quotient != no_bound) ++quotient;
  return quotient;
}

}  // namespace detail

/// Values of some attributes on one side of the check, in the node's units and normalised: a
/// requirement with a Period and no Deadline gets the Deadline, a provision with a Period and no
/// Latency gets the Latency, and the Latency of a provision is stored as its Deadline too.
///
/// It is made from an AttributeSet (narrow(), to_narrow()) or from an encoding (der_narrow.hpp).
/// These round requirements towards harder and provisions towards worse. The largest value means
/// "no bound" or "does not fit": a provision saturates there, a requirement cannot have it.
template <class Units, Side S>
class NarrowSet {
 public:
  using Count = typename Units::Value;
  static_assert(Count(-1) > 0 && sizeof(Count) <= 4, "unsigned, at most 32 bits");
  static_assert(detail::is_unit(Units::kTime) && detail::is_unit(Units::kRate) &&
                    detail::is_unit(Units::kLoss) && detail::is_unit(Units::kEvents) &&
                    detail::is_unit(Units::kSize),
                "a unit is 1 to 2^31 - 1");

  constexpr bool has(Attribute a) const { return (present_ & detail::narrow_bit(a)) != 0; }
  constexpr bool is_dynamic(Attribute a) const { return (dynamic_ & detail::narrow_bit(a)) != 0; }
  /// The value in the node's unit; 0 if the attribute is absent.
  constexpr Count operator[](Attribute a) const {
    if (!has(a)) return 0;
    return quality_of(detail::narrow_bit(a), quality_[index_of(a)]);
  }

  /// Sets one attribute to a magnitude in the unit of the table, the highest octet first. Returns
  /// false and sets nothing if a requirement is too large. A dynamic mark has no meaning in a
  /// requirement, a Deadline none in a provision. Call normalise() after the last attribute.
  constexpr bool set(Attribute a, const uint8_t* magnitude, uint8_t size, bool dynamic) {
    const AttributeBits bit = detail::narrow_bit(a);
    const bool up = ((detail::kLargerIsBetter & bit) != 0) == (S == Side::requirement);
    Count count =
        detail::divide_magnitude<Count>(magnitude, size, detail::narrow_unit<Units>(a), up);
    if (S == Side::requirement && count == kNoBound) return false;
    if (S == Side::provision && a == Attribute::packet_loss && count > kCertain) count = kCertain;
    quality_[index_of(a)] = quality_of(bit, count);
    present_ = static_cast<AttributeBits>(present_ | bit);
    if (S == Side::provision && dynamic) dynamic_ = static_cast<AttributeBits>(dynamic_ | bit);
    return true;
  }

  /// Adds what follows from a Period, and to a provision the Latency as its Deadline.
  constexpr void normalise() {
    if (S == Side::requirement) {
      if (!has(Attribute::deadline)) copy(Attribute::period, Attribute::deadline);
    } else {
      if (!has(Attribute::latency)) copy(Attribute::period, Attribute::latency);
      clear(Attribute::deadline);
      copy(held_against(Attribute::deadline), Attribute::deadline);
    }
  }

  constexpr NarrowSet& clear(Attribute a) {
    quality_[index_of(a)] = 0;
    present_ = static_cast<AttributeBits>(present_ & ~detail::narrow_bit(a));
    dynamic_ = static_cast<AttributeBits>(dynamic_ & ~detail::narrow_bit(a));
    return *this;
  }

  /// Takes over all values of another requirement that are harder.
  constexpr NarrowSet& unite(const NarrowSet& other) {
    static_assert(S == Side::requirement, "provisions compose, see compose()");
    for (uint8_t i = 0; i < kAttributes; ++i)
      if (other.quality_[i] > quality_[i]) quality_[i] = other.quality_[i];
    present_ = static_cast<AttributeBits>(present_ | other.present_);
    return *this;
  }

  /// The value in a form that is better when larger, for any attribute; 0 if it is absent.
  constexpr Count quality(uint8_t index) const { return quality_[index]; }
  /// One bit for each attribute that is present, 1 << index_of(attribute).
  constexpr AttributeBits present() const { return present_; }
  constexpr AttributeBits dynamic() const { return dynamic_; }

 private:
  static constexpr Count kNoBound = static_cast<Count>(~Count{0});
  /// A loss of 100 % in the node's unit; no loss is larger.
  static constexpr uint32_t kCertainUnits =
      static_cast<uint32_t>(kCertainLoss / Units::kLoss + (kCertainLoss % Units::kLoss != 0));
  static constexpr Count kCertain =
      kCertainUnits < kNoBound ? static_cast<Count>(kCertainUnits) : kNoBound;

  /// Converts between value and quality; it is its own inverse.
  static constexpr Count quality_of(AttributeBits bit, Count count) {
    return (detail::kLargerIsBetter & bit) != 0 ? count : static_cast<Count>(~count);
  }
  constexpr void copy(Attribute from, Attribute to) {
    if (!has(from)) return;
    quality_[index_of(to)] = quality_[index_of(from)];
    present_ = static_cast<AttributeBits>(present_ | detail::narrow_bit(to));
    if (S == Side::provision && is_dynamic(from))
      dynamic_ = static_cast<AttributeBits>(dynamic_ | detail::narrow_bit(to));
  }

  Count quality_[kAttributes] = {};
  AttributeBits present_ = 0;
  AttributeBits dynamic_ = 0;
};

template <class Units>
using NarrowRequirement = NarrowSet<Units, Side::requirement>;
template <class Units>
using NarrowProvision = NarrowSet<Units, Side::provision>;

/// The result of check_layer(): one bit for each required attribute, 1 << index_of(attribute).
struct NarrowCheck {
  AttributeBits unfit = 0;
  AttributeBits run_time = 0;

  constexpr Outcome outcome() const {
    if (unfit != 0) return Outcome::unfit;
    return run_time != 0 ? Outcome::run_time : Outcome::fit;
  }
  constexpr Outcome outcome(Attribute a) const {
    if ((unfit & detail::narrow_bit(a)) != 0) return Outcome::unfit;
    return (run_time & detail::narrow_bit(a)) != 0 ? Outcome::run_time : Outcome::fit;
  }
};

/// Check 1: a requirement against one network layer. The rules are those of check_layer() for
/// AttributeSets. The outcome is the same if every value is a multiple of its unit, otherwise never
/// better.
template <class Units>
constexpr NarrowCheck check_layer(const NarrowSet<Units, Side::requirement>& requirement,
                                  const NarrowSet<Units, Side::provision>& provision) {
  auto unfit = static_cast<AttributeBits>(requirement.present() & ~provision.present());
  AttributeBits bit = 1;
  for (uint8_t i = 0; i < kAttributes; ++i) {
    if (provision.quality(i) < requirement.quality(i))
      unfit = static_cast<AttributeBits>(unfit | bit);
    bit = static_cast<AttributeBits>(bit << 1);
  }
  NarrowCheck check;
  check.unfit = unfit;
  check.run_time = static_cast<AttributeBits>(requirement.present() & provision.dynamic() & ~unfit);
  return check;
}

/// The requirement of a publisher and a subscriber towards the networks between them, by the rules
/// of requirement_between() for AttributeSets: the harder of both values; the publisher's Jitter
/// requires nothing; the subscriber's MaxPayload counts only if the publisher states none.
template <class Units>
constexpr NarrowSet<Units, Side::requirement> requirement_between(
    NarrowSet<Units, Side::requirement> publisher, NarrowSet<Units, Side::requirement> subscriber) {
  publisher.clear(Attribute::jitter);
  if (publisher.has(Attribute::max_payload)) subscriber.clear(Attribute::max_payload);
  return publisher.unite(subscriber);
}

/// Converts a set at run time. Returns false and leaves *out unchanged if a requirement is too
/// large.
template <class Units, Side S>
__attribute__((warn_unused_result)) constexpr bool to_narrow(const AttributeSet& set,
                                                             NarrowSet<Units, S>* out) {
  NarrowSet<Units, S> result;
  for (size_t i = 0; i < kAttributes; ++i) {
    const Attribute a = attribute_at(i);
    if (!set.has(a)) continue;
    uint8_t magnitude[sizeof(Value)] = {};
    for (size_t k = 0; k < sizeof(Value); ++k)
      magnitude[k] = static_cast<uint8_t>(set[a] >> (8 * (sizeof(Value) - 1 - k)) & 0xff);
    if (!result.set(a, magnitude, sizeof(Value), set.is_dynamic(a))) return false;
  }
  result.normalise();
  *out = result;
  return true;
}

namespace detail {

/// Whether each value fits the units. At compile time that is demanded of provisions too.
template <class Units, Side S>
constexpr bool fits(const AttributeSet& set) {
  NarrowSet<Units, S> narrow;
  if (!to_narrow(set, &narrow)) return false;
  constexpr auto no_bound = static_cast<typename Units::Value>(~typename Units::Value{0});
  for (size_t i = 0; i < kAttributes; ++i) {
    const Attribute a = attribute_at(i);
    if (!set.has(a) || set[a] == kUnbounded || (S == Side::provision && a == Attribute::deadline))
      continue;
    if (narrow[a] == no_bound) return false;
  }
  return true;
}

}  // namespace detail

/// Converts an attribute list (any type with a set()) at compile time; values that are too large
/// for the units do not compile. Example:
/// `constexpr auto kNeeds = narrow<Units16, Side::requirement, Attributes>();`
template <class Units, Side S, class Attributes>
constexpr NarrowSet<Units, S> narrow() {
  static_assert(detail::fits<Units, S>(values_of<Attributes>()),
                "an attribute is too large for the units of this node");
  NarrowSet<Units, S> result;
  return to_narrow(values_of<Attributes>(), &result) ? result : NarrowSet<Units, S>();
}

}  // namespace mlcca
