// SPDX-License-Identifier: BSD-2-Clause
// A model of some gateways with their store, and of everything between them that may be slow, lost
// or dead. It is a value, so a checker can continue from it in every direction. One shared network
// has room for one admission.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/cluster/lease.hpp"
#include "core/cluster/member.hpp"
#include "tests/core/cluster/codec.hpp"
#include "tests/core/cluster/rollout_side.hpp"
#include "tests/core/cluster/store_stub.hpp"

namespace mlcca::core::cluster::test {

inline constexpr Value kLease = 4'000'000'000;
/// The network that all gateways share.
inline constexpr std::size_t kBus = 0;
/// The length of a step of time, as long as kQueued.
inline constexpr Value kStep = kLease / 4;

/// Wrong protocols. A checker must find each of them.
enum class Mutant : std::uint8_t {
  none,
  renewed_without_quorum,  ///< a former leader of the store confirms a beat
  valid_from_answer,       ///< V counts from the arrival of the answer
  clock_error_ignored,     ///< V is the complete lease
  fence_without_compare,   ///< a slow gateway fences a live one
  freed_on_fence_alone,    ///< a fence alone frees a reservation
  grant_without_version,   ///< v/<network> is not compared
  no_fence_compare,        ///< a fenced gateway continues
  no_chain,                ///< late transactions of the past are carried out
  open_before_votes,       ///< an admission is granted before others agree
  ended_at_once,           ///< it leaves the store while other gateways still have it open
  active_without_asking,   ///< a gateway that comes back does not wait for the others
  agreed_at_once,          ///< an admission for another gateway is agreed to before it is reserved
  kept_after_its_end,      ///< it is not withdrawn when what was reserved for it ends
  ended_by_a_passing_refusal,  ///< a refusal that is not final releases an admission
  given_back_first,            ///< a reservation ends before the one that replaces it is in force
  served_without_a_vote,  ///< a subscriber is served as soon as its publisher is known for another
  // Of rollouts.
  counted_without_vote,  ///< who has not staged the description counts as having agreed
  former_vote_counts,    ///< a vote on another proposal counts
  open_at_once,          ///< shared networks stay open while gateways change
  said_before_closed,    ///< a gateway says that it has changed, and still sends by the former one
  opened_before_all,     ///< who is silent counts as having changed
  described_stays_open,  ///< what a description promises passes though another one is in force
  open_unheard,          ///< one that has hung opens before the store has answered
  off_ignored,           ///< who was called off is waited for all the same
};

/// What may happen in a run, and how often.
struct Scenario {
  std::string name = {};
  std::size_t gateways = 2;
  std::vector<int> clock_ppm = {0, 0};  ///< how much too fast each clock is, ppm
  int steps = 9;                        ///< number of steps of time
  bool way = false;                     ///< the requests of gateway 0 go through gateway 1
  bool behalf = false;                  ///< gateway 0 makes the admissions that gateway 1 asks for
  int subscribers = 0;                  ///< of those, gateway 1 has so many in its journal
  bool elect = false;                   ///< the gateways can replace each other
  std::vector<int> wants = {1, 1};      ///< number of requests of each gateway
  int releases = 0;
  int replaces = 0;  ///< reservations that their gateway replaces by smaller ones
  int late = 0;      ///< transactions that are carried out later or never
  int lost = 0;      ///< answers that are lost
  int twice = 0;     ///< answers that come twice
  int stalls = 0;    ///< watches that stop for a while
  int pauses = 0, crashes = 0;
  int fences = 0;       ///< by a hostile client
  int compactions = 0;  ///< after which all must read everything again
  int outages = 0;      ///< of the store
  int restores = 0;     ///< of a backup, after an outage of the length of a lease, with a new epoch
  int refusals = 0;     ///< by gateways on the route
  int drains = 0;
  bool waits = false;                     ///< for a step of time after a conflict
  std::vector<std::size_t> faulty = {0};  ///< gateways to which faults happen
  std::vector<Order> orders = {};         ///< rollouts
  int objections = 0;                     ///< votes against a description
  int cannots = 0;            ///< descriptions that cannot be loaded where all have agreed
  int cancels = 0;            ///< times that an operator gives up what is being rolled out
  Value patience = 6;         ///< of a rollout, in steps of time
  bool removes = false;       ///< the last gateway is not in description kWithoutLast
  bool off_for_good = false;  ///< who has crashed does not come back, and is called off
  Mutant mutant = Mutant::none;
};

/// One step of a run.
struct Step {
  enum class Kind : std::uint8_t {
    time,
    beats,
    apply,
    answer,
    watch,
    read_all,
    want,
    release,
    replace,
    change_mind,
    drain,
    roll_out,
    cancel,
    judge,
    load,
    object,
    cannot_load,
    late,
    lose,
    lose_silently,
    done_late,
    again,
    stall,
    unstall,
    pause,
    resume,
    crash,
    restart,
    fence,
    compact,
    outage,
    outage_ends,
    restore,
  };
  Kind kind = Kind::time;
  std::size_t gateway = 0;
  std::size_t index = 0;
};
[[nodiscard]] std::string text_of(const Step& step);

class World {
 public:
  World(const Scenario& scenario, std::shared_ptr<const Keys> keys);

