// SPDX-License-Identifier: BSD-2-Clause
#include "control/wire.hpp"

#include <utility>

#include "control/protobuf.hpp"

namespace mlcca::control {
namespace {

template <class M>
Result<M> read_known(std::string_view bytes, const char* unknown) {
  auto parsed = parse<M>(bytes, UnknownField::skip);
  if (!parsed) return fail("malformed message: not what mlcca/v1/control.proto describes");
  if (!parsed->has_body) return fail(unknown);
  return std::move(parsed->message);
}

}  // namespace

void write(const Request& from, std::string& bytes) { ProtobufWriter(bytes).fields(from); }
void write(const Reply& from, std::string& bytes) { ProtobufWriter(bytes).fields(from); }
void write_without_id(const Reply& from, std::string& bytes) {
  ProtobufWriter(bytes).fields(from, Reply::kIdNumber);
}

Result<Request> read_request(std::string_view bytes) {
  return read_known<Request>(bytes,
                             "unknown request: this mlccad does not know it; is the client newer?");
}

Result<Reply> read_reply(std::string_view bytes) {
  return read_known<Reply>(bytes, "unknown reply: this program does not know it; is mlccad newer?");
}

}  // namespace mlcca::control
