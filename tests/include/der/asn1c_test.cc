// SPDX-License-Identifier: BSD-2-Clause
// Two independent implementations of the same notation: what asn1c generates from proto/mlcca.asn1
// reads what we write, and we read what it writes.
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <tuple>

#include "tests/include/der/octets.hpp"
#include "tests/include/der/random_channel.hpp"

extern "C" {
#include <EventChannel.h>
}

namespace mlcca::testing {
namespace {

struct Free {
  void operator()(EventChannel_t* channel) const {
    asn_DEF_EventChannel.free_struct(&asn_DEF_EventChannel, channel, 0);
  }
};
using Theirs = std::unique_ptr<EventChannel_t, Free>;

/// What a channel says, in a form that both sides can be brought to.
struct Plain {
  int role = 0;
  Octets subject;
  std::map<std::string, Value> attributes;
  std::map<std::string, bool> marks;
  std::vector<std::tuple<std::string, Value, bool>> users;

  friend bool operator==(const Plain&, const Plain&) = default;
};

Octets octets_of(Value v) {
  Octets octets;
  for (int shift = 56; shift >= 0; shift -= 8)
    octets.push_back(static_cast<std::uint8_t>(v >> shift & 0xff));
  return octets;
}

Plain plain(const der::Channel& channel) {
  Plain result{static_cast<int>(channel.role), octets_of(channel.subject), {}, {}, {}};
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const Attribute a = attribute_at(i);
    if (!channel.attributes.has(a)) continue;
    result.attributes[info(a).name] = channel.attributes[a];
    result.marks[info(a).name] = channel.attributes.is_dynamic(a);
  }
  for (std::size_t i = 0; i < channel.users; ++i)
    result.users.emplace_back(std::string(channel.user[i].name, channel.user[i].name_size),
                              channel.user[i].value, channel.user[i].dynamic);
  return result;
}

/// The fields of the generated struct, by the names of the table.
std::vector<std::pair<std::string, Quantity_t**>> fields(Attributes_t& a) {
  return {{"Latency", &a.latency},   {"Jitter", &a.jitter},        {"Deadline", &a.deadline},
          {"Period", &a.period},     {"Bandwidth", &a.bandwidth},  {"PacketLoss", &a.packetLoss},
          {"Omission", &a.omission}, {"MaxPayload", &a.maxPayload}};
}

Octets contents(const std::uint8_t* data, int size) { return {data, data + size}; }

Value number(const INTEGER_t& integer) {
  Value v = 0;
  for (int i = 0; i < integer.size; ++i) v = v << 8 | integer.buf[i];
  return v;
}

bool bit_of(const BIT_STRING_t& bits, std::size_t i) {
  const auto octet = static_cast<int>(i / 8);
  return octet < bits.size && (bits.buf[octet] & 0x80U >> i % 8) != 0;
}

Plain plain(EventChannel_t& channel) {
  Plain result{static_cast<int>(number(channel.role)),
               contents(channel.subject.buf, channel.subject.size),
               {},
               {},
               {}};
  std::size_t index = 0;
  for (const auto& [name, field] : fields(channel.attributes)) {
    if (*field != nullptr) {
      result.attributes[name] = number(**field);
      const Marks_t* marks = channel.attributes.dynamic;
      result.marks[name] = marks != nullptr && bit_of(*marks, index);
    }
    ++index;
  }
  if (channel.userAttributes == nullptr) return result;
  for (int i = 0; i < channel.userAttributes->list.count; ++i) {
    const UserAttribute_t& user = *channel.userAttributes->list.array[i];
    const Octets name = contents(user.name.buf, user.name.size);
    result.users.emplace_back(std::string(name.begin(), name.end()), number(user.value),
                              user.dynamic != nullptr && *user.dynamic != 0);
  }
  return result;
}

/// Null when asn1c refuses the octets, or the constraints of the notation do not hold.
Theirs decode_by_asn1c(const Octets& octets) {
  void* raw = nullptr;
  const asn_dec_rval_t status =
      ber_decode(nullptr, &asn_DEF_EventChannel, &raw, octets.data(), octets.size());
  Theirs theirs(static_cast<EventChannel_t*>(raw));
  char text[200];
  std::size_t size = sizeof text;
  if (status.code != RC_OK || status.consumed != octets.size() ||
      asn_check_constraints(&asn_DEF_EventChannel, theirs.get(), text, &size) != 0)
    return nullptr;
  return theirs;
}

template <class T>
T* make() {
  return static_cast<T*>(std::calloc(1, sizeof(T)));
}
void set(OCTET_STRING_t& string, const Octets& octets) {
  OCTET_STRING_fromBuf(&string, reinterpret_cast<const char*>(octets.data()),
                       static_cast<int>(octets.size()));
}
/// With a leading zero, always: asn1c finds the shortest form by itself.
void set(INTEGER_t& integer, Value v) {
  set(reinterpret_cast<OCTET_STRING_t&>(integer), join({{0}, octets_of(v)}));
}

/// The marks as the generated code wants them: without trailing zeros.
Marks_t* marks_of(const Plain& channel, Attributes_t& attributes) {
  std::uint8_t bits = 0;
  unsigned bit = 0x80;
  for (const auto& [name, field] : fields(attributes)) {
    const auto mark = channel.marks.find(name);
    if (mark != channel.marks.end() && mark->second) bits = static_cast<std::uint8_t>(bits | bit);
    bit >>= 1;
  }
  if (bits == 0) return nullptr;
  auto* marks = make<Marks_t>();
  set(reinterpret_cast<OCTET_STRING_t&>(*marks), {bits});
  marks->bits_unused = __builtin_ctz(bits);
  return marks;
}

Theirs build(const Plain& channel) {
  Theirs theirs(make<EventChannel_t>());
  theirs->version = EventChannel__version_v1;
  set(theirs->role, static_cast<Value>(channel.role));
  set(theirs->subject, channel.subject);
  for (const auto& [name, field] : fields(theirs->attributes)) {
    const auto value = channel.attributes.find(name);
    if (value == channel.attributes.end()) continue;
    *field = make<Quantity_t>();
    set(**field, value->second);
  }
  theirs->attributes.dynamic = marks_of(channel, theirs->attributes);
  if (channel.users.empty()) return theirs;
  theirs->userAttributes = make<EventChannel::EventChannel__userAttributes>();
  for (const auto& [name, value, dynamic] : channel.users) {
    auto* user = make<UserAttribute_t>();
    set(user->name, text(name));
    set(user->value, value);
    if (dynamic) {
      user->dynamic = make<BOOLEAN_t>();
      *user->dynamic = 1;
    }
    asn_sequence_add(&theirs->userAttributes->list, user);
  }
  return theirs;
}

Octets encode_by_asn1c(EventChannel_t& channel) {
  Octets octets(der::kMaxSize);
  const asn_enc_rval_t status =
      der_encode_to_buffer(&asn_DEF_EventChannel, &channel, octets.data(), octets.size());
  octets.resize(status.encoded < 0 ? 0 : static_cast<std::size_t>(status.encoded));
  return octets;
}

TEST(Asn1cTest, ReadsWhatWeWrite) {
  RandomWorld world(11);
  for (int round = 0; round < 5000; ++round) {
    const RandomChannel ours(world);
    const Theirs theirs = decode_by_asn1c(ours.encoded());
    ASSERT_NE(theirs, nullptr);
    ASSERT_TRUE(plain(*theirs) == plain(ours.get()));
  }
}

TEST(Asn1cTest, WritesWhatWeWriteAndRead) {
  RandomWorld world(12);
  for (int round = 0; round < 5000; ++round) {
    const RandomChannel ours(world);
    const Theirs theirs = build(plain(ours.get()));
    ASSERT_EQ(encode_by_asn1c(*theirs), ours.encoded());
  }
}

TEST(Asn1cTest, UnderstandsWhateverWeUnderstand) {
  RandomWorld world(13);
  int understood = 0;
  for (int round = 0; round < 20000; ++round) {
    const RandomChannel ours(world);
    Octets octets = ours.encoded();
    octets[world.below(octets.size())] = static_cast<std::uint8_t>(world.below(256));
    der::Decoded decoded;
    if (!der::decode(octets.data(), octets.size(), &decoded).ok()) continue;
    ++understood;
    const Theirs theirs = decode_by_asn1c(octets);
    ASSERT_NE(theirs, nullptr);
    std::vector<der::UserAttribute> users;
    for (const der::UserAttribute& user : decoded.user) users.push_back(user);
    ASSERT_TRUE(plain(*theirs) == plain({decoded.role, decoded.subject, decoded.attributes,
                                         users.data(), users.size()}));
  }
  EXPECT_GT(understood, 1000);
}

TEST(Asn1cTest, DoesNotSkipWhatItDoesNotKnow) {
  EXPECT_NE(decode_by_asn1c(encoding(kSubscriberHead, {0x88, 1, 1})), nullptr);
  EXPECT_EQ(decode_by_asn1c(encoding(kSubscriberHead, {0x88, 1, 1, 0x89, 1, 1})), nullptr);
}

}  // namespace
}  // namespace mlcca::testing
