// SPDX-License-Identifier: BSD-2-Clause
// The part of etcd's protocol (v3) that is used here: requests to octets, answers from octets. No
// I/O. An answer that is not understood, or has more entries than kMostEntries, is nothing.
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

struct Header {
  std::uint64_t cluster_id = 0;
  std::int64_t revision = 0;
};

/// The first key behind all that begin with `prefix`.
[[nodiscard]] std::string end_of(std::string_view prefix);

/// Keys from `key` up to before `end`, as they were at `revision` (0: now), `limit` at most.
[[nodiscard]] std::string range_request(std::string_view key, std::string_view end,
                                        std::uint64_t limit, std::int64_t revision);
struct Page {
  Header header;
  std::vector<core::cluster::Entry> entries;
  bool more = false;
};
[[nodiscard]] std::optional<Page> read_page(std::string_view answer);

[[nodiscard]] std::string txn_request(const core::cluster::Txn& txn);
struct TxnAnswer {
  Header header;
  bool succeeded = false;
  std::vector<core::cluster::Entry> read;  ///< one for each key that was read; gone: there is none
};
/// `gets`: the keys that are read where a comparison fails.
[[nodiscard]] std::optional<TxnAnswer> read_txn(std::string_view answer,
                                                const std::vector<std::string>& gets);

/// Changes from `revision` on.
[[nodiscard]] std::string watch_request(std::string_view key, std::string_view end,
                                        std::int64_t revision);
struct Changes {
  Header header;
  bool created = false;
  bool canceled = false;
  std::int64_t compacted = 0;  ///< where it was canceled: what is before this revision is gone
  std::string reason;
  std::vector<core::cluster::Entry> entries;  ///< in the order of their revisions
};
[[nodiscard]] std::optional<Changes> read_changes(std::string_view answer);

struct Status {
  Header header;
  std::uint64_t db_bytes = 0;
  std::uint64_t leader = 0;  ///< 0: this member knows none
  bool no_space = false;
};
[[nodiscard]] std::optional<Status> read_status(std::string_view answer);

}  // namespace mlcca::cluster::etcd
