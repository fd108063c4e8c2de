// SPDX-License-Identifier: BSD-2-Clause
// Framing: one pass over the bytes of a message, each way.
#include "control/codec.hpp"

#include <google/protobuf/stubs/logging.h>

#include <cstdint>
#include <string_view>
#include <utility>

#include "control/wire.hpp"

namespace mlcca::control {
namespace {

/// A length of 16 MiB needs four bytes; a fifth can only be wrong.
constexpr std::size_t kMaxPrefix = 4;

struct Prefix {
  std::size_t bytes = 0;   ///< of the prefix itself, 0: incomplete
  std::size_t length = 0;  ///< of the message behind it
};

Result<Prefix> read_prefix(std::string_view from) {
  Prefix prefix;
  for (std::size_t i = 0; i < kMaxPrefix; ++i) {
    if (i == from.size()) return Prefix{};
    const auto byte = static_cast<unsigned char>(from[i]);
    prefix.length |= static_cast<std::size_t>(byte & 0x7fU) << (7 * i);
    if ((byte & 0x80U) == 0) {
      prefix.bytes = i + 1;
      return prefix;
    }
  }
  return fail("malformed or too large message: a length of more than 4 bytes");
}

/// Protobuf would write about malformed input to standard error, as often as a peer sends it.
void silence_protobuf() {
  static const bool silent = [] {
    google::protobuf::SetLogHandler(nullptr);
    return true;
  }();
  static_cast<void>(silent);
}

void take_flag(const v1::Request& from, Request& to) { to.slices = from.slices(); }
void take_flag(const v1::Reply& from, Reply& to) { to.more = from.more(); }

template <class Plain, class Wire>
Result<std::optional<Plain>> decode(Buffer& buffer, std::size_t limit) {
  const auto prefix = read_prefix(buffer.content());
  if (!prefix) return std::unexpected(prefix.error());
  if (prefix->length > limit)
    return fail("message too large: " + std::to_string(prefix->length) + " bytes, at most " +
                std::to_string(limit));
  if (prefix->bytes == 0 || buffer.content().size() - prefix->bytes < prefix->length)
    return std::nullopt;
  silence_protobuf();
  Wire wire;
  if (!wire.ParseFromArray(buffer.content().data() + prefix->bytes,
                           static_cast<int>(prefix->length)))
    return fail("malformed message: not what mlcca/v1/control.proto describes");
  buffer.consume(prefix->bytes + prefix->length);
  auto plain = from_wire(wire);
  if (!plain) return std::unexpected(std::move(plain).error());
  take_flag(wire, *plain);
  return std::move(*plain);
}

void add_varint(std::string& bytes, std::uint64_t number) {
  for (; number >= 0x80; number >>= 7U)
    bytes.push_back(static_cast<char>((number & 0x7fU) | 0x80U));
  bytes.push_back(static_cast<char>(number));
}

/// `length` is what ByteSizeLong() has just given, and cached.
template <class Wire>
std::string framed(const Wire& wire, std::size_t length) {
  std::string bytes;
  bytes.reserve(length + kMaxPrefix + 1);
  add_varint(bytes, length);
  const auto prefix = bytes.size();
  bytes.resize(prefix + length);
  wire.SerializeWithCachedSizesToArray(reinterpret_cast<std::uint8_t*>(bytes.data() + prefix));
  return bytes;
}

Error too_large(std::size_t bytes, std::size_t most) {
  return {.kind = ErrorKind::world,
          .message = "the reply would have " + std::to_string(bytes) + " bytes, at most " +
                     std::to_string(most) + " are possible; ask for less",
          .details = {}};
}

}  // namespace

std::string encode(const Request& request) {
  v1::Request wire;
  to_wire(request, wire);
  return framed(wire, wire.ByteSizeLong());
}

std::string encode(const Reply& reply) {
  v1::Reply wire;
  to_wire(reply, wire);
  const auto length = wire.ByteSizeLong();
  if (length <= kMaxReply) return framed(wire, length);
  return encode(Reply{reply.id, too_large(length, kMaxReply)});
}

std::string encode_body(const Reply& reply, std::size_t most) {
  v1::Reply wire;
  to_wire(reply, wire);
  wire.clear_id();
  const auto length = wire.ByteSizeLong();
  if (length > most) return encode_body(Reply{0, too_large(length, most)});
  std::string bytes(length, '\0');
  wire.SerializeWithCachedSizesToArray(reinterpret_cast<std::uint8_t*>(bytes.data()));
  return bytes;
}

std::string with_id(std::uint64_t id, std::string_view body) {
  constexpr char id_key = v1::Reply::kIdFieldNumber << 3;
  std::string field;
  if (id != 0) {
    field.push_back(id_key);
    add_varint(field, id);
  }
  std::string bytes;
  bytes.reserve(kMaxPrefix + 1 + field.size() + body.size());
  add_varint(bytes, field.size() + body.size());
  bytes += field;
  bytes += body;
  return bytes;
}

Result<std::optional<Request>> decode_request(Buffer& buffer) {
  return decode<Request, v1::Request>(buffer, kMaxRequest);
}

Result<std::optional<Reply>> decode_reply(Buffer& buffer) {
  return decode<Reply, v1::Reply>(buffer, kMaxReply);
}

}  // namespace mlcca::control
