// SPDX-License-Identifier: BSD-2-Clause
// Whatever happens to a gateway, and whatever fails meanwhile: the gates hold what is granted or
// deny, what was answered is on disk, what failed has changed nothing, and no answer is late. SETS
// random histories (100,000, or as the environment says) from the seed SEED on, shared among a
// process for each CPU.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/model/text.hpp"
#include "tests/daemon/gateway/histories.hpp"
#include "tests/daemon/gateway/model.hpp"

namespace mlcca::test {
namespace {

constexpr std::uint64_t kSets = 100'000;
constexpr std::size_t kMostSteps = 24;

class Machine : Model {
 public:
  explicit Machine(std::uint64_t seed) : Model(seed) {}

  /// What went wrong; empty: nothing.
  std::string run() {
    restart();
    for (std::size_t i = 6 + below(random_, kMostSteps - 6); i > 0 && wrong_.empty(); --i) step();
    return wrong_.empty() ? "" : wrong_ + "\n  after:" + steps_;
  }

 private:
  // --- steps -------------------------------------------------------------------------------------

  void step() {
    ++tally.steps;
    turn_ended_ = false;
    if (chance(random_, 25)) make_trouble();
    try {
      switch (below(random_, 16)) {
        case 0:
        case 1:
        case 2:
        case 3:
          admit();
          break;
        case 4:
          query();
          break;
        case 5:
        case 6:
          release();
          break;
        case 7:
          withdraw();
          break;
        case 8:
          reload();
          break;
        case 9:
        case 10:
          change_links();
          break;
        case 11:
          pass_time();
          break;
        case 12:
          end_session();
          break;
        case 13:
          round();
          break;
        case 14:
          lose_gate();
          break;
        default:
          stop();
          return;
      }
      if (chance(random_, 70)) act();
    } catch (const store::test::PowerLoss&) {
      crash();
    } catch (const Killed&) {
      crash();
    }
    end_trouble();
    if (bench_.runs()) check();
  }

  [[nodiscard]] control::Admit random_request() {
    const core::System& system = bench_.state().system();
    const auto place = [&] {
      const std::size_t i = below(random_, system.networks.size() + 1);
      return i == system.networks.size() ? std::string("g") : system.networks[i].name;
    };
    control::Admit a;
    a.channel = "c" + std::to_string(below(random_, first_.channels.size()));
    if (chance(random_, 60)) a.from = place();
    if (chance(random_, 60)) a.to = place();
    a.unlisted = chance(random_, 20);
    if (a.unlisted) {
      a.channel = core::format_subject(kUnlistedSubjects + below(random_, 4));
      a.from = place();
      a.to = place();
      for (const core::Network& n : system.networks)
        if (n.kind == core::NetworkKind::can)
          a.identifiers.push_back(
              {n.name, static_cast<std::uint32_t>(0x40 + below(random_, 6)), false});
    }
    if (!a.from.empty() && (a.unlisted || chance(random_, 60))) {
      a.publisher = "new" + std::to_string(below(random_, 3));
      a.offered = {{"Period", (5 + below(random_, 60)) * kMs, "ns", false},
                   {"MaxPayload", 8, "bytes", false}};
      if (a.from == "g") a.user = "1000";
      if (a.from == "eth0") a.address = "10.0.0." + std::to_string(1 + below(random_, 3));
    }
    if (!a.to.empty() && chance(random_, 60)) a.subscriber = "late";
    if (chance(random_, 30)) a.key = "k" + std::to_string(below(random_, 3));
    if (chance(random_, 30)) a.lease_ns = (5 + below(random_, 15)) * kSecond;
    a.hold = chance(random_, 20);
    return a;
  }

  void admit() {
    const bool again = !granted_.empty() && chance(random_, 15);
    const control::Admit request = again ? granted_.begin()->second : random_request();
    steps_ += " admit " + request.channel;
    const Before before = now();
    const auto session = 1 + below(random_, 3);
    const auto answer = bench_.ask(request, member(session));
    std::set<core::AdmissionId> fresh;
    for (const auto& [id, channel] : bench_.state().admissions())
      if (!before.admissions.contains(id)) fresh.insert(id);
    if (std::holds_alternative<control::Error>(answer.reply.body)) {
      steps_ += " (" + std::get<control::Error>(answer.reply.body).message + ")";
      demand(now() == before, "an admission that was answered by an error has changed something");
      ++tally.failed;
      return;
    }
    if (fresh.empty()) {
      demand(now() == before, "an admission that was refused has changed something");
      if (answer.owned != 0) sessions_[answer.owned].insert(session);
      ++tally.refused;
      return;
    }
    demand(fresh.size() == 1 && answer.held, "a grant that does not wait for the disk");
    for (const auto& c : std::get<control::Channels>(answer.reply.body).channels)
      demand(c.granted, "not all of an admission is granted");
    steps_ += " = " + std::to_string(*fresh.begin());
    held_.emplace(*fresh.begin(), request);
    if (request.hold) sessions_[*fresh.begin()].insert(session);
    ++tally.admitted;
  }

