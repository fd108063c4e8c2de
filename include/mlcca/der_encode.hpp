// SPDX-License-Identifier: BSD-2-Clause
// Writes the run-time representation (proto/mlcca.asn1): at compile time into an array of exactly
// the right size, at run time into a buffer of the caller. C++14, freestanding.
#pragma once
#include "mlcca/der_format.hpp"
#include "mlcca/values_of.hpp"

namespace mlcca {
namespace der {

/// The attributes of an event channel, or of a network, to be encoded.
struct Channel {
  Role role = Role::subscriber;
  Subject subject = 0;
  AttributeSet attributes;
  const UserAttribute* user = nullptr;  ///< sorted by name without duplicates; owned by the caller
  size_t users = 0;

  constexpr Channel() = default;
  constexpr Channel(Role r, Subject s, const AttributeSet& a, const UserAttribute* u = nullptr,
                    size_t n = 0)
      : role(r), subject(s), attributes(a), user(u), users(n) {}
};

namespace detail {

/// The number of octets of v without leading zeros, at least one.
constexpr uint8_t magnitude_size(Value v) {
  uint8_t size = 1;
  for (; (v >>= 8) != 0;) ++size;
  return size;
}

/// The number of octets of an INTEGER's contents: one more if the highest bit would be read as a
/// sign.
constexpr uint8_t integer_size(Value v) {
  const uint8_t size = magnitude_size(v);
  return static_cast<uint8_t>(size + ((v >> (8 * size - 1)) & 1));
}

/// The number of octets of an element with so many octets of contents.
constexpr size_t element_size(size_t contents) {
  return contents + (contents < 0x80 ? 2 : contents < 0x100 ? 3 : 4);
}

constexpr AttributeBits marks_of(const AttributeSet& set) {
  AttributeBits marks = 0;
  for (size_t i = 0; i < kAttributes; ++i)
    if (set.is_dynamic(attribute_at(i)))
      marks = static_cast<AttributeBits>(marks | mark_of(attribute_at(i)));
  return marks;
}

/// The number of trailing zero bits, which are not encoded (X.690, 11.2.2).
constexpr uint8_t unused_bits(AttributeBits marks) {
  uint8_t unused = 0;
  while ((marks >> unused & 1) == 0) ++unused;
  return unused;
}
constexpr size_t mark_octets(AttributeBits marks) { return kMarkOctets - unused_bits(marks) / 8; }

constexpr size_t attributes_size(const AttributeSet& set) {
  const AttributeBits marks = marks_of(set);
  size_t size = marks != 0 ? 3 + mark_octets(marks) : 0;
  for (size_t i = 0; i < kAttributes; ++i)
    if (set.has(attribute_at(i))) size += 2 + integer_size(set[attribute_at(i)]);
  return size;
}

constexpr size_t user_size(const UserAttribute& user) {
  return 2 + user.name_size + 2 + integer_size(user.value) + (user.dynamic ? 3 : 0);
}

constexpr size_t users_size(const Channel& channel) {
  size_t size = 0;
  for (size_t i = 0; i < channel.users; ++i) size += element_size(user_size(channel.user[i]));
  return size;
}

constexpr size_t channel_size(const Channel& channel) {
  return kHead + element_size(attributes_size(channel.attributes)) +
         (channel.users != 0 ? element_size(users_size(channel)) : 0);
}

/// Appends octets to a buffer. The caller must have made sure that there is room.
class Writer {
 public:
  constexpr explicit Writer(uint8_t* out) : out_(out) {}

  constexpr void octet(uint8_t v) { out_[at_++] = v; }
  constexpr void header(uint8_t tag, size_t length) {
    octet(tag);
    if (length >= 0x100) {
      octet(0x82);
      octet(static_cast<uint8_t>(length >> 8));
    } else if (length >= 0x80) {
      octet(0x81);
    }
    octet(static_cast<uint8_t>(length & 0xff));
  }
  constexpr void big_endian(Value v, uint8_t size) {
    for (uint8_t left = size; left != 0; --left)
      octet(left > kMaxMagnitude ? uint8_t{0} : static_cast<uint8_t>(v >> (8 * (left - 1)) & 0xff));
  }
  constexpr void integer(uint8_t tag, Value v) {
    header(tag, integer_size(v));
    big_endian(v, integer_size(v));
  }
  constexpr size_t written() const { return at_; }

