// SPDX-License-Identifier: BSD-2-Clause
// The part of etcd's protocol (v3 API) that is used here: it encodes requests and decodes answers,
// without I/O. A function that decodes returns nullopt for an answer that is malformed or has more
// than kMostEntries entries.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/cluster/store.hpp"

namespace mlcca::cluster::etcd {

inline constexpr std::size_t kMostEntries = std::size_t{128} << 10U;  ///< of one answer

inline constexpr std::string_view kRange = "/etcdserverpb.KV/Range";
inline constexpr std::string_view kTxn = "/etcdserverpb.KV/Txn";
inline constexpr std::string_view kWatch = "/etcdserverpb.Watch/Watch";
inline constexpr std::string_view kStatus = "/etcdserverpb.Maintenance/Status";

/// The part of a response header that is used: the identity of the cluster and the store's
/// revision.
struct Header {
  std::uint64_t cluster_id = 0;
  std::int64_t revision = 0;
};

/// The first key behind all keys that begin with `prefix`, which is how etcd expresses a prefix.
[[nodiscard]] std::string end_of(std::string_view prefix);

/// Requests the entries with keys from `key` to before `end` as of `revision` (0: now), `limit` at
/// most.
[[nodiscard]] std::string range_request(std::string_view key, std::string_view end,
                                        std::uint64_t limit, std::int64_t revision);
/// One page of a range; `more` says that further entries follow.
struct Page {
  Header header;
  std::vector<core::cluster::Entry> entries;
  bool more = false;
};
[[nodiscard]] std::optional<Page> read_page(std::string_view answer);

/// Encodes a transaction: if its comparisons hold its writes are made, otherwise its keys are read.
[[nodiscard]] std::string txn_request(const core::cluster::Txn& txn);
/// The answer to a transaction; `succeeded` says whether its comparisons held.
struct TxnAnswer {
  Header header;
  bool succeeded = false;
  std::vector<core::cluster::Entry> read;  ///< one for each key that was read, in the order of the
                                           ///< keys; `gone`: there is no such entry
};
/// Decodes the answer to a transaction; `gets` are the keys that it reads if a comparison fails.
[[nodiscard]] std::optional<TxnAnswer> read_txn(std::string_view answer,
                                                const std::vector<std::string>& gets);

/// Requests all changes of that range from `revision` on.
[[nodiscard]] std::string watch_request(std::string_view key, std::string_view end,
                                        std::int64_t revision);
/// An answer of a watch.
struct Changes {
  Header header;
  bool created = false;
  bool canceled = false;
  std::int64_t compacted = 0;  ///< of a canceled watch: revisions before this one are no longer
                               ///< available; 0: for another reason
  std::string reason;
  std::vector<core::cluster::Entry> entries;  ///< in the order of their revisions
};
[[nodiscard]] std::optional<Changes> read_changes(std::string_view answer);

/// What a member states about itself.
struct Status {
  Header header;
  std::uint64_t db_bytes = 0;
  std::uint64_t leader = 0;  ///< 0: this member knows no leader
  bool no_space = false;
};
[[nodiscard]] std::optional<Status> read_status(std::string_view answer);

}  // namespace mlcca::cluster::etcd
