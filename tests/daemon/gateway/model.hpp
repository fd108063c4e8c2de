// SPDX-License-Identifier: BSD-2-Clause
// What the clients of a gateway know of it, whatever fails meanwhile, and what must hold of it
// then.
#pragma once
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "tests/core/admission/bounds.hpp"
#include "tests/daemon/gateway/bench.hpp"
#include "tests/daemon/gateway/held.hpp"

namespace mlcca::test {

inline constexpr std::uint64_t kSecond = 1'000'000'000;

/// How often things happened: a test in which nothing does would prove little.
struct Tally {
  std::uint64_t steps = 0, admitted = 0, refused = 0, failed = 0, released = 0, reloads = 0;
  std::uint64_t restarts = 0, crashes = 0, lost = 0, expired = 0;

  Tally& operator+=(const Tally& other) {
    for (const auto field :
         {&Tally::steps, &Tally::admitted, &Tally::refused, &Tally::failed, &Tally::released,
          &Tally::reloads, &Tally::restarts, &Tally::crashes, &Tally::lost, &Tally::expired})
      this->*field += other.*field;
    return *this;
  }
};
inline Tally tally;

/// Deliveries that are granted, by subject.
using Served = std::set<std::pair<core::Subject, core::Delivery>>;

inline Served served(const core::State& state) {
  Served all;
  for (std::size_t c = 0; c < state.decisions().size(); ++c)
    for (auto& d : state.grants(c).deliveries)
      all.emplace(state.system().channels[c].subject, std::move(d));
  return all;
}

class Model {
 protected:
  explicit Model(std::uint64_t seed)
      : random_(seed),
        power_(static_cast<std::uint32_t>(seed)),
        bench_(random_system(random_)),
        first_(bench_.system),
        other_(varied(random_, first_)) {}

  struct Before {
    std::string service;
    std::map<core::AdmissionId, std::size_t> admissions;
    std::vector<Value> reserved;
    bool operator==(const Before&) const = default;
  };
  [[nodiscard]] Before now() const {
    Before out{core::testing::service(bench_.state()), bench_.state().admissions(), {}};
    for (std::size_t r = 0; r < bench_.state().system().resources(); ++r)
      out.reserved.push_back(bench_.state().ledger().reserved(r));
    return out;
  }

  void demand(bool holds, const std::string& otherwise) {
    if (!holds && wrong_.empty()) wrong_ = otherwise;
  }

  // --- trouble -----------------------------------------------------------------------------------

  void make_trouble() {
    using store::test::Trouble;
    trouble_ = true;
    const std::size_t at = 1 + below(random_, 8);
    const std::size_t many = 1 + below(random_, 3);
    switch (below(random_, 12)) {
      case 0:
      case 1:
      case 2:
        steps_ += " [disk]";
        unsure_disk_ = true;
        bench_.disk().trouble(std::array{Trouble::fail, Trouble::fail_after, Trouble::lose,
                                         Trouble::write_part}[below(random_, 4)],
                              at, ENOSPC, many);
        break;
      case 3:
        steps_ += " [power]";
        bench_.disk().trouble(chance(random_, 50) ? Trouble::stop : Trouble::stop_after, at, 0);
        break;
      case 4:
        steps_ += " [killed]";
        bench_.kernel.calls.kill(at);
        break;
      default:
        steps_ += " [kernel]";
        bench_.kernel.calls.refuse(at, many);
    }
  }
  void end_trouble() {
    trouble_ = false;
    bench_.kernel.calls.relent();
    bench_.disk().trouble(store::test::Trouble::fail, 1, 0, 0);
  }

  void act() {
    steps_ += " act";
    bench_.act();
    turn_ended_ = true;
    take_commits();
  }

  /// What was held is answered now, or an error is.
  void take_commits() {
    for (const Result<void>& done : std::exchange(bench_.commits, {})) {
      if (done) {
        granted_.merge(held_);
        unmended_.clear();
        perhaps_gone_.clear();
        perhaps_withdrawn_.clear();
        unsure_disk_ = trouble_;
      } else {
        for (const auto& [id, request] : held_) {
          unmended_.insert(id);
          sessions_.erase(id);  // the next admission may get its number
          demand(!bench_.state().admissions().contains(id), "what the disk refused is granted");
          ++tally.lost;
        }
      }
      held_.clear();
    }
  }

  // --- ends and beginnings -----------------------------------------------------------------------

  /// No client got the answers that were held; what they granted may be on disk all the same.
  void crash() {
    ++tally.crashes;
    end_trouble();
    steps_ += " crash";
    bench_.readable = true;
    for (const auto& [id, request] : held_) unmended_.insert(id);
    held_.clear();
    bench_.lose_power(power_);
    if (chance(random_, 20)) bench_.clock.monotonic += 40 * kSecond;
    bench_.kernel.advance_to(bench_.clock.monotonic);
    restart();
  }

