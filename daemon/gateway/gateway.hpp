// SPDX-License-Identifier: BSD-2-Clause
// The gateway itself: events come in, the core decides, the kernel obeys, then the answer is given.
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <ctime>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "daemon/gates/control.hpp"
#include "daemon/gates/events.hpp"
#include "daemon/gates/starting.hpp"
#include "daemon/gateway/aside.hpp"
#include "daemon/gateway/bus_load.hpp"
#include "daemon/gateway/delivery_events.hpp"
#include "daemon/gateway/drops.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/forwarder.hpp"
#include "daemon/gateway/health.hpp"
#include "daemon/gateway/keys.hpp"
#include "daemon/gateway/leases.hpp"
#include "daemon/gateway/meshes.hpp"
#include "daemon/gateway/patience.hpp"
#include "daemon/gateway/problem.hpp"
#include "daemon/gateway/quotas.hpp"
#include "daemon/gateway/reading.hpp"
#include "daemon/gateway/requests.hpp"
#include "daemon/gateway/rounds.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/gateway/tags.hpp"
#include "daemon/gateway/user_names.hpp"
#include "daemon/net/links.hpp"
#include "daemon/options.hpp"
#include "daemon/ports/ports.hpp"
#include "daemon/serve/server.hpp"
#include "daemon/store/history.hpp"
#include "daemon/store/journal.hpp"

namespace mlcca {

/// Why a description is not used, or the daemon cannot start.
struct StartError {
  std::vector<std::string> lines;
  /// The description was read and is refused: only a person can mend that. False: the machine
  /// failed (a file that cannot be opened, no memory, a full disk), and the next start may succeed.
  bool bad_input = false;
};

class Gateway {
 public:
  using Committed = std::function<void(const Result<void>&)>;

  /// `loop` must outlive this; sources of link states run on it.
  Gateway(Options options, SystemLog log, enforce::Control control, net::Links links,
          net::FactsOf facts_of, sd_event* loop);
  Gateway(const Gateway&) = delete;
  Gateway& operator=(const Gateway&) = delete;
  Gateway(Gateway&&) = delete;
  Gateway& operator=(Gateway&&) = delete;
  ~Gateway() = default;

  /// Reads the description and what was admitted before, closes or keeps the gates accordingly and
  /// opens them. On failure every gate is closed. Nothing else may be on the loop yet.
  std::optional<StartError> start();
  /// Everything is denied; the gates stay in the kernel.
  void stop();
  /// As the control request does; what is wrong goes to the journal.
  void reload();
  /// A thread reads a description.
  [[nodiscard]] bool is_reading() const { return reading_.busy() || reads_for_ever_; }

  void on_event(EventLog::Publish publish) { log_.on_event(std::move(publish)); }
  /// Told when everything that was answered with `held` is on disk, or why it is not: then none of
  /// it is granted any more.
  void on_commit(Committed committed) { committed_ = std::move(committed); }
  /// Told when a reply to a session that had to wait goes on.
  void on_slice(const Aside::Ready& ready) {
    ready_ = ready;
    aside_.on_ready(ready);
  }
  /// That of lock_gates(): it is looked after from now on.
  void hold(Fd lock) { lock_ = std::move(lock); }
  /// Says whether a client has hung up: nothing is begun for it any more.
  void on_begin(Aside::Gone gone) { aside_.on_begin(std::move(gone)); }
  /// Otherwise ForkBudget::kUsual.
  void set_report_rates(ForkBudget::Rates rates) { aside_.set_rates(rates); }
  serve::Answer answer(const control::Request& request, const serve::Peer& peer);
  /// A connection has ended: the leases that it held begin to run.
  void session_closed(std::uint64_t session);

