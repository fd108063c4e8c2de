// SPDX-License-Identifier: BSD-2-Clause
// The part that this gateway takes in a cluster, where several gateways share networks through a
// store. The protocol is in core/cluster; this file connects it with the daemon.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/loop_timer.hpp"
#include "base/result.hpp"
#include "core/admission/holders.hpp"
#include "core/cluster/footprint.hpp"
#include "core/cluster/member.hpp"
#include "daemon/cluster/record_codec.hpp"
#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/adopted_admissions.hpp"
#include "daemon/gateway/adopting.hpp"
#include "daemon/gateway/can_forwarding.hpp"
#include "daemon/gateway/cluster_lines.hpp"
#include "daemon/gateway/cluster_session.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/former_numbers.hpp"
#include "daemon/gateway/gateway_presence.hpp"
#include "daemon/gateway/open_until.hpp"
#include "daemon/gateway/quotas.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/reserving.hpp"
#include "daemon/gateway/rollout.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/gateway/shared_networks.hpp"
#include "daemon/gateway/turn.hpp"
#include "daemon/gateway/waiting_for_others.hpp"
#include "daemon/gateway/wishes.hpp"
#include "daemon/outside/cluster_link.hpp"
#include "daemon/outside/gate_control.hpp"

namespace mlcca {

/// Applies what the store says to the state that is decided here, and reserves in the store what is
/// decided here. Owns the member of the protocol (core::cluster::Member), the shared networks, and
/// what is reserved (Reserving) and adopted (Adopting). Journals before it sends, and never says
/// that something is closed before the kernel has closed it.
class Membership final : private core::Holdings, private Adopting::Hands {
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
    sd_event* loop = nullptr;  ///< for the timer; null: the caller calls act()
    Value lease = 0;
    std::function<void()> pulse;
    Quotas& quotas;             ///< charged with the rows that waiting admissions make
    GatewayPresence& presence;  ///< says what this gateway can carry now
    CanForwarding& forwarding;  ///< acts before a commit that somebody waits for
    Rollout& rollout;
    Admissions& admissions;
    AdoptedAdmissions& adopted;
  };
  explicit Membership(Parts parts);

  // Calls for a start, and for another description.

  /// begin(): a description is about to be put in force; the member of the protocol starts again.
  /// await(): waits at most `limit` ns for what the store says, while the gates are as a former
  /// daemon has left them.
  void begin();
  void await(std::uint64_t limit);
  /// Called before everything is decided in the present state of the scene.
  void take_up() { static_cast<void>(take_up_state(false)); }
  /// Called when everything is decided and the gates follow it.
  void in_force() {
    decided_ = true;
    // A former daemon may have limited the time of all gates.
    lower_until();
  }

  // Calls in each turn.

  /// Applies what the store has said, decides and enforces what follows, and sends transactions.
  /// Replaces Turn::settle() in a cluster.
  void act();
  /// The gates have closed by themselves, or may have. Before they open again, closes what holds
  /// only with the lease; if that has ended, everything on shared networks until the store has
  /// confirmed a beat.
  void expire();
  /// What was answered is on disk; an error says why it is not. Calls the functions of
  /// after_commit().
  void committed(const Result<void>& done);
  /// To be called once a second.
  void poll();

  // Calls at the end.

  /// Closes what is shared and gives it back. may_end() becomes true within 5 s.
  void leave();
  [[nodiscard]] bool may_end() const;

  // An operator takes the gateway out of the cluster, and in again. Both write to disk first. After
  // an error nothing has changed.

  /// Does what leave() does, until join(). Unless `until_restart`, a daemon that starts later takes
  /// no part either.
  [[nodiscard]] Result<void> drain(bool until_restart);
  [[nodiscard]] Result<void> join();
  [[nodiscard]] bool is_drained() const { return is_drained_; }
  [[nodiscard]] bool is_drained_until_restart() const { return is_drained_ && until_restart_; }

  // Requests of clients.

  /// Why a user can ask for nothing now; empty if they can.
  [[nodiscard]] std::string bar(uid_t user) const;
  /// Why the standing promises on shared networks are closed now.
  [[nodiscard]] std::string why_closed() const;
  void ask(Reserving::Job job);
  [[nodiscard]] bool waits_for(const std::string& key) const;
  /// Refuses the job that waits with this key. False if there is none.
  bool refuse(const std::string& key, const std::string& why);
  void admissions_gone(const std::vector<core::AdmissionId>& gone);
  void session_closed(std::uint64_t session);
  /// What is decided of that channel has changed.
  // NOLINTNEXTLINE(readability-make-member-function-const): it changes the session
  void note_changed(std::size_t channel) {
    if (session_.adopting) session_.adopting->note_changed(channel);
  }
  /// Whether the admission was made for another gateway, which alone releases it.
  [[nodiscard]] bool is_adopted(core::AdmissionId id) const {
    return session_.adopting && session_.adopting->has(id);
  }
  /// See Adopting::is_twin().
  [[nodiscard]] bool is_twin(core::AdmissionId id) const {
    return session_.adopting && id != 0 && session_.adopting->is_twin(id);
  }
  [[nodiscard]] const core::cluster::Baseline& baseline() const {
    return session_.networks->baseline();
  }
  /// See Wishes::add_subscribers().
  void add_subscribers(const core::Proposal& wish, cluster::StoredRequest& to) const {
    wishes_.add_subscribers(wish, to);
  }
  /// See Wishes::add_publishers().
  void add_publishers(const core::cluster::Footprint& footprint, cluster::StoredRequest& to) const {
    wishes_.add_publishers(footprint, to);
  }
  /// `call` gets the result of the next commit: success once everything granted before is on disk.
  void after_commit(std::function<void(const Result<void>&)> call) {
    waits_.push_back(std::move(call));
  }
  /// Sets the function that is called when the reply to a session can continue.
  void on_ready(std::function<void(std::uint64_t session)> ready) { ready_ = std::move(ready); }
  void ready(std::uint64_t session) const {
    if (ready_) ready_(session);
  }
  void charge(uid_t user, std::uint64_t rows) const { parts_.quotas.charge(user, rows, now()); }

