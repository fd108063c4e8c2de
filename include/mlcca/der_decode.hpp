// SPDX-License-Identifier: BSD-2-Clause
// Reads the run-time representation (proto/mlcca.asn1) in place: without heap and copies, never
// past the end, and it accepts only the one encoding that DER allows. C++14, freestanding.
#pragma once
#include "mlcca/der_format.hpp"

namespace mlcca {
namespace der {
namespace detail {

constexpr Value big_endian(const uint8_t* octets, uint8_t size) {
  Value v = 0;
  for (uint8_t i = 0; i < size; ++i) v = v << 8 | octets[i];
  return v;
}

/// Reads one element after the other; the first error stops it. Lengths above 127 are accepted only
/// if `LongForm` is true.
template <bool LongForm>
class Reader {
 public:
  constexpr Reader(const uint8_t* begin, const uint8_t* end) : at_(begin), limit_(end) {}

  constexpr Error error() const { return error_; }
  constexpr const uint8_t* at() const { return at_; }
  constexpr const uint8_t* limit() const { return limit_; }
  constexpr bool at_limit() const { return at_ == limit_; }
  constexpr uint8_t octet(uint8_t i = 0) const { return at_[i]; }
  constexpr void skip_to(const uint8_t* at) { at_ = at; }
  /// Sets the end of what may be read next.
  constexpr void set_limit(const uint8_t* limit) { limit_ = limit; }

  /// Records an error. Returns false always, so that callers can return the result.
  constexpr bool refuse(Error error) {
    error_ = error;
    return false;
  }

  /// Reads the header of an element with that tag. Its contents follow, up to end().
  constexpr bool open(uint8_t tag) {
    const uint8_t* at = at_;
    if (at == limit_) return refuse(Error::truncated);
    if (*at++ != tag) return refuse(Error::tag);
    if (at == limit_) return refuse(Error::truncated);
    Length length = *at++;
    if (length >= 0x80) {
      // Two octets of length suffice for kMaxSize.
      const auto more = static_cast<uint8_t>(length - 0x80);
      if (!LongForm || more == 0 || more > 2) return refuse(Error::length);
      if (limit_ - at < more) return refuse(Error::truncated);
      length = *at++;
      if (more == 2) length = static_cast<Length>(length << 8 | *at++);
      if (length < (more == 2 ? 0x100 : 0x80)) return refuse(Error::length);
    }
    if (static_cast<size_t>(limit_ - at) < length) return refuse(Error::truncated);
    at_ = at;
    end_ = at + length;
    return true;
  }
  constexpr const uint8_t* end() const { return end_; }

  /// Reads the header of an element whose contents have a fixed length of at most 127.
  constexpr bool open_fixed(uint8_t tag, uint8_t length) {
    const uint8_t* start = at_;
    if (!open(tag)) return false;
    if (end_ - at_ == length) return true;
    at_ = start;
    return refuse(Error::length);
  }

  /// Reads the header of an INTEGER with that tag, up to the first octet of its magnitude, which
  /// has magnitude_size() octets.
  constexpr bool open_magnitude(uint8_t tag) {
    if (!open(tag)) return false;
    const uint8_t* at = at_;
    if (at == end_ || *at >= 0x80) return refuse(Error::integer);
    if (*at == 0) {
      ++at;
      // The zero is the number itself, or it prevents the next octet from being read as a sign.
      if (at == end_) return true;
      if (*at < 0x80) return refuse(Error::integer);
      at_ = at;
    }
    return end_ - at <= kMaxMagnitude || refuse(Error::integer);
  }
  constexpr uint8_t magnitude_size() const { return static_cast<uint8_t>(end_ - at_); }

  /// Reads a BIT STRING, whose last bit must be set.
  constexpr bool read_marks(AttributeBits* marks) {
    if (!open_marks()) return false;
    const uint8_t unused = *at_++;
    uint8_t last = *at_++;
    uint8_t shift = 8 * (kMarkOctets - 1);
    *marks = static_cast<AttributeBits>(last << shift);
    while (shift != 0 && at_ != end_) {
      last = *at_++;
      shift = static_cast<uint8_t>(shift - 8);
      *marks = static_cast<AttributeBits>(*marks | last << shift);
    }
    return (unused < 8 && static_cast<uint8_t>(last << (7 - unused)) == 0x80) ||
           refuse(Error::marks);
  }

 private:
  constexpr bool open_marks() {
    if (kMarkOctets == 1) return open_fixed(kMarks, 2);
    const uint8_t* start = at_;
    if (!open(kMarks)) return false;
    const auto length = static_cast<size_t>(end_ - at_);
    if (length >= 2 && length <= 1 + kMarkOctets) return true;
    at_ = start;
    return refuse(Error::length);
  }

  // The encodings that nodes read have less than 128 octets, so an 8-bit length is enough there.
  template <bool Long, class = void>
  struct LengthOf {
    using Type = uint8_t;
  };
  template <class Unused>
  struct LengthOf<true, Unused> {
    using Type = uint16_t;
  };
  using Length = typename LengthOf<LongForm>::Type;