  [[nodiscard]] int links_fd() const { return links_.fd(); }
  void links_changed();
  /// What the kernel tells by itself; there from start() on.
  [[nodiscard]] int events_fd() const { return events_->fd(); }
  void events_came();
  /// Udev learned something about an interface.
  void identities_changed() { follow_world(); }
  /// Once a turn of the loop, after the handlers: decides what changed links touch, and writes down
  /// what was granted.
  void act();
  /// Sign of life for the kernel, at least every beat_interval().
  void beat();
  [[nodiscard]] std::uint64_t beat_interval() const { return control_.beat_interval(); }
  /// Once a second: what it looks at by itself (lost filters, leases, the load of buses, drops to
  /// report) is to be looked at again, a part with each work().
  void begin_round() { rounds_.begin(); }
  [[nodiscard]] bool has_work() const { return rounds_.under_way(); }
  void work() { rounds_.turn(); }

  /// One line for systemd's status.
  [[nodiscard]] std::string summary() const;

 private:
  using Body = decltype(control::Reply::body);
  Body handle(const control::StatusRequest& request);
  [[nodiscard]] control::Status status() const;
  Body handle(const control::NetworksRequest& request);
  Body handle(const control::ChannelsRequest& request);
  Body handle(const control::Query& request);
  Body handle(const control::Admit& request);
  Body admit(const control::Admit& request);
  Body handle(const control::ReleaseRequest& request);
  Body handle(const control::WithdrawRequest& request);
  Body handle(const control::ReinstateRequest& request);
  Body handle(const control::ExplainRequest& request);
  Body handle(const control::MonitorRequest& request);
  Body handle(const control::ModeRequest& request);
  Body handle(const control::ReloadRequest& request);
  Body handle(const control::RenewRequest& request);
  Body handle(const control::RoutesRequest& request);
  Body handle(const control::ReservationsRequest& request);
  Body handle(const control::WhatIfRequest& request);
  Body handle(const control::HistoryRequest& request);
  Body handle(const control::GateRequest& request);

  /// Admissions that have no place in the description, and why.
  using LeftOut = std::map<core::AdmissionId, std::string>;
  struct Loaded {
    std::unique_ptr<core::State> state;
    std::size_t self = 0;
    LeftOut left_out;
  };
  using LoadResult = std::expected<Loaded, StartError>;
  [[nodiscard]] static LoadResult read(const Options& options);
  /// Why a description was not read, and what to look for.
  [[nodiscard]] std::string not_read_in_time() const;
  [[nodiscard]] LoadResult complete(LoadResult loaded) const;
  /// What was read is to be in force.
  Body reload_with(LoadResult read);
  void end_reload(Body body);
  void restore_into(Loaded& loaded) const;
  void remember_leases_and_keys();

  /// Follows the interfaces, decides what that touches and brings the kernel in line.
  void follow_world();
  void put_conditions(core::State& state) const;
  void put_graphs(core::State& state) const;
  using Granted = DeliveryEvents::Granted;
  [[nodiscard]] Granted granted() const;

  /// What a bus carries beside what is analysed, in 1e-6 of its time.
  struct Beyond {
    std::uint32_t strangers = 0;
    std::uint32_t told = 0;          ///< of the strangers, when it was last told
    std::vector<core::Heard> heard;  ///< who is known, refused, and sends all the same
  };

  /// Decides what was changed, brings the gates in line and tells. `left`: what the gates had of
  /// the channels that somebody has left.
  Result<void> settle(const core::FormerRules& left = {});
  Result<void> enforce();
  Result<void> put_in_force(const Granted& granted_before);
  void commit();
  void keep_journal();
  /// In what takes long, after each step: the kernel and systemd hear that it goes on.
  void pulse();
  void take_back_uncommitted();
  /// What a channel has been granted, and what the gates hold of it.
  void note(std::size_t channel);
  void note_granted(std::size_t channel);
  void note_ports();
  void note_slots(core::GateState of_all);
  void write_down(const store::Entry& entry);
  void note_granted(const std::string& subject, const std::string& text);
  [[nodiscard]] const store::Contents& stored() const { return store_->contents(); }