  void query() {
    control::Query query;
    static_cast<control::ChannelRequest&>(query) = random_request();
    steps_ += " query";
    const Before before = now();
    bench_.ask(query, outsider());
    demand(now() == before, "a query has changed something");
  }

  /// After an answer that says so, nothing has changed; unless the disk refused meanwhile what was
  /// answered before.
  bool is_done(const serve::Answer& answer, const Before& before) {
    const bool lost = std::ranges::any_of(bench_.commits, [](const auto& c) { return !c; });
    take_commits();
    const auto* error = std::get_if<control::Error>(&answer.reply.body);
    if (error == nullptr) return true;
    steps_ += " (" + error->message + ")";
    demand(lost || now() == before, "after an error something has changed");
    return false;
  }

  void release() {
    settled_ = false;
    control::ReleaseRequest request;
    if (!granted_.empty() && chance(random_, 80)) {
      auto it = granted_.begin();
      std::advance(it, below(random_, granted_.size()));
      if (chance(random_, 50) && !it->second.key.empty())
        request.key = it->second.key;
      else
        request.admission = it->first;
    } else {
      request.channel = "c" + std::to_string(below(random_, first_.channels.size()));
    }
    steps_ += " release " + request.channel + request.key + std::to_string(request.admission);
    const Before before = now();
    const auto of = bench_.state().find_channel(request.channel);
    const auto is_meant = [&](core::AdmissionId id, const control::Admit& known) {
      const auto there = before.admissions.find(id);
      return id == request.admission || (!request.key.empty() && known.key == request.key) ||
             (of && there != before.admissions.end() && there->second == *of);
    };
    const auto mark_perhaps_gone = [&] {
      for (const auto& [id, known] : granted_)
        if (is_meant(id, known)) perhaps_gone_.insert(id);
    };
    mark_perhaps_gone();
    const auto answer = bench_.ask(request);
    const bool done = is_done(answer, before);
    if (!trouble_ && !unsure_disk_)
      perhaps_gone_.clear();
    else if (!done)
      mark_perhaps_gone();  // what was committed, was committed before
    if (!done) return;
    std::erase_if(granted_, [&](const auto& known) { return is_meant(known.first, known.second); });
    ++tally.released;
  }

  void withdraw() {
    settled_ = false;
    const std::string channel = "c" + std::to_string(below(random_, first_.channels.size()));
    const bool away = chance(random_, 50);
    steps_ += away ? " withdraw " : " reinstate ";
    steps_ += channel;
    const Before before = now();
    perhaps_withdrawn_.insert(channel);
    const auto answer = away ? bench_.ask(control::WithdrawRequest{channel})
                             : bench_.ask(control::ReinstateRequest{channel});
    const bool done = is_done(answer, before);
    if (!trouble_ && !unsure_disk_)
      perhaps_withdrawn_.clear();
    else if (!done)
      perhaps_withdrawn_.insert(channel);  // what was committed, was committed before
    if (!done) return;
    withdrawn_[channel] = away;
    const auto known = bench_.state().find_channel(channel);
    demand(known && bench_.state().withdrawn(*known) == away, "not withdrawn as answered");
  }

  void reload() {
    settled_ = false;
    const std::size_t which = below(random_, 4);
    bench_.readable = which != 0;
    const core::System& next = which == 1 ? other_ : first_;
    if (bench_.readable) bench_.system = next;
    steps_ += " reload " + std::to_string(which);
    const Before before = now();
    const auto conditions = bench_.gates().conditions(bench_.state().system().networks.size());
    const auto answer = bench_.ask(control::ReloadRequest{});
    demand(now() == before, "a reload that was begun has changed something");
    bench_.reading().finish();
    bench_.readable = true;
    const bool lost = std::ranges::any_of(bench_.commits, [](const auto& c) { return !c; });
    take_commits();
    ++tally.reloads;
    const auto slice = answer.slices ? answer.slices() : std::nullopt;
    demand(slice.has_value(), "a reload is not answered");
    if (slice && std::holds_alternative<control::Error>(slice->body)) {
      steps_ += " (" + std::get<control::Error>(slice->body).message + ")";
      // To be tried again is a chance for whatever the kernel had refused before.
      demand(lost || now() == before || conditions != bench_.gates().conditions(conditions.size()),
             "a reload that was refused has changed something");
      bench_.system = in_force_;
    } else {
      in_force_ = bench_.system;
    }
  }

