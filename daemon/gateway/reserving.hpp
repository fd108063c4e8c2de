// SPDX-License-Identifier: BSD-2-Clause
// What this gateway wants of networks that it shares with others: one after the other is decided,
// reserved in the store and put in force, or refused.
#pragma once
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
    std::uint64_t session = 0;  ///< that must be there still; 0: none
  };
  struct Parts {
    SharedNetworks& networks;
    /// Gates and state follow what has changed of the networks.
    std::function<void()> bring_in_line;
    std::function<void(const std::string&)> log;
  };
  /// `first`: numbers from there on are used for reservations.
  Reserving(Parts parts, Number first) : parts_(std::move(parts)), next_(first) {}

  static constexpr std::size_t kMostJobs = 256;
  static constexpr Value kPatience = 5'000'000'000;  ///< ns that one waits for its turn

  /// Why there can be no further one; empty: there can.
  [[nodiscard]] std::string bar() const;
  void ask(Job job, Value now);
  [[nodiscard]] Number new_number() { return next_++; }
  [[nodiscard]] bool idle() const { return jobs_.empty(); }
  /// Whoever waits for that session does not.
  void session_closed(std::uint64_t session);
  /// Their gates are closed.
  void admissions_gone(const std::vector<core::AdmissionId>& gone, core::cluster::Member& member,
                       Value now);
  void refuse_all(const std::string& why);

  void on(const core::cluster::Reserved& event, core::cluster::Member& member, Value now);
  void on(const core::cluster::Conflict& event, core::cluster::Member& member, Value now);
  void on(const core::cluster::Refused& event, const core::cluster::Member& member);
  /// It is closed with the next bring_in_line(), and released by step().
  void on(const core::cluster::Withdrawn& event);
  /// What the store has of a process before is held again, where `known` says so of it.
  void on(const core::cluster::Found& event, core::cluster::Member& member, Value now,
          const std::function<bool(const cluster::Asked&)>& known);
  void lost();

  /// True: something was done, or asked for.
  bool step(core::cluster::Member& member, Value now);
  /// The footprint is not needed any more: given back. `unused` is asked of what was reserved for a
  /// channel as it is described.
  void tidy(core::cluster::Member& member, Value now,
            const std::function<bool(const std::string& channel)>& unused);
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
  void give_back(Number number, core::cluster::Member& member, Value now);
  void begin(Open& open, core::cluster::Member& member, Value now);
  void put_in_force(const Open& open, core::cluster::Member& member, Value now);

  Parts parts_;
  Number next_;
  Jobs jobs_;
  std::map<Number, Held> held_;
  std::vector<Number> to_release_;  ///< withdrawn
  std::vector<Number> leaving_;     ///< the store may have them still
};

}  // namespace mlcca