  Result<void> release(const std::vector<core::AdmissionId>& gone, const std::string& why);
  Result<void> set_withdrawn(std::size_t channel, bool withdrawn);
  core::FormerRules forget(const std::vector<core::AdmissionId>& gone);
  void plan_rounds();
  void keep_lock();
  bool look_around();
  bool repair_next();
  bool end_some_leases();
  bool measure_some_buses();
  bool look_for_next_bypass();
  bool write_some_history();
  [[nodiscard]] bool is_measured(std::size_t port);
  void hear_refused(const core::Decision& decision, std::size_t port);
  bool measure_bus(std::size_t port, std::vector<core::Heard> senders);
  void set_bands();
  /// What can-gw must carry of a channel, and of all of them.
  void forward(std::size_t channel);
  void forward_all();
  void add_can_rules(control::Routes& to,
                     const Result<std::vector<net::CanRuleThere>>& there) const;
  void open_unless_lost();
  // FAMOUSO's tags, see daemon/gateway/tags.hpp.
  void take_up_tags();
  void state_tags();
  void put_tag(const Tag& tag);
  void tell_rivals(const std::vector<Tag*>& changed);
  bool look_at_tags(bool anyway = false);
  void claim_tags();
  void leave_unused_tags();
  bool ask_for_tags();
  struct TagNews;
  void take_tag_news(std::size_t port, const enforce::FoundBinding& found, TagNews& news);
  bool move_tags(const TagNews& news, core::FormerRules& left);
  void move_tag(Tag& tag, core::FormerRules& left);
  bool agree_on(const Tag& tag);
  void tell_tag(const Tag& tag, int priority, std::string message);
  void look_at_drops(bool mention);
  bool look_at_some_drops();
  void look_at_unknown(std::size_t port, bool mention);
  void look_at_all_unknown(bool mention);
  bool look_at_next_unknown();
  void tell_all_drops();
  void forget_drops();
  void hear(const gate_event& event);
  void hear(const gate_sample& sample);
  void tell_missing_again(const core::Verdict& verdict);
  void report_outcome(const Granted& before, const DeliveryEvents::Reported& reported = {});
  void look_at_drops_of(const core::Decision& decision, bool mention);
  /// Entries by which events of several publishers of a channel come or leave, sorted.
  [[nodiscard]] std::vector<core::GateEntry> shared_entries_of(std::size_t channel) const;
  /// What is wrong with a granted delivery; `shared` of its channel.
  [[nodiscard]] std::vector<std::string> troubles_of(const core::Verdict& verdict,
                                                     const core::GateState& rules,
                                                     const std::vector<core::GateEntry>& shared,
                                                     std::optional<control::Watch> watch) const;
  [[nodiscard]] control::Health health(const std::vector<control::Interface>& interfaces) const;
  /// Of the daemon itself, the most serious first.
  [[nodiscard]] std::vector<std::string> own_problems() const;
  void add_own_troubles(std::vector<std::string>& to) const;
  void add_troubles_of_deliveries(std::vector<std::string>& to) const;
  /// "enforce" or "audit".
  [[nodiscard]] const char* mode_name() const;
  /// What is said of some or all verdicts of one channel.
  [[nodiscard]] std::vector<control::Channel> report(
      const std::vector<const core::Verdict*>& verdicts) const;
  [[nodiscard]] control::Channels report_known(const Asked& asked) const;
  [[nodiscard]] control::Channels report_admission(core::AdmissionId id) const;
  [[nodiscard]] Result<core::AdmissionId> admission_named(core::AdmissionId id,
                                                          const std::string& key) const;
  control::Actor actor_of(const serve::Peer& peer);
  // So much that it is not said between two heart-beats.
  [[nodiscard]] bool is_large() const;
  [[nodiscard]] bool has_much_trouble() const;
  [[nodiscard]] bool has_many_ends(std::size_t channel) const;
  [[nodiscard]] bool has_many_lines(std::size_t channel) const;
  [[nodiscard]] bool has_channel_of_many_ends() const;
  /// Where a list of all deliveries goes on.
  struct Position {
    std::size_t channel = 0;
    std::size_t verdict = 0;
  };
  [[nodiscard]] serve::Slice some_channels(Position& at) const;
  Body known_or_aside(const Asked& asked);
  Body aside(Aside::Make make);
  Body in_slices(std::size_t least_bytes, std::function<serve::Slice()> next);
  std::optional<Body> admit_again(const control::Admit& request);
  Body would_be(const Asked& asked);
  [[nodiscard]] std::optional<std::string> lacks_pairs(const Asked& asked) const;
  Body admit_new(const control::Admit& request, const Asked& asked);
  void own(core::AdmissionId id, const control::Admit& request);
  /// The newcomer's verdicts, or an error where there is nobody on the other side.
  [[nodiscard]] Body answer_to(const core::Proposal& proposal, const Asked& asked,
                               const char* to_do) const;