  const uint8_t* at_;
  const uint8_t* limit_;
  const uint8_t* end_ = nullptr;
  Error error_ = Error::none;
};

/// Reads the attributes up to the limit. They must be in the order of the table, each at most once.
template <class Sink>
constexpr bool read_attributes(Reader<Sink::kTakesUsers>& in, Sink& sink) {
  AttributeBits marks = 0;
  AttributeBits present = 0;
  uint8_t next = 0;
  while (!in.at_limit()) {
    const uint8_t tag = in.octet();
    const auto number = static_cast<uint8_t>(tag - kContext);
    if (number > kAttributes) return in.refuse(Error::tag);
    if (number < next) return in.refuse(Error::order);
    next = static_cast<uint8_t>(number + 1);
    if (number == 0) {
      if (!sink.takes_marks()) return in.refuse(Error::marks);
      if (!in.read_marks(&marks)) return false;
      continue;
    }
    if (!in.open_magnitude(tag)) return false;
    const Attribute a = attribute_at(static_cast<size_t>(number - 1));
    if (sink.takes_marks()) present = static_cast<AttributeBits>(present | mark_of(a));
    const bool dynamic = sink.takes_marks() && (marks & mark_of(a)) != 0;
    if (!sink.attribute(a, in.at(), in.magnitude_size(), dynamic)) return in.refuse(Error::range);
    in.skip_to(in.end());
  }
  sink.end_of_attributes();
  return (marks & ~present) == 0 || in.refuse(Error::marks);
}

/// Reads version, role and subject, which always have kHead octets. An error is reported at the
/// beginning of the head, to keep the code small.
template <class Sink>
constexpr bool read_head(Reader<Sink::kTakesUsers>& in, Sink& sink) {
  const uint8_t* head = in.at();
  if (in.limit() - head < static_cast<int>(kHead)) return in.refuse(Error::truncated);
  if (head[0] != kInteger || head[3] != kEnumerated || head[6] != kOctetString)
    return in.refuse(Error::tag);
  if (head[1] != 1 || head[4] != 1 || head[7] != kSubjectSize) return in.refuse(Error::length);
  if (head[2] != kVersion) return in.refuse(Error::version);
  if (head[5] >= kRoles || !sink.role(static_cast<Role>(head[5]))) return in.refuse(Error::role);
  if (!sink.subject(head + 8)) return in.refuse(Error::subject);
  in.skip_to(head + kHead);
  return true;
}

template <class Sink>
constexpr bool read_channel(Reader<Sink::kTakesUsers>& in, Sink& sink) {
  if (!in.open(kSequence)) return false;
  const uint8_t* limit = in.limit();
  if (in.end() != limit) {
    in.skip_to(in.end());
    return in.refuse(Error::trailing);
  }
  if (!read_head(in, sink) || !in.open(kSequence)) return false;
  if (!Sink::kTakesUsers && in.end() != limit) {
    in.skip_to(in.end());
    return in.refuse(Error::user_attributes);
  }
  in.set_limit(in.end());
  if (!read_attributes(in, sink)) return false;
  in.set_limit(limit);
  return in.at_limit() || sink.users(in);
}

/// Reads an encoding into a sink, which is an object with:
///  - kMax: the most octets that it accepts; kTakesUsers: whether there can be user-defined
///    attributes, and so lengths above 127;
///  - bool role(Role), bool subject(const uint8_t*), bool takes_marks();
///  - bool attribute(Attribute, const uint8_t* magnitude, uint8_t size, bool dynamic);
///  - void end_of_attributes();
///  - bool users(Reader&): reads all that follows the attributes, if kTakesUsers.
template <class Sink>
constexpr Status read(const uint8_t* data, size_t size, Sink& sink) {
  Status status;
  if (size > Sink::kMax) {
    status.error = Error::too_long;
    status.offset = Sink::kMax;
    return status;
  }
  Reader<Sink::kTakesUsers> in(data, data + size);
  if (!read_channel(in, sink)) status.offset = static_cast<uint16_t>(in.at() - data);
  status.error = in.error();
  return status;
}

/// A user-defined attribute that is read in place.
struct UserView {
  const uint8_t* name = nullptr;
  size_t name_size = 0;
  Value value = 0;
  bool dynamic = false;
};

constexpr bool read_user_mark(Reader<true>& in, UserView* out) {
  if (!in.open_fixed(kBoolean, 1)) return false;
  // FALSE is the default, which DER does not encode.
  if (in.octet() != kTrue) return in.refuse(Error::marks);
  in.skip_to(in.end());
  out->dynamic = true;
  return in.at_limit() || in.refuse(Error::tag);
}

/// Reads one user-defined attribute; the limit of the reader is the same afterwards.
constexpr bool read_user(Reader<true>& in, UserView* out) {
  const uint8_t* limit = in.limit();
  if (!in.open(kSequence)) return false;
  in.set_limit(in.end());
  if (!in.open(kUtf8String)) return false;
  out->name = in.at();
  out->name_size = static_cast<size_t>(in.end() - in.at());
  if (!is_name(out->name, out->name_size)) return in.refuse(Error::name);
  in.skip_to(in.end());
  if (!in.open_magnitude(kInteger)) return false;
  out->value = big_endian(in.at(), in.magnitude_size());
  in.skip_to(in.end());
  out->dynamic = false;
  if (!in.at_limit() && !read_user_mark(in, out)) return false;
  in.set_limit(limit);
  return true;
}

/// Reads all user-defined attributes up to the limit: 1 to kMaxUserAttributes, sorted by name and
/// without duplicates.
constexpr bool read_users(Reader<true>& in, bool takes_marks) {
  UserView before;
  size_t count = 0;
  do {
    if (in.at_limit() || ++count > kMaxUserAttributes) return in.refuse(Error::user_attributes);
    const uint8_t* start = in.at();
    UserView user;
    if (!read_user(in, &user)) return false;
    Error error = Error::none;
    if (user.dynamic && !takes_marks) error = Error::marks;
    if (!name_less(before.name, before.name_size, user.name, user.name_size)) error = Error::order;
    if (error != Error::none) {
      in.skip_to(start);
      return in.refuse(error);
    }
    before = user;
  } while (!in.at_limit());
  return true;
}

}  // namespace detail

/// The user-defined attributes of an encoding that decode() has accepted. They are read in place
/// one after the other, so this is valid as long as the octets are.
class UserAttributes {
 public:
  class Iterator {
   public:
    constexpr Iterator(const uint8_t* at, const uint8_t* end) : at_(at), end_(end) { read(); }

