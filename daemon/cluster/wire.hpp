// SPDX-License-Identifier: BSD-2-Clause
// The conversation of mlccad with mlcca-cluster over a SOCK_SEQPACKET socket. No I/O here.
//
// A message is one octet for its kind, and its content. Integers are little-endian. A text is its
// length in two octets, and its bytes; a value is its length in four octets, and its bytes. `more`
// is 1 if the next message continues this one.
//   to mlcca-cluster  hello   version 1, cluster text, gateway text
//                     follow  count 1, prefixes text
//                     txn     id 8, patience 4 (ms), more 1, counts 1 of compares {what 1, is 1,
//                             key text, revision 8}, puts {key text, value}, deletes {key text},
//                             gets {key text}, then these
//                     credit  entries 4 that may still be sent
//   to mlccad         state   reachable 1, no space 1, cluster 8, latency 8 (ns), db 8 (bytes),
//                             endpoint text, problem text
//                     begin   revision 8
//                     batch   revision 8, more 1, count 2, entries {key text, create 8, mod 8,
//                             gone 1, value}
//                     synced  revision 8
//                     result  id 8, outcome 1, revision 8, more 1, count 2, entries, why text
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "base/octets.hpp"
#include "base/result.hpp"
#include "core/cluster/store.hpp"
#include "daemon/outside/cluster_link.hpp"

namespace mlcca::cluster::wire {

inline constexpr std::uint8_t kWireVersion = 1;
inline constexpr std::size_t kMaxMessage = std::size_t{64} << 10U;  ///< bytes
inline constexpr std::size_t kMaxKey = 1024;                        ///< bytes
inline constexpr std::size_t kMaxValue = std::size_t{60} << 10U;    ///< bytes
inline constexpr std::size_t kMaxWords = 512;     ///< bytes of an explanation or a name
inline constexpr std::size_t kMaxPrefixes = 128;  ///< of one Follow
inline constexpr std::size_t kMaxPrefix = 256;  ///< bytes; a longer one is cut, so it follows more
inline constexpr std::size_t kMaxOperations =
    128;  ///< compares, changes, and reads of a transaction
inline constexpr std::size_t kMaxTransaction = std::size_t{1} << 20U;  ///< bytes of keys and values
inline constexpr std::size_t kMaxBatch = 4096;                         ///< entries of one revision
inline constexpr std::size_t kMaxBatchBytes = std::size_t{8} << 20U;   ///< bytes of keys and values

using Message = std::string;
using Octets = std::span<const char>;

/// The first message of mlccad: the names of its cluster and gateway.
struct Hello {
  std::string cluster, gateway;
  bool operator==(const Hello&) const = default;
};
/// The prefixes of the keys that mlccad follows from now on.
struct Follow {
  std::vector<std::string> prefixes;
};
/// How many further entries mlcca-cluster may send.
struct Credit {
  std::uint32_t entries = 0;
};
using ToStore = std::variant<Hello, Follow, core::cluster::Txn, Credit>;

/// Why the transaction cannot be sent; empty if it can.
[[nodiscard]] std::string misfit_of(const core::cluster::Txn& txn);
/// An entry within the limits of a message, from one of any length that etcd accepts. What is too
/// long is replaced by a value that no reader of ours understands, so that it is not mistaken for
/// something else.
[[nodiscard]] core::cluster::Entry bounded(core::cluster::Entry entry);

[[nodiscard]] Message message_of(const Hello& hello);
[[nodiscard]] Message message_of(const Follow& follow);
[[nodiscard]] Message message_of(const Credit& credit);
/// The messages of a transaction in order. It must have no misfit.
[[nodiscard]] std::vector<Message> messages_of(const core::cluster::Txn& txn);

[[nodiscard]] Message message_of(const core::cluster::StoreState& state);
[[nodiscard]] Message message_of(const ClusterSnapshot& snapshot);
[[nodiscard]] Message message_of(const ClusterSynced& synced);
/// A message with as many entries from `next` on as fit, at most `most`; `next` is advanced.
/// `more`: the revision has further entries.
[[nodiscard]] Message message_of(const core::cluster::Batch& batch, std::size_t& next,
                                 std::size_t most, bool more);
/// The same for a snapshot, where each message is a separate batch.
[[nodiscard]] Message page_of(const core::cluster::Batch& batch, std::size_t& next,
                              std::size_t most);
[[nodiscard]] std::vector<Message> messages_of(const core::cluster::TxnResult& result);

/// Assembles what mlccad sends.
class ReaderOfGateway {
 public:
  /// nullopt: more messages are to come. The error: it is not a message of mlccad.
  [[nodiscard]] Result<std::optional<ToStore>> take(Octets message);

 private:
  std::optional<ToStore> take_txn(OctetReader& from);

  std::optional<core::cluster::Txn> begun_;
  std::size_t bytes_ = 0;  ///< bytes of begun_ so far
};

/// Assembles what mlcca-cluster sends.
class ReaderOfStore {
 public:
  /// `whole`: the complete message, if this one has completed it. `entries`: the number of entries
  /// in this message, for which credit is due.
  struct Read {
    std::optional<ClusterMessage> whole;
    std::size_t entries = 0;
  };
  /// The error: the sender is not trustworthy.
  [[nodiscard]] Result<Read> take(Octets message);

 private:
  Read take_batch(OctetReader& from);
  std::optional<ClusterMessage> take_result(OctetReader& from);

  std::optional<core::cluster::Batch> batch_;
  std::optional<core::cluster::TxnResult> result_;
  std::size_t bytes_ = 0;  ///< bytes of the batch
};

}  // namespace mlcca::cluster::wire