  Options options_;
  Scene scene_;
  EventLog log_;
  DeliveryEvents deliveries_{scene_, log_, [this] { pulse(); }};
  enforce::Control control_;
  net::Links links_;
  Ports ports_;
  std::optional<enforce::EventReader> events_;
  std::optional<enforce::Starting> starting_;
  bool is_starting_ = false;
  Meshes meshes_;
  Tags tags_;
  std::map<std::uint32_t, std::uint32_t> tag_news_;  ///< that were looked at, by interface
  Forwarder forwarder_;
  Aside aside_;
  Reading reading_;
  Patience patience_{[this] { pulse(); }};
  bool reads_for_ever_ = false;
  Aside::Ready ready_;
  /// Of the reload that is under way: what is answered, and to whom.
  struct Reload {
    std::optional<Body> body;
    std::uint64_t session = 0;
    std::optional<control::Actor> actor;
  };
  std::shared_ptr<Reload> reload_;
  std::uint64_t pulsed_ = 0;                        ///< CLOCK_MONOTONIC, ns
  std::map<std::size_t, std::string> not_carried_;  // why, by channel
  std::optional<store::Journal> store_;
  std::optional<store::History> history_;
  /// Why frames of an entry are dropped, as far as that is told apart; of what is too much nobody
  /// asks whether audit mode has let it through.
  enum class Drop : std::uint8_t { misfit, would_be_misfit, excess };
  DropWatch<std::pair<core::GateEntry, Drop>> drops_;
  DropWatch<std::pair<std::size_t, Fate>> unknown_;  ///< by port
  std::set<std::size_t> troubled_;  ///< channels; each is looked at again when it is told

  // Rounds, and how far each of their jobs is.
  Rounds rounds_;
  int at_gate_ = 0;             ///< the last one, by ifindex
  std::size_t looked_at_ = 0;   ///< channel at which the next look at drops begins
  std::size_t at_unknown_ = 0;  ///< port
  struct Hearing {
    std::uint64_t description = 0;
    std::size_t port = 0;
    std::size_t channel = 0;
    std::set<std::size_t> looked_at;   ///< publishers
    std::vector<core::Heard> refused;  ///< on this port
    bool changed = false;              ///< on any
    void next_port() {
      ++port;
      channel = 0;
      looked_at.clear();
      refused.clear();
    }
  };
  Hearing hearing_;
  Committed committed_;
  std::time_t started_ = 0;
  std::time_t loaded_ = 0;
  std::string last_error_;
  Problem journal_trouble_;
  Problem journal_gone_;  // why it cannot be written anew
  Fd lock_;               // see lock_gates()
  Problem unlocked_;      // why it is another one's
  Problem unpinned_;      // why the control word is not pinned

  std::set<std::size_t> dirty_meshes_;          // networks
  std::vector<core::AdmissionId> uncommitted_;  // granted, and not on disk yet
  Leases leases_;
  Keys keys_;
  Quotas quotas_;
  LeftOut left_out_;
  std::map<core::AdmissionId, std::set<std::uint64_t>> held_;          // by which sessions
  std::map<std::string, BusLoad> loads_;                               // by network
  std::map<std::pair<std::size_t, std::size_t>, SenderLoad> senders_;  // by port and publisher
  std::map<std::size_t, Beyond> beyond_;                               // by network

  // Of the request that is being answered.
  serve::Peer peer_;
  bool may_slice_ = false;
  bool hold_answer_ = false;
  UserNames users_;
  core::AdmissionId owned_ = 0;
  serve::NextSlice slices_;
  std::size_t least_bytes_ = 0;
};

}  // namespace mlcca
