// SPDX-License-Identifier: BSD-2-Clause
// The definitions that writer and reader of the run-time representation share: proto/mlcca.asn1 in
// C++. C++14, freestanding.
#pragma once
#include "mlcca/attribute.hpp"

namespace mlcca {
namespace der {

/// The 64-bit identity of a channel.
using Subject = uint64_t;

/// To whom the attributes belong. The numbers are part of the wire format.
enum class Role : uint8_t { publisher = 0, subscriber = 1, network = 2 };
constexpr uint8_t kRoles = 3;

constexpr uint8_t kVersion = 1;
constexpr size_t kMaxUserAttributes = 16;
constexpr size_t kMaxName = 63;  ///< octets

/// A user-defined attribute. It refers to its name and does not own it.
struct UserAttribute {
  const char* name = nullptr;  ///< UTF-8, not terminated, 1 to kMaxName octets
  size_t name_size = 0;
  Value value = 0;
  bool dynamic = false;  ///< a best case; allowed for a network only

  constexpr UserAttribute() = default;
  constexpr UserAttribute(const char* text, size_t size, Value v, bool best_case = false)
      : name(text), name_size(size), value(v), dynamic(best_case) {}
  /// Constructs from a literal: UserAttribute{"Temperature", 300}.
  template <size_t N>
  constexpr UserAttribute(const char (&text)[N], Value v, bool best_case = false)
      : UserAttribute(text, N - 1, v, best_case) {}
};

/// Why an encoding, or a value to be encoded, is refused.
enum class Error : uint8_t {
  none,
  truncated,        ///< an element announces more octets than there are
  trailing,         ///< octets after the end
  too_long,         ///< more octets than the reader accepts
  tag,              ///< another element is expected here
  order,            ///< an attribute is in the wrong place or occurs twice
  length,           ///< indefinite, not in its shortest form, or not the fixed one
  version,          ///< not kVersion
  role,             ///< unknown, or not the one that the reader expects
  subject,          ///< 0 for a publisher or subscriber
  integer,          ///< empty, negative, not in its shortest form, or above 2^64 - 1
  marks,            ///< malformed, for an absent attribute, or in a requirement
  name,             ///< of a user-defined attribute: length, UTF-8 or control characters
  user_attributes,  ///< none, too many, or any at all if the reader knows none
  range,            ///< well-formed, but not representable in the reader's units
};

/// The text of an error for logs and error messages.
constexpr const char* to_text(Error error) {
  switch (error) {
    case Error::none:
      return "no error";
    case Error::truncated:
      return "an element announces more octets than there are";
    case Error::trailing:
      return "octets after the end";
    case Error::too_long:
      return "longer than the reader takes";
    case Error::tag:
      return "unexpected tag";
    case Error::order:
      return "wrong order, or given twice";
    case Error::length:
      return "wrong length, or not in its shortest form";
    case Error::version:
      return "unknown version";
    case Error::role:
      return "unknown or unexpected role";
    case Error::subject:
      return "subject 0";
    case Error::integer:
      return "not an integer of 0 to 2^64 - 1 in its shortest form";
    case Error::marks:
      return "malformed or misplaced dynamic mark";
    case Error::name:
      return "malformed name of a user attribute";
    case Error::user_attributes:
      return "number of user attributes";
    case Error::range:
      return "value does not fit the reader's units";
  }
  return "unknown error";
}

/// The result of a reader.
struct Status {
  Error error = Error::none;
  uint16_t offset = 0;  ///< of the octet or element that is refused; 0 if there is no error