  void restart() {
    ++tally.restarts;
    steps_ += " start";
    sessions_.clear();
    bench_.commits.clear();
    if (chance(random_, 30)) {
      make_trouble();
      bool started = false;
      bool killed = false;
      try {
        started = !bench_.start();
        if (!started) demand(!bench_.kernel.open, "a failed start has left the gates open");
      } catch (const store::test::PowerLoss&) {
        killed = true;
      } catch (const Killed&) {
        killed = true;
      }
      end_trouble();
      if (killed) bench_.lose_power(power_);
      if (!started || killed) bench_.end();
      if (started) steps_ += "ed in trouble";
    }
    if (!bench_.runs()) {
      const auto failure = bench_.start();
      demand(!failure, "it does not start: " + (failure ? failure->lines.front() : ""));
      if (failure) {
        bench_.end();
        return;
      }
    }
    in_force_ = bench_.system;
    bench_.act();
    turn_ended_ = true;
    bench_.commits.clear();
    adopt_recorded();
    expect_served();
  }

  /// Every admission that was answered is there, and no other one.
  void adopt_recorded() {
    const auto recorded = bench_.recorded(power_);
    for (const auto& [id, request] : granted_)
      demand(recorded.admissions.find(id) != nullptr || perhaps_gone_.contains(id),
             "admission " + std::to_string(id) + " was answered and is forgotten");
    std::erase_if(granted_, [&](const auto& known) {
      return recorded.admissions.find(known.first) == nullptr;
    });
    for (const control::Request& r : recorded.admissions) {
      demand(granted_.contains(r.id) || unmended_.contains(r.id),
             "admission " + std::to_string(r.id) + " was never answered as granted");
      granted_.emplace(r.id, std::get<control::Admit>(r.body));
    }
    for (std::size_t c = 0; c < first_.channels.size(); ++c) {
      const std::string& name = first_.channels[c].name;
      const bool away = bench_.state().withdrawn(c);
      demand(away == withdrawn_[name] || perhaps_withdrawn_.contains(name),
             name + (away ? " is withdrawn, and was not" : " was withdrawn, and is not"));
      withdrawn_[name] = away;
    }
    perhaps_withdrawn_.clear();
    unmended_.clear();
    perhaps_gone_.clear();
    unsure_disk_ = false;
  }

  /// Who had something has it again, where the networks can still do what they could.
  void expect_served() {
    const auto conditions = bench_.gates().conditions(bench_.state().system().networks.size());
    if (conditions == conditions_ && settled_)
      for (const auto& [subject, delivery] : std::exchange(served_, {})) {
        const auto again = served(bench_.state());
        demand(again.contains({subject, delivery}),
               "not granted again: " + delivery.publisher + " to " + delivery.to);
      }
  }

  // --- what must hold ----------------------------------------------------------------------------

  void check() {
    demand(core::testing::beyond_bounds(bench_.state()).empty(),
           core::testing::beyond_bounds(bench_.state()));
    demand(wrong_gate(bench_).empty(), wrong_gate(bench_));
    check_admissions();
    settled_ =
        held_.empty() && unmended_.empty() && perhaps_gone_.empty() && perhaps_withdrawn_.empty();
    if (!settled_ || !wrong_.empty()) return;
    // What is granted without being asked for is on disk when the turn has ended.
    served_ = turn_ended_ ? served(bench_.state()) : Served{};
    conditions_ = bench_.gates().conditions(bench_.state().system().networks.size());
    if (!chance(random_, 30)) return;
    const auto recorded = bench_.recorded(power_);
    for (const auto& [id, request] : granted_)
      demand(recorded.admissions.find(id) != nullptr,
             "admission " + std::to_string(id) + " was answered and is not on disk");
    demand(recorded.admissions.size() == granted_.size(), "something else is on disk");
  }

  /// What is admitted was answered, or waits for the disk.
  void check_admissions() {
    for (const auto& [id, channel] : bench_.state().admissions())
      demand(granted_.contains(id) || held_.contains(id),
             "admission " + std::to_string(id) + " is not known to anyone");
  }

  Random random_;
  std::mt19937 power_;
  Bench bench_;
  core::System first_, other_, in_force_;
  bool trouble_ = false;
  bool unsure_disk_ = false;  ///< what the disk refused may be on it until the next commit
  std::map<core::AdmissionId, control::Admit> granted_;  ///< answered
  std::map<core::AdmissionId, control::Admit> held_;     ///< answered when the disk has it
  std::set<core::AdmissionId> unmended_;  ///< answered by an error, perhaps on disk all the same
  std::set<core::AdmissionId> perhaps_gone_;  ///< the answer was lost, or an error
  std::map<std::string, bool> withdrawn_;     ///< channels, as answered
  std::set<std::string> perhaps_withdrawn_;   ///< the answer was lost, or an error
  std::map<core::AdmissionId, std::set<std::uint64_t>> sessions_;  ///< who holds it
  bool turn_ended_ = false;                                        ///< after the last step
  bool settled_ = false;
  Served served_;
  std::vector<core::Condition> conditions_;
  std::string steps_;
  std::string wrong_;
};

}  // namespace mlcca::test
