// SPDX-License-Identifier: BSD-2-Clause
// What the protocol of a cluster requires of a store: keys with revisions, and transactions that
// happen one after the other. etcd is such a store.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace mlcca::core::cluster {

/// A condition on one key. A key that does not exist has revision 0.
struct Compare {
  enum class What : std::uint8_t {
    mod,     ///< the revision of its last change
    create,  ///< the revision at which it was created
  };
  enum class Is : std::uint8_t { equal, less };
  What what = What::mod;
  Is is = Is::equal;
  std::string key;
  std::int64_t revision = 0;
};

/// A value to be written under a key.
struct Put {
  std::string key, value;
};

/// Either all compares hold, and all puts and deletes are done at one revision; or nothing is done,
/// and the keys of `else_get` are read at one revision.
struct Txn {
  std::uint64_t id = 0;
  std::vector<Compare> compares;
  std::vector<Put> puts;
  std::vector<std::string> deletes;
  std::vector<std::string> else_get;
  std::uint64_t patience_ns = 0;  ///< after that time without an answer its outcome is unsure
};

/// The value and revisions of a key, or that it is gone.
struct Entry {
  std::string key, value;
  std::int64_t create = 0, mod = 0;
  bool gone = false;
};

/// Only `committed` means that a transaction was done. Only `unsure` leaves it open: it may have
/// been done, or may be done later.
enum class Outcome : std::uint8_t {
  committed,
  conflict,  ///< a compare did not hold
  unsure,
  unavailable,
  full,
  forbidden,
  stale_auth,
  invalid,
};

/// The answer to a Txn.
struct TxnResult {
  std::uint64_t id = 0;
  Outcome outcome = Outcome::unsure;
  std::int64_t revision = 0;     ///< of the store at the answer; if committed, of the transaction
  std::vector<Entry> read = {};  ///< after a conflict: the keys of else_get; one that does not
                                 ///< exist is `gone`
  std::string why;
};

/// The changes of one revision, or a part of a snapshot. If a revision comes in several batches, it
/// counts when the last one has arrived.
struct Batch {
  std::int64_t revision = 0;
  std::vector<Entry> entries;
  bool last = true;  ///< of this revision
};

/// The state of the connection to the store.
struct StoreState {
  bool reachable = false;
  std::uint64_t cluster_id = 0;
  std::uint64_t latency_ns = 0, db_bytes = 0;
  bool no_space = false;
  std::string endpoint, problem;
};

}  // namespace mlcca::core::cluster
