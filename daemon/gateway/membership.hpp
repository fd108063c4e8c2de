// SPDX-License-Identifier: BSD-2-Clause
// This gateway as one of several that share networks: what the store says becomes a part of what is
// decided here, and what is decided here is reserved there. The protocol is core/cluster's.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/problem.hpp"
#include "base/result.hpp"
#include "core/cluster/member.hpp"
#include "daemon/cluster/codec.hpp"
#include "daemon/gateway/adopting.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/reserving.hpp"
#include "daemon/gateway/rollout.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/gateway/shared_networks.hpp"
#include "daemon/gateway/turn.hpp"
#include "daemon/net/sources/timer.hpp"
#include "daemon/outside/cluster_link.hpp"
#include "daemon/outside/gate_control.hpp"

namespace mlcca {

class Membership {
 public:
  using Number = SharedNetworks::Number;
  struct Parts {
    Scene& scene;
    GateControl& control;
    EventLog& log;
    Recorder& recorder;
    Turn& turn;
    ClusterLink& link;
    const Clock& clock;
    sd_event* loop = nullptr;  ///< of the time at which something is due; null: the caller asks
    Value lease = 0;
    std::function<void()> pulse;
    /// A user pays for rows of the history.
    std::function<void(uid_t user, std::uint64_t rows)> charge;
    /// This gateway can carry now what others could carry as well.
    std::function<bool()> able;
    /// Before anything is on disk that somebody waits for.
    std::function<void()> before_commit;
    Rollout& rollout;
    Adopting::Hands hands;  ///< its last three are filled in here
  };
  explicit Membership(Parts parts);

  // A start, and another description.

  /// A description is going to be in force. While the gates are as a former daemon has left them,
  /// what the store says is waited for.
  void begin();
  void await(std::uint64_t limit);
  /// Before everything is decided in the state that the scene has.
  void take_up();
  /// It is decided, and the gates follow it.
  void in_force() {
    decided_ = true;
    // A daemon before this one may have capped the time of all gates.
    lower_until();
  }

  // The turn.

  /// In place of settling the state.
  void act();
  /// The gates have closed by themselves, or may have: what is leased is closed here before they
  /// open again.
  void expire();
  /// What was answered is on disk, or why it is not.
  void committed(const Result<void>& done);
  /// Once a second.
  void poll();

  // The end.

  /// What is shared closes, and is given back; then may_end() holds, some seconds later at most.
  void leave();
  [[nodiscard]] bool may_end() const;

  // An operator takes the gateway out, and in again. On disk first; after an error nothing has
  // changed.

  /// As leave(), until join(): also a daemon that starts later takes no part, unless it is
  /// `until_restart`.
  [[nodiscard]] Result<void> drain(bool until_restart);
  [[nodiscard]] Result<void> join();
  [[nodiscard]] bool is_drained() const { return drained_; }
  [[nodiscard]] bool is_drained_until_restart() const { return drained_ && until_restart_; }

  // Who wants something.

  /// Why nothing can be asked for now; empty: it can.
  [[nodiscard]] std::string bar(uid_t user) const;
  /// Why what the description promises of shared networks is closed now.
  [[nodiscard]] std::string why_closed() const;
  void ask(Reserving::Job job);
  [[nodiscard]] bool waits_for(const std::string& key) const;
  [[nodiscard]] std::size_t waiting_keys(const std::string& beginning) const;
  /// Whoever waits with that key is refused. False: nobody does.
  bool refuse(const std::string& key, const std::string& why);
  void admissions_gone(const std::vector<core::AdmissionId>& gone);
  void session_closed(std::uint64_t session);
  /// Admitted for another gateway, which alone releases it.
  [[nodiscard]] bool is_adopted(core::AdmissionId id) const;
  [[nodiscard]] const core::cluster::Baseline& baseline() const { return networks_->baseline(); }
  /// What others have to know to decide about it, too: what was admitted here and has brought the
  /// publishers of it.
  void add_publishers(const core::cluster::Footprint& footprint, cluster::Asked& to) const;
  /// Called with true once everything is on disk that was granted before, or with false.
  void after_commit(std::function<void(const Result<void>&)> call) {
    waits_.push_back(std::move(call));
  }
  /// A reply to a session goes on.
  void on_ready(std::function<void(std::uint64_t session)> ready) { ready_ = std::move(ready); }
  void ready(std::uint64_t session) const {
    if (ready_) ready_(session);
  }
  void charge(uid_t user, std::uint64_t rows) const { parts_.charge(user, rows); }

