// SPDX-License-Identifier: BSD-2-Clause
// Reserves in the store what this gateway wants of networks that it shares with others.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <optional>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/admission/state.hpp"
#include "core/cluster/member.hpp"
#include "daemon/cluster/record_codec.hpp"
#include "daemon/gateway/shared_networks.hpp"

namespace mlcca {

/// A queue of jobs. Each one is decided, reserved in the store, and then put in force or refused.
/// The jobs of this gateway itself have every second turn at most, users and other gateways take
/// turns. Also keeps what is reserved until nothing needs it any more.
class Reserving {
 public:
  using Number = SharedNetworks::Number;

  /// A footprint to reserve, as it was decided with present knowledge.
  struct Wish {
    core::cluster::Footprint footprint;
    std::string publisher;
    cluster::StoredRequest asked;
  };
  /// What is reserved and may be used.
  struct Held {
    std::string channel;
    std::vector<core::AdmissionId> admissions;  ///< empty: for the channel as it is described
    std::vector<core::AdmissionId> also;        ///< others, whose publishers count in it
    bool on_behalf = false;  ///< another gateway has made the admission for this one
    /// This gateway has made the admission for that one, which has this number there; empty: not.
    std::string for_gateway{};
    std::uint64_t for_number = 0;
  };
  /// Why something is not reserved.
  struct Refusal {
    std::string why;  ///< one line, with the name of the gateway that refuses; empty: no refusal
    /// The other gateway that has refused it, that is not there, or that was quicker; nullopt:
    /// none.
    std::optional<std::size_t> gateway{};
    std::optional<core::Place> hop{};  ///< network or gateway where it does not fit, if it is one
  };
  /// A request for a reservation. Its functions are called when everything is settled.
  struct Job {
    /// Decides what to reserve; nullopt if it is no longer wanted or has already been answered.
    std::function<std::optional<Wish>()> decide;
    /// Called when it is reserved and may be used. False if it is not used after all.
    std::function<bool()> granted;
    std::function<void(const Refusal& why)> refused;
    /// Called instead of `refused` if another gateway has refused it for good; empty: `refused` is.
    std::function<void(const Refusal& why)> refused_for_good{};
    std::uint64_t session = 0;             ///< the job ends with this session; 0: with none
    std::string key{};                     ///< at most one job has this key; empty: no key
    std::optional<uid_t> user{};           ///< who has asked; nullopt: a gateway
    std::optional<std::size_t> gateway{};  ///< another gateway that has asked
    Number adopted = 0;                    ///< the number under which its request was adopted
    Number replaces = 0;                   ///< what is given back when this is granted; 0: nothing
    [[nodiscard]] bool is_own() const { return !user && !gateway; }
  };
  struct Parts {
    SharedNetworks& networks;
    /// Brings gates and state in line with changes of the networks. False if the kernel has
    /// refused, so that what is to be closed may be open.
    std::function<bool()> bring_in_line;
    /// Whether something that is granted now needs that reservation.
    std::function<bool(Number number, const Held& held)> needs;
    /// What is to be reserved instead of it, because admissions have ended that it names; nullopt:
    /// nothing that is granted now needs it.
    std::function<std::optional<Wish>(Number number, const Held& held)> rest;
    /// Called when what was reserved for these admissions is withdrawn. `ended`: another gateway
    /// had made them for this one, and will not make them again.
    std::function<void(const std::vector<core::AdmissionId>&, bool ended, const Refusal& why)>
        withdrawn;
    /// Called when another gateway has ended what was reserved for a channel over these gateways.
    std::function<void(const std::string& channel, std::vector<std::size_t> gateways,
                       const Refusal& why)>
        objected;
    /// Called when nothing with that number is asked for or held here any more.
    std::function<void(Number number)> ended;
    /// Why something of an earlier process is in the way of a further job; empty: nothing is.
    std::function<std::string()> in_the_way;
    std::function<void(const std::string&)> log;
  };
  /// Reservations are numbered from `first` on.
  Reserving(Parts parts, Number first) : parts_(std::move(parts)), next_(first) {}

  /// How long a job waits for its turn, ns. One of another gateway waits until forget(): that
  /// gateway says when it does not want it any more.
  static constexpr Value kPatience = 5'000'000'000;
  /// The longest text of an admission in the store, so that the entry with its key and other fields
  /// fits.
  static constexpr std::size_t kMostText = std::size_t{48} << 10U;

