// SPDX-License-Identifier: BSD-2-Clause
// What this gateway wants of networks that it shares with others: one after the other is decided,
// reserved in the store and put in force, or refused.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/admission/state.hpp"
#include "core/cluster/member.hpp"
#include "daemon/cluster/codec.hpp"
#include "daemon/gateway/shared_networks.hpp"

namespace mlcca {

class Reserving {
 public:
  using Number = SharedNetworks::Number;

  /// As it was decided from what is known now.
  struct Wish {
    core::cluster::Footprint footprint;
    std::string publisher;
    cluster::Asked asked;
  };
  /// Somebody who wants something. Each is called with everything settled.
  struct Job {
    /// Nothing: it is not wanted any more, or has been answered.
    std::function<std::optional<Wish>()> decide;
    /// It is reserved, and may be used. False: it is not, after all.
    std::function<bool()> granted;
    std::function<void(const std::string& why)> refused;
    std::uint64_t session = 0;    ///< that must be there still; 0: none
    std::string key{};            ///< of which there may be one; empty: none
    std::optional<uid_t> user{};  ///< who has asked; nobody: the gateway itself
  };
  struct Parts {
    SharedNetworks& networks;
    /// Gates and state follow what has changed of the networks. False: the kernel has refused, and
    /// what is to be closed may be open.
    std::function<bool()> bring_in_line;
    /// Something that is in use of that channel needs that reservation.
    std::function<bool(const std::string& channel, Number number)> needs;
    std::function<void(const std::string&)> log;
  };
  /// `first`: numbers from there on are used for reservations.
  Reserving(Parts parts, Number first) : parts_(std::move(parts)), next_(first) {}

  static constexpr Value kPatience = 5'000'000'000;  ///< ns that one waits for its turn

  /// Why a user can have no further one; empty: he can.
  [[nodiscard]] std::string bar(uid_t user) const;
  /// One with that key waits.
  [[nodiscard]] bool waits_for(const std::string& key) const;
  /// Keys with that beginning.
  [[nodiscard]] std::size_t count_of_keys(const std::string& beginning) const;
  /// Whoever waits with that key is refused. False: nobody does.
  bool refuse(const std::string& key, const std::string& why);
  void ask(Job job, Value now);
  [[nodiscard]] Number new_number() { return next_++; }
  [[nodiscard]] bool idle() const { return jobs_.empty(); }
  /// Whoever waits for that session does not.
  void session_closed(std::uint64_t session);
  /// What was reserved for them is given back, where nobody else uses it.
  void admissions_gone(const std::vector<core::AdmissionId>& gone);
  void refuse_all(const std::string& why);

  void on(const core::cluster::Reserved& event, const core::cluster::Member& member);
  void on(const core::cluster::Conflict& event, core::cluster::Member& member, Value now);
  void on(const core::cluster::Refused& event, const core::cluster::Member& member);
  /// It is closed with the next bring_in_line(), and released by step().
  void on(const core::cluster::Withdrawn& event);
  /// What the store has of a process before is held again, where `known` says so of it.
  void on(const core::cluster::Found& event, const core::cluster::Member& member,
          const std::function<bool(const cluster::Asked&)>& known);
  void lost();

  /// True: something was done, or asked for.
  bool step(core::cluster::Member& member, Value now);
  /// What was reserved for a channel as it is described, or for admissions that are gone, is given
  /// back if nothing needs it any more.
  void tidy();
  /// When a job has waited for too long; nothing: none waits.
  [[nodiscard]] std::optional<Value> next_time() const;

  struct Held {
    std::string channel;
    std::vector<core::AdmissionId> admissions;  ///< none: of the channel as it is described
  };
  [[nodiscard]] const std::map<Number, Held>& held() const { return held_; }

 private:
  struct Open {
    Job job;
    Number number = 0;
    Value since = 0;
    bool asked = false;
    bool abandoned = false;
    std::string withdrawn{};  ///< by the store, and why; empty: it is not
    Wish wish{};
  };
  using Jobs = std::list<Open>;

  [[nodiscard]] Jobs::iterator find(Number number);
  [[nodiscard]] Jobs::iterator next_turn();
  void give_back(Number number);
  void release_closed(core::cluster::Member& member, Value now);
  void begin(Open& open, core::cluster::Member& member, Value now);
  void put_in_force(const Open& open);

  Parts parts_;
  Number next_;
  Jobs jobs_;
  std::map<Number, Held> held_;
  std::optional<uid_t> latest_;     ///< whose turn was the latest
  bool unused_ = false;             ///< there may be something for tidy()
  std::vector<Number> to_release_;  ///< when the gates have closed
  std::vector<Number> leaving_;     ///< the store may have them still
};

}  // namespace mlcca