  /// Of descriptions.
  [[nodiscard]] Rollout& rollout() const { return parts_.rollout; }
  /// Why no description can be rolled out now; empty: one can.
  [[nodiscard]] std::string rollout_bar() const;
  /// What keeps it from taking part as it should.
  [[nodiscard]] std::vector<std::string> problems() const;
  /// The same in short; empty: nothing.
  [[nodiscard]] std::string standing() const;
  [[nodiscard]] const core::cluster::Member& member() const { return *member_; }
  /// Null before begin().
  [[nodiscard]] const core::cluster::Member* begun_member() const { return member_.get(); }
  [[nodiscard]] const core::Permits& permits() const { return networks_->permits(); }
  [[nodiscard]] const core::cluster::Digest& digest() const { return digest_; }
  [[nodiscard]] Value lease() const { return parts_.lease; }
  [[nodiscard]] const core::cluster::StoreState& store() const { return store_; }
  /// Since when the store answers, or does not.
  [[nodiscard]] Value store_since() const { return store_since_; }
  /// Nothing of it is in the store any more.
  [[nodiscard]] bool has_left() const { return left_; }
  [[nodiscard]] Value now() const { return parts_.clock.monotonic_ns(); }

 private:
  void take(ClusterMessage message);
  void take_in(const core::cluster::Event& event);
  void take_in_description(const core::cluster::Event& event);
  bool decide(const core::cluster::Event& event);
  /// False: what is to be closed may be open.
  bool bring_in_line();
  void enforce_again();
  void drain_when_closed();
  void set_permits();
  [[nodiscard]] bool may_use_leased() const;
  [[nodiscard]] bool is_in_force() const;
  void raise_until();
  void lower_until();
  void set_until(std::uint64_t until);
  void note_failed();
  bool wish_some();
  void take_over();
  void wish(std::size_t channel);
  [[nodiscard]] cluster::Asked asked_of(std::size_t channel) const;
  [[nodiscard]] bool is_known(const cluster::Asked& asked) const;
  [[nodiscard]] bool needs(const std::string& channel, Number number) const;
  void forget_orphans();
  void propose_first();
  [[nodiscard]] store::Membership record() const;
  [[nodiscard]] core::cluster::Journalled journalled_before() const;
  [[nodiscard]] bool write_down();
  void send();
  void report();
  void plan();
  [[nodiscard]] Value leased_end() const;
  void begin_leaving();
  [[nodiscard]] std::string leaving_words() const;
  [[nodiscard]] std::string closed_words() const;
  void add_troubles(std::vector<std::string>& to) const;
  [[nodiscard]] Result<void> write_drained(bool drained);
  [[nodiscard]] core::State& state() const { return *parts_.scene.state; }

  Parts parts_;
  std::shared_ptr<const core::cluster::Keys> keys_;
  std::unique_ptr<cluster::Codec> codec_;
  std::unique_ptr<SharedNetworks> networks_;
  std::unique_ptr<core::cluster::Member> member_;
  std::unique_ptr<Adopting> adopting_;
  std::unique_ptr<Reserving> reserving_;
  Sha256::Digest digest_{};
  std::size_t self_ = 0;
  std::string system_;
  core::cluster::StoreState store_{};
  Value store_since_ = 0;
  std::uint64_t generation_ = 0;             ///< of members: their transactions are kept apart
  std::vector<bool> failed_;                 ///< by gateway, as elected
  std::vector<core::cluster::Event> early_;  ///< that came before anything was decided
  bool decided_ = false;
  bool joined_ = false;  ///< once, with this description
  bool leaving_ = false, draining_ = false, left_ = false;
  bool lost_ = false;  ///< and the gates may not have closed yet
  Value enforce_at_ = 0;
  bool drained_ = false;        ///< as an operator wants it
  bool until_restart_ = false;  ///< and no longer than that
  bool looks_for_wishes_ = true;
  Value leave_until_ = 0;
  std::optional<std::uint64_t> until_;  ///< as it was set last
  Value until_retry_ = 0;               ///< the kernel has refused: not before
  Problem until_trouble_;
  std::map<std::string, Value> wish_again_;  ///< by channel
  std::vector<std::function<void(const Result<void>&)>> waits_;
  std::function<void(std::uint64_t)> ready_;
  std::string said_;      ///< the latest line on how it stands
  Value propose_at_ = 0;  ///< the first description
  net::Timer timer_;
};

}  // namespace mlcca
