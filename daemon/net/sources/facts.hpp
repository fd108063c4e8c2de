// SPDX-License-Identifier: BSD-2-Clause
// The conversation of mlccad with mlcca-sources over a SOCK_SEQPACKET socket. There is one process
// for each source that untrusted peers write. mlccad sends what to watch, and the process sends
// facts. No I/O here.
//
// A message is one octet for its kind, and its content. Integers are little-endian. A text is its
// length in two octets, and its bytes. An octet 0 or 1 precedes what may be missing.
//   to mlcca-sources  nodes   count 2, {name, address}     as many messages as it takes, then
//                     watch   source kind 1, metric 1, interface, endpoint
//   to mlccad         links   count 2, {from, to, rate 8, kind 1, loss?8, channel?4, busy?4,
//                             weight?8, taken 8, valid?8}
//                     hops    count 2, {from, to, via}
//                     end     problem                       what was sent since the last one is all
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/sample.hpp"

namespace mlcca::net::facts {

inline constexpr std::size_t kMaxMessage = std::size_t{32} << 10U;  ///< bytes

using Message = std::string;
using Octets = std::span<const char>;

/// The messages that say what to watch, in order.
[[nodiscard]] std::vector<Message> question(const core::mesh::Source& source,
                                            const core::mesh::Mesh& mesh);
/// The messages of one snapshot, in order.
[[nodiscard]] std::vector<Message> answer(const core::mesh::Snapshot& snapshot);

/// What a process of mlcca-sources is to watch.
struct Question {
  core::mesh::Source source;
  core::mesh::Mesh mesh;  ///< only its nodes
};

/// Assembles a question from its messages.
class QuestionReader {
 public:
  /// nullopt: more messages are to come. The error: it is not a message of mlccad.
  Result<std::optional<Question>> take(Octets message);

 private:
  Question question_;
};

/// Assembles snapshots from messages, within the limits of bounds.hpp.
class AnswerReader {
 public:
  /// nullopt: more messages are to come. The error: the sender is not trustworthy.
  Result<std::optional<core::mesh::Snapshot>> take(Octets message);

 private:
  core::mesh::Snapshot snapshot_;
};

}  // namespace mlcca::net::facts
