// SPDX-License-Identifier: BSD-2-Clause
// The transactions of one gateway. Each requires that the gateway's own entry is as the one before
// left it, and writes it again. So each is a beat, they happen in one order, and a transaction
// whose answer was lost has either happened before a later one succeeds, or never will. See ADR 47.
// Times are in ns.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/cluster/keys.hpp"
#include "core/cluster/store.hpp"
#include "core/cluster/types.hpp"

namespace mlcca::core::cluster {

/// The content of one transaction beside the beat.
struct Work {
  enum class Kind : std::uint8_t {
    join,
    beat,
    reserve,
    open,
    end,
    erase,
    vote,
    fence,
    chunk,
    propose,
    judge,
    decide,
    call_off,
    leave,
    clean,  ///< deletes entries that nobody can use any more
  };
  Kind kind = Kind::beat;
  std::uint64_t id = 0;      ///< of an admission
  std::size_t gateway = 0;   ///< that it concerns
  std::uint64_t number = 0;  ///< chosen by the sender, who gets it back in Done
  std::uint64_t stage = 0;   ///< of a rollout: the number of the call of stage()
  std::vector<Compare> compares = {};
  std::vector<Put> puts = {};
  std::vector<std::string> deletes = {};
  std::vector<std::string> reads = {};
  /// A vote in it, on an admission of `gateway`.
  struct Answer {
    std::uint64_t id = 0;
    std::int64_t asked = 0;    ///< see Origin
    std::uint64_t number = 0;  ///< as `number` above, of this vote
    template <class Visit>
    void visit_state(Visit&& visit) const {
      visit(id, asked, number);
    }
  };
  std::vector<Answer> answers = {};
  Role role = Role::standby;  ///< that the beat states
};

/// The outcome of a Work.
struct Done {
  enum class Fate : std::uint8_t {
    done,
    not_done,  ///< and it never will be; no other reason is known
    conflict,  ///< one of its own compares failed
    unsure,    ///< not known yet; another Done follows
    refused,   ///< by the store
  };
  Work work;
  Fate fate = Fate::done;
  std::int64_t revision = 0;
  std::vector<Entry> read = {};
  std::string why = {};
};

/// Sends transactions one after the other, finds out what became of those without an answer, and
/// keeps the lease. It does no I/O: send() returns a transaction, on_result() takes its answer.
class Chain {
 public:
  enum class Trouble : std::uint8_t { none, fenced, new_epoch, gone_back };

  Chain(std::shared_ptr<const Keys> keys, const Codec& codec, std::size_t self,
        std::uint64_t session, Value lease);

  /// Starts with the own entry at revision `base`. `incarnation`: the one that goes on; 0: a new
  /// one begins. `former_lease`: the lease under which the gates may still be open.
  void begin(std::int64_t base, std::int64_t incarnation, std::int64_t epoch, Value former_lease);
  /// Forgets everything that was sent; nothing is valid from `now` on. The next transaction waits a
  /// little.
  void end(Value now);

  [[nodiscard]] bool joined() const { return joined_; }
  [[nodiscard]] std::int64_t base() const { return base_; }
  [[nodiscard]] std::int64_t incarnation() const { return incarnation_; }
  [[nodiscard]] std::int64_t epoch() const { return epoch_; }
  /// Until when this gateway may send what is leased.
  [[nodiscard]] Value valid_until() const { return valid_until_; }
  /// Whether a transaction is under way, or a retry is not due yet.
  [[nodiscard]] bool busy(Value now) const { return flight_.has_value() || now < retry_at_; }
  /// Whether the outcome of an earlier transaction is unknown. Then only beats may be sent.
  [[nodiscard]] bool unsure() const { return !unsure_.empty(); }
  /// Whether a work of that kind and id is under way or its outcome unknown.
  [[nodiscard]] bool has(Work::Kind kind, std::uint64_t id) const;
  /// When the next beat must be sent so that the lease goes on.
  [[nodiscard]] Value beat_due() const;
  /// When something is due: on_time() gives up waiting for an answer, or the next transaction may
  /// be sent after a failure. Nullopt: nothing is.
  [[nodiscard]] std::optional<Value> next_time(Value now) const;

  /// Completes a beat and returns the transaction to be sent. `seen`: the revision of the store
  /// that the view has reached.
  [[nodiscard]] Txn send(Work work, Beat beat, std::int64_t seen, Value now);
  /// Takes the result of a transaction. Returns what became of this one and, if it shows that, of
  /// earlier ones whose outcome was unknown.
  [[nodiscard]] std::vector<Done> on_result(const TxnResult& result, Value now);
  /// Gives up waiting for an answer that is overdue; its outcome is then unsure.
  [[nodiscard]] std::vector<Done> on_time(Value now);
  /// What a conflict has revealed about the own entry.
  [[nodiscard]] Trouble trouble() const { return trouble_; }

  /// Visits all state that affects its behaviour, for the model checker.
  template <class Visit>
  void visit_state(Visit&& visit) const {
    visit(lease_, base_, incarnation_, epoch_, seq_, joined_, trouble_, valid_until_, last_beat_,
          retry_at_, flight_, unsure_);
  }

 private:
  struct Sent {
    std::uint64_t seq = 0;
    Value at = 0;
    Value lease = 0;
    std::int64_t base = 0;
    std::int64_t seen = 0;
    Work work;
    template <class Visit>
    void visit_state(Visit&& visit) const {
      visit(seq, at, lease, base, seen, work.kind, work.id, work.gateway, work.number, work.answers,
            work.role);
    }
  };

  void commit(Sent sent, std::int64_t revision, std::vector<Done>& done);
  void conflict(Sent sent, const TxnResult& result, std::vector<Done>& done);
  void follow(std::int64_t own, const TxnResult& result, std::vector<Done>& done);
  void drop_unsure(std::vector<Done>& done);
  void make_unsure(Value now, std::vector<Done>& done);
  [[nodiscard]] Value patience() const;
  [[nodiscard]] std::optional<Sent> take(std::uint64_t seq);

  std::shared_ptr<const Keys> keys_;
  const Codec* codec_;
  std::size_t self_;
  std::uint64_t session_;
  Value own_lease_, lease_;
  std::int64_t base_ = 0, incarnation_ = 0, epoch_ = 0;
  std::uint64_t seq_ = 0;
  bool joined_ = false;
  Trouble trouble_ = Trouble::none;
  Value valid_until_ = 0, last_beat_ = 0, retry_at_ = 0;
  std::optional<Sent> flight_;
  std::vector<Sent> unsure_;
};

}  // namespace mlcca::core::cluster