  /// Everything that can happen now; with `faults` also faults.
  [[nodiscard]] std::vector<Step> steps(bool faults) const;
  void take(const Step& step);
  /// The broken promise; empty if there is none.
  [[nodiscard]] const std::string& broken() const { return broken_; }
  [[nodiscard]] bool at_end() const { return now_ >= scenario_->steps; }
  /// Lets no more faults happen. Then all gateways must become members and get what they ask for.
  void recover();
  [[nodiscard]] std::pair<std::uint64_t, std::uint64_t> fingerprint() const;

 private:
  using Admission = std::pair<std::size_t, std::uint64_t>;  ///< gateway, id

  /// A gate. Its frames leave while it is open and V has not passed.
  struct Gate {
    bool open = false;
    Value closed = 0;  ///< real time at which it was closed
    std::uint8_t description = 1;
  };
  struct Flight {
    Txn txn;
    bool beat = false;
    std::optional<TxnResult> result;
  };
  struct Late {
    std::size_t gateway = 0;
    std::uint64_t process = 0;
    Txn txn;
  };
  struct Host {
    std::optional<Member> member;  ///< empty while the process does not run
    std::uint64_t process = 0;
    bool paused = false, stalled = false, synced = false, drained = false, joined = false;
    std::size_t seen = 0;  ///< number of batches of the store's log that it has seen
    std::optional<Flight> flight;
    std::optional<TxnResult> former;  ///< an answer that has come
    Value answered_at = 0;
    // The rest survives a crash.
    Journalled journal;
    std::set<std::uint64_t> held;
    Value until = 0;  ///< V as the kernel has it, by the own clock
    std::map<Admission, Gate> gates;
    Gate ways;
    std::vector<bool> failed;
    std::set<std::uint64_t> found;
    std::map<std::uint64_t, std::uint64_t> replaces;  ///< by own admissions: former ones
    std::map<Origin, bool> agreed;
    std::map<Origin, std::uint64_t> behalf;  ///< own admissions for others; 0: not asked for yet
    std::uint64_t next_id = 1;
    std::map<std::uint64_t, int> answers;    ///< 1: granted, 2: refused
    std::set<int> kept;                      ///< subscribers in its journal
    std::map<int, std::uint64_t> asked_for;  ///< its request for a subscriber
    std::map<int, Gate> locals;              ///< to subscribers on a network of its own
    int asked_again = -1;                    ///< at this time
    RolloutSide rollout;
  };

  [[nodiscard]] Value clock(std::size_t gateway) const;
  [[nodiscard]] Value real() const { return static_cast<Value>(now_) * kStep; }
  [[nodiscard]] Value real_of(std::size_t gateway, Value local) const;
  [[nodiscard]] bool runs(std::size_t g) const { return hosts_[g].member && !hosts_[g].paused; }
  [[nodiscard]] bool beats_only() const;
  [[nodiscard]] bool fits(std::size_t g) const;
  [[nodiscard]] bool in_gate(std::size_t g, const Gate& gate) const;
  [[nodiscard]] bool on_wire(std::size_t g, const Gate& gate) const;
  void add_faults(std::vector<Step>& all) const;
  void take_fault(const Step& step);

  void start(std::size_t g);
  void turn(std::size_t g);
  void act(std::size_t g, const Event& event);
  void on_joined(std::size_t g);
  void close(std::size_t g, const Admission& admission);
  void close_gate(std::size_t g, Gate& gate);
  void answer(std::size_t g, std::uint64_t id, int what);
  void send(std::size_t g, Txn txn);
  TxnResult do_txn(const Txn& txn);
  void check_fence(const Txn& txn);
  void set_way(std::size_t g);
  void deliver(std::size_t g, const TxnResult& result);
  void watch(std::size_t g);
  void read_all(std::size_t g);
  void ask(std::size_t g, std::uint64_t id, const std::vector<std::size_t>& on_way);
  [[nodiscard]] std::vector<std::size_t> way_of(std::size_t g) const;
  [[nodiscard]] bool makes_for_others(std::size_t g) const;
  [[nodiscard]] const Origin* made_for(std::size_t g, std::uint64_t id) const;
  void vote_as(std::size_t g, std::uint64_t id, bool ok);
  void step_behalf(std::size_t g);
  void adopt_behalf(std::size_t g, const Origin& origin);
  void end_behalf(std::size_t g, const Origin& origin);
  [[nodiscard]] bool may_replace(std::size_t g) const;
  void replace(std::size_t g);
  [[nodiscard]] bool is_replaced_in_vain(std::size_t g, std::uint64_t id);
  void keep_replaced(std::size_t g, std::uint64_t id);
  void end_replaced(std::size_t g, std::uint64_t id);
  void check_replaced(std::size_t g, const Origin& ended);
  void end_strange_behalf(std::size_t g);
  void check_behalf();
  [[nodiscard]] bool serves(std::size_t g) const;
  [[nodiscard]] std::optional<int> subscriber_of(std::size_t g, std::uint64_t id) const;
  [[nodiscard]] bool is_all_agreed(std::size_t g) const;
  [[nodiscard]] bool are_all_kept() const;
  void want_subscriber(std::size_t g, std::uint64_t id);
  void on_agreed(std::size_t g, std::uint64_t id);
  void on_refused(std::size_t g, std::uint64_t id, bool final);
  void forget_subscriber(std::size_t g, std::uint64_t id);
  void end_publisher(std::size_t g);
  void follow_agreements(std::size_t g);
  void check_subscribers();
  void check_served();
  void forget_subscribers();