  /// The rollout of descriptions.
  [[nodiscard]] Rollout& rollout() const { return parts_.rollout; }
  /// Why no description can be rolled out now; empty if one can.
  [[nodiscard]] std::string rollout_bar() const;
  /// What keeps this gateway from taking its full part, one line each.
  [[nodiscard]] std::vector<std::string> problems() const;
  /// The same in one short text; empty if nothing does.
  [[nodiscard]] std::string standing() const;
  [[nodiscard]] const core::cluster::Member& member() const { return *session_.member; }
  [[nodiscard]] core::cluster::Member& own_member() const { return *session_.member; }
  /// nullptr before begin().
  [[nodiscard]] const core::cluster::Member* begun_member() const { return session_.member.get(); }
  [[nodiscard]] const core::Permits& permits() const { return session_.networks->permits(); }
  [[nodiscard]] const core::cluster::Digest& digest() const { return session_.digest; }
  [[nodiscard]] Value lease() const { return parts_.lease; }
  [[nodiscard]] const core::cluster::StoreState& store() const { return store_; }
  /// Since when the store answers, or does not answer: CLOCK_MONOTONIC ns.
  [[nodiscard]] Value store_since() const { return store_since_; }
  /// Whether the store has nothing of this gateway any more.
  [[nodiscard]] bool has_left() const { return phase_ == Phase::left; }
  [[nodiscard]] Value now() const { return parts_.clock.monotonic_ns(); }

 private:
  [[nodiscard]] bool is_leaving() const { return phase_ != Phase::taking_part; }
  void take(ClusterMessage message);
  void take_in(const core::cluster::Event& event);
  void take_in_description(const core::cluster::Event& event);
  bool decide(const core::cluster::Event& event);
  // What Adopting needs; see there.
  void remove(const std::vector<core::AdmissionId>& gone) override;
  Result<void> reserve(Reserving::Job job) override;
  void forget(Number adopted) override { session_.reserving->forget(adopted); }
  [[nodiscard]] bool wants(Number number) const override { return session_.reserving->has(number); }
  void give_back(const std::vector<core::AdmissionId>& gone) override {
    session_.reserving->admissions_gone(gone);
  }
  [[nodiscard]] std::string name_of(std::size_t gateway) const override {
    return state().system().gateways[gateway].name;
  }
  [[nodiscard]] core::AdmissionId new_id() override { return parts_.recorder.new_id(); }
  [[nodiscard]] Number new_number() override { return session_.reserving->new_number(); }
  /// False if the kernel may have left open what is to be closed.
  bool bring_in_line() override;
  void enforce_again();
  void drain_when_closed();
  void set_permits();
  [[nodiscard]] bool is_unheard();
  [[nodiscard]] bool may_use_leased() const;
  [[nodiscard]] bool is_in_force() const;
  void raise_until();
  void lower_until();
  void set_until(std::uint64_t until);
  void note_failed();
  bool wish_some();
  void wish_anew();
  [[nodiscard]] core::FormerRules take_up_state(bool is_in_force);
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
  // Whom refusals name.
  [[nodiscard]] core::cluster::Foreign of_others(std::size_t network) const override;
  [[nodiscard]] std::map<std::size_t, core::MadeFor> made_for(std::size_t network) const override;
  [[nodiscard]] std::string unreadable(std::size_t network) const override;
  [[nodiscard]] std::string objection(std::size_t channel,
                                      std::span<const std::size_t> gateways) const override;
  [[nodiscard]] core::State& state() const { return *parts_.scene.state; }

  Parts parts_;
  ClusterSession session_;
  Wishes wishes_;
  WaitingForOthers waiting_;
  FormerNumbers former_;
  OpenUntil open_until_;
  ClusterLines lines_;
  core::cluster::StoreState store_{};
  Value store_since_ = 0;
  std::uint64_t generation_ = 0;  ///< counts members, so that their transactions are distinguished
  bool decided_ = false;
  enum class Phase : std::uint8_t {
    taking_part,
    closing,   ///< it is to leave, and the gates may not have closed yet
    draining,  ///< all is closed, and the store still has something of it
    left,
  };
  Phase phase_ = Phase::taking_part;
  bool is_drained_ = false;     ///< an operator has drained this gateway
  bool until_restart_ = false;  ///< the drain ends with this daemon
  Value leave_until_ = 0;
  bool lost_ = false;  ///< the lease was lost, and the gates may not have closed yet
  Value enforce_at_ = 0;
  bool wishes_invalid_ = true;
  bool waiting_asked_ = false;  ///< the latest turn of wish_some() was one of waiting_
  std::vector<std::function<void(const Result<void>&)>> waits_;
  std::function<void(std::uint64_t)> ready_;
  Value propose_at_ = 0;  ///< when the first description of a cluster may be proposed
  LoopTimer timer_;
};

}  // namespace mlcca
