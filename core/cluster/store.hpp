// SPDX-License-Identifier: BSD-2-Clause
// What the protocol between gateways sees of a store: transactions, and what others have written.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace mlcca::core::cluster {

struct Compare {
  enum class What : std::uint8_t { mod, create } what;
  enum class Is : std::uint8_t { equal, less } is;
  std::string key;
  std::int64_t revision;
};
struct Put {
  std::string key, value;
};
struct Txn {
  std::uint64_t id;
  std::vector<Compare> compares;
  std::vector<Put> puts;
  std::vector<std::string> deletes;
  std::vector<std::string> else_get;
  std::uint64_t patience_ns;
};
struct Entry {
  std::string key, value;
  std::int64_t create = 0, mod = 0;
  bool gone = false;
};
enum class Outcome : std::uint8_t {
  committed,
  conflict,
  unsure,
  unavailable,
  full,
  forbidden,
  stale_auth,
  invalid
};
struct TxnResult {
  std::uint64_t id;
  Outcome outcome;
  std::int64_t revision = 0;
  std::vector<Entry> read;
  std::string why;
};
/// One revision, or a part of a snapshot.
struct Batch {
  std::int64_t revision;
  std::vector<Entry> entries;
};
struct StoreState {
  bool reachable;
  std::uint64_t cluster_id;
  std::uint64_t latency_ns, db_bytes;
  bool no_space;
  std::string endpoint, problem;
};

}  // namespace mlcca::core::cluster