  // Rollouts (world_rollout.cc).
  [[nodiscard]] bool rolls_out() const { return !scenario_->orders.empty(); }
  /// One was ordered, or will be when a gateway has been off for long enough.
  [[nodiscard]] bool has_begun_rollout() const;
  [[nodiscard]] bool is_in_force(std::size_t g) const;
  [[nodiscard]] bool may_use(std::size_t g) const;
  [[nodiscard]] bool may_order(const Order& order) const;
  [[nodiscard]] Digest ordered(const Order& order) const;
  [[nodiscard]] bool described_on_wire(std::size_t g) const;
  void open_gate(std::size_t g, const Admission& admission);
  void begin_process(std::size_t g);
  void stop_process(std::size_t g);
  void go_on(std::size_t g);
  void on_rollout(std::size_t g, const Event& event);
  void put_permits(std::size_t g);
  void add_rollout_steps(std::vector<Step>& all) const;
  void take_rollout(const Step& step);
  void roll_out(const Order& order);
  [[nodiscard]] std::optional<Digest> to_cancel(std::size_t g) const;
  void cancel(std::size_t g);
  void note_cancelled(const Txn& txn, const Entry& next);
  void judge(std::size_t g, bool ok);
  void load(std::size_t g);
  void cannot_load(std::size_t g);
  void mutate_rollout(Txn& txn) const;
  void mutate_seen(std::size_t g, Batch& batch) const;
  void note_decision(const Txn& txn, const Entry& next);
  void check_descriptions();
  void check_rollouts();
  void call_off_who_is_gone();
  /// Whether a gateway is not in a description.
  [[nodiscard]] bool is_removed(std::size_t g, const Digest& description) const;
  [[nodiscard]] bool is_removed(std::size_t g) const;
  void pass_time();
  void check();
  void forget();
  void check_views();
  [[nodiscard]] std::string key_of(const Admission& admission) const;
  void close_strange(std::size_t g);

  const Scenario* scenario_;
  std::shared_ptr<const Keys> keys_;
  std::shared_ptr<const Keys> without_last_;  ///< keys of description kWithoutLast
  StoreStub store_;
  StoreStub backup_;  ///< from before the first request
  bool up_ = true;
  int down_since_ = 0;
  int now_ = 0;
  std::vector<Host> hosts_;
  std::vector<Late> late_;
  std::set<Admission> made_;  ///< of other gateways, that gateway 0 has admitted at some time
  std::set<int> promised_;    ///< subscribers that were granted and not released
  bool gone_ = false;         ///< the publisher of the subscribers
  std::vector<int> wants_;
  std::map<Admission, Admission> continued_;  ///< by former admissions: those in place of them
  int replaces_ = 0;
  int releases_ = 0, lates_ = 0, lost_ = 0, twice_ = 0, stalls_ = 0, pauses_ = 0, crashes_ = 0,
      fences_ = 0, compactions_ = 0, outages_ = 0, restores_ = 0, refusals_ = 0, drains_ = 0;
  std::vector<bool> ordered_;  ///< which of the orders have been given
  int objections_ = 0, cannots_ = 0, cancels_ = 0;
  std::set<std::int64_t> objected_;  ///< proposals against which the store has a vote
  std::set<Digest> over_;            ///< descriptions whose only rollout was given up
  std::set<std::int64_t> refused_;   ///< proposals that whoever has made them takes for ended
  Digest was_open_ = TextCodec::digest(1);  ///< the description that was in force last
  std::string broken_;
};

[[nodiscard]] std::shared_ptr<const Keys> keys_of(std::size_t gateways);

}  // namespace mlcca::core::cluster::test
