// SPDX-License-Identifier: BSD-2-Clause
// What is still to be sent to mlccad: the latest state, the results of transactions, and of entries
// as many as there is credit for.
#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>
#include <variant>

#include "daemon/cluster/wire.hpp"

namespace mlcca::cluster {

class Outbox {
 public:
  void put(core::cluster::StoreState state) { state_ = std::move(state); }
  void put(const core::cluster::TxnResult& result);
  /// What was fed and not sent yet is forgotten.
  void begin(std::int64_t revision);
  /// A revision, which is one batch there, too.
  void put(core::cluster::Batch batch);
  /// Some of a snapshot.
  void put_page(core::cluster::Batch batch);
  void synced(std::int64_t revision);
  /// Nothing that was fed is sent any more.
  void forget_feed();
  void add_credit(std::uint32_t entries);

  /// The next message that may be sent, until it is taken.
  [[nodiscard]] const wire::Message* next();
  void take() { next_.reset(); }

  /// Octets of keys and values that wait for credit.
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
