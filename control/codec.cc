// SPDX-License-Identifier: BSD-2-Clause
// Adds and removes the length of messages, in one pass over the bytes.
#include "control/codec.hpp"

#include <cstdint>
#include <protozero/buffer_string.hpp>
#include <protozero/varint.hpp>
#include <string_view>
#include <utility>

#include "control/wire.hpp"

namespace mlcca::control {
namespace {

/// The largest length, 16 MiB, takes four bytes; a fifth byte is an error.
constexpr std::size_t kMaxPrefix = 4;

struct Prefix {
  std::size_t bytes = 0;   ///< length of the prefix itself; 0: it is incomplete
  std::size_t length = 0;  ///< length of the message behind it
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

template <class Message>
Result<std::optional<Message>> decode(Buffer& buffer, Result<Message> (*read)(std::string_view)) {
  const auto prefix = read_prefix(buffer.content());
  if (!prefix) return std::unexpected(prefix.error());
  if (prefix->length > Message::kMaxBytes)
    return fail("message too large: " + std::to_string(prefix->length) + " bytes, at most " +
                std::to_string(Message::kMaxBytes));
  if (prefix->bytes == 0 || buffer.content().size() - prefix->bytes < prefix->length)
    return std::nullopt;
  auto message = read(buffer.content().substr(prefix->bytes, prefix->length));
  if (!message) return std::unexpected(std::move(message).error());
  buffer.consume(prefix->bytes + prefix->length);
  return std::move(*message);
}

/// The message that consists of `front` and `rest`, behind its length.
std::string framed(std::string_view front, std::string_view rest) {
  std::string bytes;
  bytes.reserve(kMaxPrefix + front.size() + rest.size());
  protozero::add_varint_to_buffer(&bytes, front.size() + rest.size());
  bytes += front;
  bytes += rest;
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
  std::string message;
  write(request, message);
  return framed("", message);
}

std::string encode(const Reply& reply) {
  std::string message;
  write(reply, message);
  if (message.size() <= Reply::kMaxBytes) return framed("", message);
  return encode(Reply{reply.id, too_large(message.size(), Reply::kMaxBytes)});
}

std::string encode_body(const Reply& reply, std::size_t most) {
  std::string body;
  write_without_id(reply, body);
  if (body.size() > most) return encode_body(Reply{0, too_large(body.size(), most)});
  return body;
}

std::string with_id(std::uint64_t id, std::string_view body) {
  constexpr char key = Reply::kIdNumber << 3U;
  std::string field;
  if (id != 0) {
    field.push_back(key);
    protozero::add_varint_to_buffer(&field, id);
  }
  return framed(field, body);
}

Result<std::optional<Request>> decode_request(Buffer& buffer) {
  return decode<Request>(buffer, read_request);
}

Result<std::optional<Reply>> decode_reply(Buffer& buffer) {
  return decode<Reply>(buffer, read_reply);
}

}  // namespace mlcca::control