 private:
  uint8_t* out_;
  size_t at_ = 0;
};

/// Writes the number of unused bits of the last octet, then the bits.
constexpr void write_marks(Writer& out, AttributeBits marks) {
  const size_t octets = mark_octets(marks);
  out.header(kMarks, 1 + octets);
  out.octet(static_cast<uint8_t>(unused_bits(marks) % 8));
  for (size_t i = 0; i < octets; ++i)
    out.octet(static_cast<uint8_t>(marks >> (8 * (kMarkOctets - 1 - i)) & 0xff));
}

constexpr void write_attributes(Writer& out, const AttributeSet& set) {
  out.header(kSequence, attributes_size(set));
  if (marks_of(set) != 0) write_marks(out, marks_of(set));
  for (size_t i = 0; i < kAttributes; ++i) {
    const Attribute a = attribute_at(i);
    if (set.has(a)) out.integer(static_cast<uint8_t>(kContext | info(a).tag), set[a]);
  }
}

constexpr void write_user(Writer& out, const UserAttribute& user) {
  out.header(kSequence, user_size(user));
  out.header(kUtf8String, user.name_size);
  for (size_t i = 0; i < user.name_size; ++i) out.octet(static_cast<uint8_t>(user.name[i]));
  out.integer(kInteger, user.value);
  if (!user.dynamic) return;
  out.header(kBoolean, 1);
  out.octet(kTrue);
}

constexpr void write_channel(Writer& out, const Channel& channel) {
  out.header(kSequence, channel_size(channel));
  out.integer(kInteger, kVersion);
  out.integer(kEnumerated, static_cast<Value>(channel.role));
  out.header(kOctetString, kSubjectSize);
  out.big_endian(channel.subject, kSubjectSize);
  write_attributes(out, channel.attributes);
  if (channel.users == 0) return;
  out.header(kSequence, users_size(channel));
  for (size_t i = 0; i < channel.users; ++i) write_user(out, channel.user[i]);
}

constexpr Error encodable_user(const Channel& channel, size_t i) {
  const UserAttribute& user = channel.user[i];
  if (!is_name(user.name, user.name_size)) return Error::name;
  if (user.dynamic && channel.role != Role::network) return Error::marks;
  if (i == 0) return Error::none;
  const UserAttribute& before = channel.user[i - 1];
  return name_less(before.name, before.name_size, user.name, user.name_size) ? Error::none
                                                                             : Error::order;
}

}  // namespace detail

/// Why a channel has no encoding; Error::none if it has one.
constexpr Error encodable(const Channel& channel) {
  if (static_cast<uint8_t>(channel.role) >= kRoles) return Error::role;
  if (channel.role != Role::network) {
    if (channel.subject == 0) return Error::subject;
    if (detail::marks_of(channel.attributes) != 0) return Error::marks;
  }
  if (channel.users > kMaxUserAttributes) return Error::user_attributes;
  for (size_t i = 0; i < channel.users; ++i) {
    const Error error = detail::encodable_user(channel, i);
    if (error != Error::none) return error;
  }
  return Error::none;
}

/// The number of octets of the encoding, at most kMaxSize. The channel must be encodable().
constexpr size_t encoded_size(const Channel& channel) {
  return detail::element_size(detail::channel_size(channel));
}

/// Writes the encoding and returns its size. Returns 0, and writes nothing, if the channel is not
/// encodable() or `capacity` is less than encoded_size().
constexpr size_t encode(const Channel& channel, uint8_t* buffer, size_t capacity) {
  if (encodable(channel) != Error::none || encoded_size(channel) > capacity) return 0;
  detail::Writer out(buffer);
  detail::write_channel(out, channel);
  return out.written();
}

/// An encoding that was made at compile time.
template <size_t N>
struct Blob {
  uint8_t octets[N] = {};

  static constexpr size_t size() { return N; }
  constexpr const uint8_t* data() const { return octets; }
};

/// The channel of a specification. Attributes is an AttributeList or any type with a set(). For
/// user-defined attributes write a type like this one whose channel() names them.
template <Role R, Subject S, class Attributes>
struct Spec {
  static constexpr Channel channel() { return Channel(R, S, values_of<Attributes>()); }
};
template <Subject S, class Attributes>
using PublisherSpec = Spec<Role::publisher, S, Attributes>;
template <Subject S, class Attributes>
using SubscriberSpec = Spec<Role::subscriber, S, Attributes>;
/// What a network provides, for every subject.
template <class Attributes>
using NetworkSpec = Spec<Role::network, 0, Attributes>;

/// Encodes a specification, a type with a static constexpr channel(), at compile time:
/// `constexpr auto kBlob = der::encode(der::SubscriberSpec<0x17, Attributes>{});`
template <class ChannelSpec>
constexpr Blob<encoded_size(ChannelSpec::channel())> encode(ChannelSpec) {
  static_assert(encodable(ChannelSpec::channel()) == Error::none,
                "no encoding: subject 0, a dynamic mark in a requirement, or a user attribute "
                "with a malformed name, out of order or given twice");
  Blob<encoded_size(ChannelSpec::channel())> blob;
  detail::Writer out(blob.octets);
  detail::write_channel(out, ChannelSpec::channel());
  return blob;
}

}  // namespace der
}  // namespace mlcca