  /// Why a user can have no further job; empty if they can.
  [[nodiscard]] std::string bar(uid_t user) const;
  /// Why another gateway can have no further job; empty if it can.
  [[nodiscard]] std::string bar_gateway(std::size_t gateway, const std::string& name) const;
  /// Whether a job waits with this key.
  [[nodiscard]] bool waits_for(const std::string& key) const;
  /// Refuses the job that waits with this key. False if there is none.
  bool refuse(const std::string& key, const std::string& why);
  void ask(Job job, Value now);
  /// Ends the job of another gateway that was adopted under that number.
  void forget(Number adopted);
  [[nodiscard]] Number new_number() { return next_++; }
  /// Whether a job of this gateway itself is there.
  [[nodiscard]] bool has_own() const;
  /// Ends the jobs of a session.
  void session_closed(std::uint64_t session);
  /// These admissions have ended. What was reserved for them, or counted with their publishers, is
  /// given back unless something else uses it.
  void admissions_gone(const std::vector<core::AdmissionId>& gone);
  /// `to_do`: what users can do, for the end of the text.
  void refuse_all(const std::string& why, const std::string& to_do = {});

  void on(const core::cluster::Reserved& event, const core::cluster::Member& member);
  void on(const core::cluster::Conflict& event, core::cluster::Member& member, Value now);
  void on(const core::cluster::Refused& event, const core::cluster::Member& member);
  /// The store has withdrawn a reservation: it is closed with the next bring_in_line(), and
  /// released by step().
  void on(const core::cluster::Withdrawn& event, const core::cluster::Member& member);
  /// Takes over a reservation that the store has of an earlier process of this gateway, if `known`
  /// says that it is still wanted; otherwise gives it back.
  void on(const core::cluster::Found& event, const core::cluster::Member& member,
          const std::function<bool(const cluster::StoredRequest&)>& known);
  /// The lease is lost: nothing is held any more.
  void lost();

  /// Gives back what is closed, refuses what has waited for too long, and begins the next job. True
  /// if the next job was begun or ended.
  bool step(core::cluster::Member& member, Value now);
  /// Gives back what was reserved for a described channel, or with admissions that have ended, if
  /// nothing needs it any more.
  void tidy();
  /// When the next job will have waited for too long; nullopt if none waits.
  [[nodiscard]] std::optional<Value> next_time() const;

  [[nodiscard]] const std::map<Number, Held>& held() const { return held_; }
  /// The admissions that another gateway has made for this one, and for which something is held.
  [[nodiscard]] std::unordered_set<core::AdmissionId> agreed_admissions() const;
  /// Whether that number is held, or was asked for and is not answered yet.
  [[nodiscard]] bool has(Number number) const;
  /// Whether what other gateways have admitted for this one may have changed since the last call.
  void follow_agreements() { agreements_changed_ = true; }
  [[nodiscard]] bool take_agreements_changed() { return std::exchange(agreements_changed_, false); }

 private:
  struct Open {
    Job job;
    Number number = 0;
    Value since = 0;
    bool asked = false;
    bool abandoned = false;
    Refusal withdrawn{};  ///< why it was withdrawn from the store; empty: it was not
    Wish wish{};
    std::vector<core::AdmissionId> gone{};  ///< what has ended since that was decided
  };
  using Jobs = std::list<Open>;
  /// Those who take turns: each user, and all other gateways together.
  using Turn = std::pair<bool, uid_t>;

  [[nodiscard]] std::string why_waiting(const core::cluster::Member& member, Value now) const;
  [[nodiscard]] static Turn turn_of(const Job& job);
  [[nodiscard]] Jobs::iterator find(Number number);
  [[nodiscard]] Jobs::iterator next_turn();
  void note_turn(const Job& job);
  [[nodiscard]] bool is_over(Number number, const Held& held) const;
  void hold(Number number, const core::cluster::Footprint& footprint,
            const cluster::StoredRequest& asked, const std::vector<core::AdmissionId>& gone);
  void leave(Number number, Held& held, const std::vector<core::AdmissionId>& gone);
  void replace_outdated(Value now);
  void keep_outdated(Number number, const std::string& why);
  void give_back(Number number);
  void release_closed(core::cluster::Member& member, Value now);
  void begin(Open& open, core::cluster::Member& member, Value now);
  void put_in_force(const Open& open);

  Parts parts_;
  Number next_;
  Jobs jobs_;
  std::map<Number, Held> held_;
  /// Of those that are held: an admission has ended that they name in the store.
  struct Outdated {
    Value again = 0;    ///< no attempt to replace it before this time
    bool said = false;  ///< that it cannot be replaced now
  };
  std::map<Number, Outdated> outdated_;
  std::optional<Turn> latest_;  ///< whose turn was the latest, except that of this gateway
  std::optional<std::size_t> latest_gateway_;  ///< of the other gateways
  bool latest_own_ = false;                    ///< the latest turn was one of this gateway itself
  bool unused_ = false;                        ///< there may be something for tidy()
  bool agreements_changed_ = false;
  std::vector<Number> to_release_;  ///< when the gates have closed
  std::vector<Number> leaving_;     ///< released, but the store may still have them
};

}  // namespace mlcca
