// SPDX-License-Identifier: BSD-2-Clause
// What is to be sent to mlccad: the latest state of the store, results of transactions, and the
// feed of entries.
#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>
#include <variant>

#include "daemon/cluster/wire.hpp"

namespace mlcca::cluster {

/// Orders the messages to mlccad. The state and the results go first. The feed is limited by the
/// credit that mlccad gives, in entries, so that a slow mlccad bounds it. A newer state replaces
/// one that was not sent.
class Outbox {
 public:
  void put(core::cluster::StoreState state) { state_ = std::move(state); }
  void put(const core::cluster::TxnResult& result);
  /// Begins a snapshot as of `revision`; what was in the feed and was not sent is discarded.
  void begin(std::int64_t revision);
  /// Adds the changes of one revision, which mlccad receives as one batch.
  void put(core::cluster::Batch batch);
  /// Adds a page of a snapshot, which may be sent in several parts.
  void put_page(core::cluster::Batch batch);
  /// Adds that the snapshot is complete as of `revision`.
  void synced(std::int64_t revision);
  /// Discards the feed that was not sent.
  void forget_feed();
  void add_credit(std::uint32_t entries);

  /// The next message that may be sent, or nullptr. It stays the same until take().
  [[nodiscard]] const wire::Message* next();
  void take() { next_.reset(); }

  /// Octets of keys and values in the feed that wait for credit.
  [[nodiscard]] std::size_t fed_bytes() const { return fed_bytes_; }
  [[nodiscard]] std::size_t fed_entries() const { return fed_entries_; }

 private:
  struct Part {
    core::cluster::Batch batch;
    bool of_snapshot = false;
    std::size_t next = 0;
  };
  using Fed = std::variant<ClusterSnapshot, Part, ClusterSynced>;

  void put_part(Part part);
  std::optional<wire::Message> make();
  std::optional<wire::Message> make_fed();

  std::optional<wire::Message> next_;
  std::optional<core::cluster::StoreState> state_;
  std::deque<wire::Message> results_;
  std::deque<Fed> feed_;
  std::size_t fed_bytes_ = 0;
  std::size_t fed_entries_ = 0;
  std::uint64_t credit_ = 0;
};

}  // namespace mlcca::cluster