  constexpr bool ok() const { return error == Error::none; }
};

namespace detail {

constexpr uint8_t kBoolean = 0x01;
constexpr uint8_t kInteger = 0x02;
constexpr uint8_t kOctetString = 0x04;
constexpr uint8_t kEnumerated = 0x0a;
constexpr uint8_t kUtf8String = 0x0c;
constexpr uint8_t kSequence = 0x30;
constexpr uint8_t kContext = 0x80;  // primitive, number in the low bits
constexpr uint8_t kMarks = kContext;
constexpr uint8_t kTrue = 0xff;

constexpr uint8_t kSubjectSize = 8;
constexpr uint8_t kMaxMagnitude = 8;  // octets of the largest Value

constexpr bool tags_follow_table() {
  for (size_t i = 0; i < kAttributes; ++i)
    if (kAttributeTable[i].tag != i + 1) return false;
  return true;
}
static_assert(tags_follow_table() && kAttributes <= 30,
              "a tag is the attribute's index + 1, and of one octet (X.690, 8.1.2.2)");

/// The octets of the BIT STRING with a mark for each attribute.
constexpr size_t kMarkOctets = (kAttributes + 7) / 8;
static_assert(kMarkOctets <= sizeof(AttributeBits), "the marks are held as one bit each");

/// The mark of an attribute in the BIT STRING, whose first bit is the highest.
constexpr AttributeBits mark_of(Attribute a) {
  return static_cast<AttributeBits>(1U << (8 * kMarkOctets - 1) >> index_of(a));
}

// Sizes of the largest elements, header included.
constexpr size_t kMaxInteger = 2 + 1 + kMaxMagnitude;
constexpr size_t kMaxAttributes = 2 + 3 + kMarkOctets + kAttributes * kMaxInteger;
constexpr size_t kMaxUserAttribute = 2 + (2 + kMaxName) + kMaxInteger + 3;
constexpr size_t kHead = 3 + 3 + 2 + kSubjectSize;  // version, role, subject

}  // namespace detail

/// The size of the largest encoding without user-defined attributes.
constexpr size_t kMaxPlainSize = 2 + detail::kHead + detail::kMaxAttributes;
/// The size of the largest encoding.
constexpr size_t kMaxSize =
    4 + detail::kHead + detail::kMaxAttributes + 4 + kMaxUserAttributes * detail::kMaxUserAttribute;
static_assert(kAttributes != 8 || (kMaxPlainSize == 112 && kMaxSize == 1414),
              "part of the documentation");

namespace detail {

constexpr bool within(uint8_t octet, uint8_t from, uint8_t to) {
  return octet >= from && octet <= to;
}

/// The length of the well-formed UTF-8 sequence (RFC 3629, section 4) that starts at text[at]; 0 if
/// there is none.
template <class Octet>
constexpr size_t utf8_sequence(const Octet* text, size_t at, size_t end) {
  const auto first = static_cast<uint8_t>(text[at]);
  if (first < 0x80) return 1;
  if (!within(first, 0xc2, 0xf4)) return 0;
  const size_t length = first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  if (end - at < length) return 0;
  const uint8_t from = first == 0xe0 ? 0xa0 : first == 0xf0 ? 0x90 : 0x80;
  const uint8_t to = first == 0xed ? 0x9f : first == 0xf4 ? 0x8f : 0xbf;
  if (!within(static_cast<uint8_t>(text[at + 1]), from, to)) return 0;
  for (size_t i = 2; i < length; ++i)
    if (!within(static_cast<uint8_t>(text[at + i]), 0x80, 0xbf)) return 0;
  return length;
}

/// Whether the text is a valid name: 1 to kMaxName octets of UTF-8 without the control characters
/// U+0000 to U+001F and U+007F.
template <class Octet>
constexpr bool is_name(const Octet* text, size_t size) {
  if (size == 0 || size > kMaxName) return false;
  for (size_t at = 0; at < size;) {
    const auto first = static_cast<uint8_t>(text[at]);
    const size_t length = utf8_sequence(text, at, size);
    if (first < 0x20 || first == 0x7f || length == 0) return false;
    at += length;
  }
  return true;
}

/// The order of names, by their octets.
template <class Octet>
constexpr bool name_less(const Octet* a, size_t a_size, const Octet* b, size_t b_size) {
  for (size_t i = 0; i < a_size && i < b_size; ++i)
    if (a[i] != b[i]) return static_cast<uint8_t>(a[i]) < static_cast<uint8_t>(b[i]);
  return a_size < b_size;
}

}  // namespace detail
}  // namespace der
}  // namespace mlcca