  void change_links() {
    const std::string& name = first_.networks[below(random_, first_.networks.size())].name;
    const auto known = bench_.kernel.interfaces.find(name);
    steps_ += " link " + name;
    if (known == bench_.kernel.interfaces.end())
      bench_.kernel.plug(name);
    else if (chance(random_, 40))
      bench_.kernel.unplug(name);
    else if (chance(random_, 70))
      known->second.up = !known->second.up;
    else
      known->second.bitrate = known->second.bitrate == 0 ? 50'000 : 0;
    if (chance(random_, 20) && known != bench_.kernel.interfaces.end() &&
        bench_.kernel.interfaces.contains(name)) {
      bench_.kernel.unplug(name);  // and another one of that name
      bench_.kernel.plug(name);
    }
    bench_.daemon().links_changed();
  }

  /// Sometimes longer than the grace, without a heart-beat.
  void pass_time() {
    const std::uint64_t passed = chance(random_, 40) ? 40 * kSecond : kSecond;
    steps_ += " time " + std::to_string(passed / kSecond);
    bench_.clock.monotonic += passed;
    bench_.clock.wall += (below(random_, 7200) * kSecond);
    bench_.clock.wall -= 3600 * kSecond;
    bench_.kernel.advance_to(bench_.clock.monotonic);
    bench_.daemon().beat();
    round();
    if (passed <= kSecond || trouble_) return;
    for (const auto& [id, request] : granted_)
      demand((request.lease_ns == 0 && !request.hold) || !sessions_[id].empty(),
             "admission " + std::to_string(id) + " has outlived its lease");
  }

  void round() {
    settled_ = false;
    steps_ += " round";
    for (const auto& [id, request] : granted_)
      if (request.lease_ns != 0 || request.hold) perhaps_gone_.insert(id);
    bench_.daemon().begin_round();
    for (int i = 0; i < 1'000 && bench_.daemon().has_work(); ++i) bench_.daemon().work();
    demand(!bench_.daemon().has_work(), "a round has no end");
    take_commits();
    if (!trouble_ && !unsure_disk_) perhaps_gone_.clear();
    const auto recorded = held_.empty() ? bench_.recorded(power_) : store::Contents{};
    if (!held_.empty()) return;
    std::erase_if(granted_, [&](const auto& known) {
      if (recorded.admissions.find(known.first) != nullptr ||
          bench_.state().admissions().contains(known.first))
        return false;
      demand((known.second.lease_ns != 0 || known.second.hold) && sessions_[known.first].empty(),
             "an admission without a lease has ended");
      ++tally.expired;
      return true;
    });
  }

  void end_session() {
    const auto session = 1 + below(random_, 3);
    steps_ += " session " + std::to_string(session) + " ends";
    bench_.daemon().session_closed(session);
    for (auto& [id, holders] : sessions_) holders.erase(session);
  }

  /// Another program removes a gate.
  void lose_gate() {
    if (bench_.kernel.gates.empty()) return;
    steps_ += " gate lost";
    bench_.kernel.gates.erase(bench_.kernel.gates.begin());
    round();
  }

  // --- ends and beginnings -----------------------------------------------------------------------

  void stop() {
    steps_ += " stop";
    try {
      bench_.daemon().stop();
      take_commits();
      demand(!bench_.kernel.open, "a daemon that was stopped has left the gates open");
    } catch (const store::test::PowerLoss&) {
    } catch (const Killed&) {
    }
    end_trouble();
    crash();
    if (wrong_.empty()) check();
  }
};

TEST(StateMachine, WhateverHappensTheGatesHoldWhatIsGrantedAndTheDiskWhatWasAnswered) {
  const std::uint64_t sets =
      play_histories(kSets, tally, [](std::uint64_t seed) { return Machine(seed).run(); });
  EXPECT_GE(tally.steps, sets);
  std::printf(
      "%llu steps: %llu admitted, %llu refused, %llu failed, %llu lost, %llu released, %llu "
      "expired, %llu reloads, %llu starts, %llu crashes\n",
      static_cast<unsigned long long>(tally.steps), static_cast<unsigned long long>(tally.admitted),
      static_cast<unsigned long long>(tally.refused), static_cast<unsigned long long>(tally.failed),
      static_cast<unsigned long long>(tally.lost), static_cast<unsigned long long>(tally.released),
      static_cast<unsigned long long>(tally.expired),
      static_cast<unsigned long long>(tally.reloads),
      static_cast<unsigned long long>(tally.restarts),
      static_cast<unsigned long long>(tally.crashes));
}

}  // namespace
}  // namespace mlcca::test