    UserAttribute operator*() const {
      return {reinterpret_cast<const char*>(user_.name), user_.name_size, user_.value,
              user_.dynamic};
    }
    constexpr Iterator& operator++() {
      at_ = next_;
      read();
      return *this;
    }
    friend constexpr bool operator==(const Iterator& a, const Iterator& b) {
      return a.at_ == b.at_;
    }
    friend constexpr bool operator!=(const Iterator& a, const Iterator& b) { return !(a == b); }

   private:
    constexpr void read() {
      if (at_ == end_) return;
      detail::Reader<true> in(at_, end_);
      detail::read_user(in, &user_);
      next_ = in.at();
    }

    const uint8_t* at_;
    const uint8_t* end_;
    const uint8_t* next_ = nullptr;
    detail::UserView user_;
  };

  constexpr UserAttributes() = default;
  /// Takes the contents of a sequence that has been checked.
  constexpr UserAttributes(const uint8_t* begin, const uint8_t* end) : begin_(begin), end_(end) {}

  constexpr bool empty() const { return begin_ == end_; }
  constexpr Iterator begin() const { return {begin_, end_}; }
  constexpr Iterator end() const { return {end_, end_}; }

 private:
  const uint8_t* begin_ = nullptr;
  const uint8_t* end_ = nullptr;
};

/// A decoded channel.
struct Decoded {
  Role role = Role::subscriber;
  Subject subject = 0;
  AttributeSet attributes;
  UserAttributes user;  ///< points into the encoding
};

namespace detail {

class WideSink {
 public:
  static constexpr size_t kMax = kMaxSize;
  static constexpr bool kTakesUsers = true;

  constexpr bool role(Role role) {
    out_.role = role;
    return true;
  }
  constexpr bool subject(const uint8_t* octets) {
    out_.subject = big_endian(octets, kSubjectSize);
    return out_.subject != 0 || takes_marks();
  }
  constexpr bool takes_marks() const { return out_.role == Role::network; }
  constexpr bool attribute(Attribute a, const uint8_t* magnitude, uint8_t size, bool dynamic) {
    out_.attributes.set(a, big_endian(magnitude, size), dynamic);
    return true;
  }
  constexpr void end_of_attributes() {}
  constexpr bool users(Reader<true>& in) {
    if (!in.open(kSequence)) return false;
    const uint8_t* begin = in.at();
    const uint8_t* end = in.end();
    const bool nothing_follows = end == in.limit();
    in.set_limit(end);
    if (!read_users(in, takes_marks())) return false;
    out_.user = UserAttributes(begin, end);
    return nothing_follows || in.refuse(Error::tag);
  }
  constexpr const Decoded& result() const { return out_; }

 private:
  Decoded out_;
};

}  // namespace detail

/// Decodes an encoding of `size` octets. If there is an error, *out is unchanged.
__attribute__((warn_unused_result)) constexpr Status decode(const uint8_t* data, size_t size,
                                                            Decoded* out) {
  detail::WideSink sink;
  const Status status = detail::read(data, size, sink);
  if (status.ok()) *out = sink.result();
  return status;
}

}  // namespace der
}  // namespace mlcca
