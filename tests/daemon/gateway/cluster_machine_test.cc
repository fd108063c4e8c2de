// SPDX-License-Identifier: BSD-2-Clause
// Whatever happens to two gateways that share a bus, to their store, disks and kernels: the gates
// hold what is granted or deny, both together never pass more than the bus carries, nothing leased
// passes when the lease may have ended, what was answered is on disk, and when all is well again
// both agree and the store has nothing that nobody holds. SETS random histories (as many as the
// environment says) from the seed SEED on, shared among a process for each CPU.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "daemon/cluster/record_codec.hpp"
#include "tests/core/admission/bounds.hpp"
#include "tests/daemon/gateway/held.hpp"
#include "tests/daemon/gateway/histories.hpp"
#include "tests/daemon/gateway/members_rollout.hpp"

namespace mlcca::test {
namespace {

constexpr std::uint64_t kClusterSets = 5'000;
constexpr std::size_t kGateways = 2;
constexpr std::size_t kMostActions = 24;
constexpr std::uint64_t kWholeBus = 1'000'000;       // 1e-6 of its time
constexpr std::uint64_t kFrameTime = 1'080'000;      // ns, of 8 bytes at 125 kbit/s
constexpr std::uint64_t kToleranceOfClocks = 1'000;  // 1e-6, of what the gates police
constexpr int kMostTurns = 5'000;                    // until nothing is left to do
constexpr std::string_view kAskedInStore = "/mlcca/pair/x/";

/// How often things happened: a test in which nothing does would prove little.
struct ClusterTally {
  std::uint64_t steps = 0, admitted = 0, shared = 0, refused = 0, failed = 0, released = 0;
  std::uint64_t rollouts = 0, starts = 0, crashes = 0, stops = 0, emptied = 0, both = 0;
  std::uint64_t grants = 0;     ///< in the store
  std::uint64_t most_load = 0;  ///< 1e-6 of the time of the bus

  ClusterTally& operator+=(const ClusterTally& other) {
    for (const auto field :
         {&ClusterTally::steps, &ClusterTally::admitted, &ClusterTally::shared,
          &ClusterTally::refused, &ClusterTally::failed, &ClusterTally::released,
          &ClusterTally::rollouts, &ClusterTally::starts, &ClusterTally::crashes,
          &ClusterTally::stops, &ClusterTally::emptied, &ClusterTally::both, &ClusterTally::grants})
      this->*field += other.*field;
    most_load = std::max(most_load, other.most_load);
    return *this;
  }
};
ClusterTally cluster_tally;

struct PendingAnswer {
  std::size_t gateway = 0;
  control::Admit request;
  serve::NextSlice slices;
};

/// What a gateway had before a request that is to change nothing.
struct ServiceBefore {
  std::string service;
  std::map<core::AdmissionId, std::size_t> admissions;
  std::vector<Value> reserved;
  bool operator==(const ServiceBefore&) const = default;
};

/// What its clients know of a gateway.
struct ClientsOf {
  std::map<std::string, control::Admit> granted;  ///< by key, as answered
  std::map<std::string, control::Admit> held;     ///< answered when the disk has it
  std::set<std::string> refused;                  ///< as answered
  std::set<std::string> unsure;                   ///< the answer was lost, or trouble met it
  bool troubled = false;                          ///< disk or kernel refuse now
};

class ClusterMachine : public MembershipBench {
 public:
  explicit ClusterMachine(std::uint64_t seed)
      : MembershipBench(with_a_described_publisher()),
        random_(seed),
        power_(static_cast<std::uint32_t>(seed)) {
    core::System grown = with_a_described_publisher();
    core::Subscriber s = grown.subscribers.front();
    s.name = "s2";
    s.channel = 2;
    grown.subscribers.push_back(s);
    core::System renamed = grown;
    renamed.name = "other";
    for (auto& node : nodes)
      node->bench.handed_on = {
          {1, with_a_described_publisher()}, {2, grown}, {3, grown}, {4, renamed}};
  }
  void TestBody() override {}

  /// What went wrong; empty: nothing.
  std::string run_history() {
    for (std::size_t g = 0; g < kGateways; ++g) start_gateway(g);
    if (chance(random_, 90)) pass_time(4 * kSecondNs, kStepNs);
    for (std::size_t i = 6 + below(random_, kMostActions - 6); i > 0 && wrong_.empty(); --i) step();
    if (wrong_.empty()) recover();
    return wrong_.empty() ? "" : wrong_ + "\n  after:" + steps_;
  }

 private:
  void demand(bool holds, const std::string& otherwise) {
    if (!holds && wrong_.empty()) wrong_ = otherwise;
  }
  [[nodiscard]] static std::string name(std::size_t g) { return "g" + std::to_string(g); }
  bool acts(std::size_t g) { return at(g).runs() && !nodes[g]->hangs; }

  // --- steps -------------------------------------------------------------------------------------

  void step() {
    ++cluster_tally.steps;
    const std::size_t g = below(random_, kGateways);
    if (acts(g) && chance(random_, 25)) make_trouble(g);
    guarded(g, [&] { take_step(g); });
    if (chance(random_, 80)) settle();
    if (chance(random_, 40)) pass_time((1 + below(random_, 12)) * kStepNs, kStepNs);
    end_trouble(g);
    settle();
    check();
  }

  void take_step(std::size_t g) {
    if (!acts(g)) return chance(random_, 60) ? bring_back(g) : change_store(g);
    using Step = void (ClusterMachine::*)(std::size_t);
    using M = ClusterMachine;
    // How many of 28 steps are of the kind.
    static constexpr std::array<std::pair<std::size_t, Step>, 13> kinds{{{11, &M::admit},
                                                                         {1, &M::query},
                                                                         {3, &M::release},
                                                                         {1, &M::withdraw},
                                                                         {1, &M::reload},
                                                                         {1, &M::roll_out_some},
                                                                         {2, &M::change_link},
                                                                         {3, &M::change_store},
                                                                         {1, &M::wait_long},
                                                                         {1, &M::drain_or_join},
                                                                         {1, &M::die},
                                                                         {1, &M::stop},
                                                                         {1, &M::hang}}};
    std::size_t at = below(random_, 28);
    for (const auto& [many, step] : kinds) {
      if (at < many) return (this->*step)(g);
      at -= many;
    }
  }

  void hang(std::size_t g) {
    steps_ += " " + name(g) + " hangs";
    nodes[g]->hangs = true;
  }

  [[nodiscard]] control::Admit some_request(std::size_t g) {
    // Two of the shortest do not fit on the bus, nor do most groups of three.
    constexpr std::array<std::uint64_t, 6> periods{2, 2, 3, 4, 5, 20};
    const std::string own = "own" + std::to_string(g);
    const std::string others = "own" + std::to_string(1 - g);
    const std::array<std::string, 6> places{"shared", "shared", others, others, name(g), own};
    control::Admit request;
    request.key = name(g) + "-k" + std::to_string(++keys_);
    // Two senders of one identifier are no system; so mostly each gateway has channels of its own.
    const bool publishes = chance(random_, 70);
    const std::array<std::array<std::size_t, 2>, kGateways> of_own{{{3, 5}, {1, 4}}};
    const std::size_t usual = publishes ? of_own[g][below(random_, 2)] : 2 * below(random_, 2);
    request.channel = "c" + std::to_string(chance(random_, 85) ? usual : below(random_, 6));
    if (publishes) {
      request.from = own;
      request.publisher = own + "-" + request.key;
      request.offered = {attribute_of("Period", periods[below(random_, periods.size())] * kMs),
                         attribute_of("MaxPayload", 8)};
    }
    if (request.from.empty() || chance(random_, 85)) {
      request.to = places[below(random_, places.size())];
      request.subscriber = "late-" + request.key;
    }
    if (chance(random_, 20)) request.lease_ns = (5 + below(random_, 15)) * kSecondNs;
    request.hold = chance(random_, 10);
    return request;
  }

  void admit(std::size_t g) {
    auto& clients = clients_[g];
    control::Admit request = some_request(g);
    if (!clients.granted.empty() && chance(random_, 10)) request = clients.granted.begin()->second;
    steps_ += " " + name(g) + " admit " + request.channel + " " + request.key + " " + request.from +
              ">" + request.to;
    clients.unsure.insert(request.key);  // until there is an answer
    const ServiceBefore before = now(g);
    auto answer = at(g).ask(request, member(1 + below(random_, 3)));
    if (answer.slices) {
      pending_.push_back({g, std::move(request), std::move(answer.slices)});
      return;
    }
    if (std::holds_alternative<control::Error>(answer.reply.body))
      demand(now(g) == before, "an admission that was answered by an error has changed something");
    take_answer(g, request, answer.reply.body, answer.held);
  }

  template <class Body>
  void take_answer(std::size_t g, const control::Admit& request, const Body& body, bool held) {
    auto& clients = clients_[g];
    const auto* const channels = std::get_if<control::Channels>(&body);
    if (channels == nullptr || channels->channels.empty()) {
      ++cluster_tally.failed;
      return;  // not answered: it may be there or not
    }
    const bool granted = std::ranges::all_of(channels->channels, &control::Channel::granted);
    if (!granted) {
      ++cluster_tally.refused;
      if (clients.troubled || clients.granted.contains(request.key)) return;
      clients.unsure.erase(request.key);
      clients.refused.insert(request.key);
      return;
    }
    steps_ += " (" + request.key + " granted)";
    if (held) {
      clients.held.emplace(request.key, request);
      return;
    }
    note_granted(g, request);
  }

  void note_granted(std::size_t g, const control::Admit& request) {
    auto& clients = clients_[g];
    ++cluster_tally.admitted;
    if (request.to == "shared" || request.to == "own" + std::to_string(1 - g))
      ++cluster_tally.shared;
    clients.unsure.erase(request.key);
    clients.granted.emplace(request.key, request);
  }

  void query(std::size_t g) {
    control::Query query;
    static_cast<control::ChannelRequest&>(query) = some_request(g);
    steps_ += " " + name(g) + " query";
    const ServiceBefore before = now(g);
    at(g).ask(query, outsider());
    demand(now(g) == before, "a query has changed something");
  }

  void release(std::size_t g) {
    auto& clients = clients_[g];
    if (clients.granted.empty()) return;
    auto it = clients.granted.begin();
    std::advance(it, below(random_, clients.granted.size()));
    const std::string key = it->first;
    steps_ += " " + name(g) + " release " + key;
    const ServiceBefore before = now(g);
    clients.unsure.insert(key);
    const auto answer =
        at(g).ask(control::ReleaseRequest{.channel = {}, .admission = 0, .key = key});
    const bool done = !std::holds_alternative<control::Error>(answer.reply.body);
    if (!done) {
      demand(now(g) == before, "a release that was answered by an error has changed something");
      return;
    }
    ++cluster_tally.released;
    clients.granted.erase(key);
    if (clients.troubled) return;
    clients.unsure.erase(key);
    clients.refused.insert(key);
  }

  void withdraw(std::size_t g) {
    const std::string channel = "c" + std::to_string(below(random_, 6));
    const bool away = chance(random_, 50);
    steps_ += " " + name(g) + (away ? " withdraw " : " reinstate ") + channel;
    const ServiceBefore before = now(g);
    const auto answer = away ? at(g).ask(control::WithdrawRequest{channel})
                             : at(g).ask(control::ReinstateRequest{channel});
    if (std::holds_alternative<control::Error>(answer.reply.body))
      demand(now(g) == before, "a withdrawal that failed has changed something");
  }

  /// Of the file as it is, of one that cannot be read, or of another one than the one in force.
  void reload(std::size_t g) {
    const std::size_t which = below(random_, 4);
    steps_ += " " + name(g) + " reload " + std::to_string(which);
    const ServiceBefore before = now(g);
    at(g).readable = which != 0;
    if (which == 1) {
      at(g).digest = 3;
      at(g).system = at(g).handed_on.at(3);
    }
    const auto answer = at(g).ask(control::ReloadRequest{});
    if (!at(g).reading().busy()) return;
    at(g).reading().finish();
    at(g).readable = true;
    const auto slice = answer.slices ? answer.slices() : std::nullopt;
    if (which == 0) demand(now(g) == before, "a reload that was refused has changed something");
    if (slice && std::holds_alternative<control::Error>(slice->body)) steps_ += " (refused)";
  }

  void roll_out_some(std::size_t g) {
    control::RolloutRequest request;
    const std::size_t which = below(random_, 8);
    if (which == 0)
      request.back = true;
    else if (which == 1)
      request.accept = true;
    else
      request.part = std::array{"1", "2", "2", "3", "4", "9"}[which - 2];
    if (request.accept) request.part.clear();
    if (chance(random_, 20)) request.without = {name(1 - g)};
    at(g).texts.full = chance(random_, 10);
    steps_ += " " + name(g) + " rollout " + std::to_string(which);
    if (!request.without.empty()) steps_ += " without the other";
    at(g).ask(request);
    ++cluster_tally.rollouts;
  }

  void change_link(std::size_t g) {
    const std::string network = chance(random_, 50) ? "shared" : "own" + std::to_string(g);
    steps_ += " " + name(g) + " link " + network;
    auto& kernel = at(g).kernel;
    const auto known = kernel.interfaces.find(network);
    if (known == kernel.interfaces.end())
      kernel.plug(network);
    else if (chance(random_, 50))
      kernel.unplug(network);
    else
      known->second.up = !known->second.up;
    if (chance(random_, 20) && !kernel.gates.empty()) {
      steps_ += " gate lost";
      kernel.gates.erase(kernel.gates.begin());
      at(g).round();
    }
    at(g).daemon().links_changed();
  }

  /// For either gateway, whichever one has its turn.
  void change_store(std::size_t) {
    const std::size_t g = below(random_, kGateways);
    auto& its = link(g);
    switch (below(random_, 8)) {
      case 0:
        its.up = false;
        steps_ += " store gone for " + name(g);
        break;
      case 1:
        for (std::size_t n = 0; n < kGateways; ++n) link(n).up = false;
        steps_ += " store gone";
        break;
      case 2:
        its.answers = !its.answers;
        steps_ += its.answers ? " store answers " : " store is slow for ";
        steps_ += name(g);
        break;
      case 3:
        its.lost = chance(random_, 50) ? FakeLink::Lost::done : FakeLink::Lost::not_done;
        steps_ += " answers are lost for " + name(g);
        break;
      case 4:
        its.read_again();
        steps_ += " compacted for " + name(g);
        break;
      case 5:
        if (chance(random_, 25)) empty_store();
        break;
      default:
        steps_ += " store is well";
        mend_store();
    }
  }

  void mend_store() {
    for (std::size_t n = 0; n < kGateways; ++n) {
      link(n).up = link(n).answers = true;
      link(n).lost = FakeLink::Lost::none;
    }
  }

  void empty_store() {
    ++cluster_tally.emptied;
    steps_ += " store emptied";
    store = FakeStore{};
    read_ = 0;
    read_entries_.clear();
    for (std::size_t n = 0; n < kGateways; ++n) link(n).read_again();
  }

  /// Time passes, and perhaps longer than a lease or what the kernel waits for a heart-beat.
  void wait_long(std::size_t g) {
    steps_ += " time";
    at(g).clock.wall += below(random_, 7200) * kSecondNs;
    at(g).clock.wall -= 3600 * kSecondNs;
    pass_time((1 + below(random_, 20)) * kSecondNs, 2 * kStepNs);
    const auto session = 1 + below(random_, 3);
    if (acts(g)) at(g).daemon().session_closed(session);
  }

  void drain_or_join(std::size_t g) {
    const bool away = chance(random_, 50);
    steps_ += " " + name(g) + (away ? " drain" : " join");
    if (away)
      at(g).ask(control::DrainRequest{.gateway = {}, .until_restart = chance(random_, 50)});
    else
      at(g).ask(control::JoinRequest{});
  }

  // --- trouble, ends and beginnings --------------------------------------------------------------

  void make_trouble(std::size_t g) {
    using store::test::Trouble;
    const std::size_t first = 1 + below(random_, 8);
    const std::size_t many = 1 + below(random_, 3);
    clients_[g].troubled = true;
    switch (below(random_, 8)) {
      case 0:
      case 1:
        steps_ += " [disk]";
        at(g).disk().trouble(std::array{Trouble::fail, Trouble::fail_after, Trouble::lose,
                                        Trouble::write_part}[below(random_, 4)],
                             first, ENOSPC, many);
        break;
      case 2:
        steps_ += " [power]";
        at(g).disk().trouble(chance(random_, 50) ? Trouble::stop : Trouble::stop_after, first, 0);
        break;
      case 3:
        steps_ += " [killed]";
        at(g).kernel.calls.kill(first);
        break;
      default:
        steps_ += " [kernel]";
        at(g).kernel.calls.refuse(first, many);
    }
  }
  void end_trouble(std::size_t g) {
    clients_[g].troubled = false;
    at(g).kernel.calls.relent();
    at(g).disk().trouble(store::test::Trouble::fail, 1, 0, 0);
  }

  template <class Do>
  void guarded(std::size_t g, const Do& what) {
    try {
      what();
    } catch (const store::test::PowerLoss&) {
      crash(g);
    } catch (const Killed&) {
      crash(g);
    }
  }

  /// Nobody gets the answers that were held.
  void forget_answers(std::size_t g) {
    auto& clients = clients_[g];
    for (const auto& [key, request] : clients.held) clients.unsure.insert(key);
    clients.held.clear();
    std::erase_if(pending_, [&](const PendingAnswer& p) { return p.gateway == g; });
    at(g).commits.clear();
  }

  void crash(std::size_t g) {
    ++cluster_tally.crashes;
    steps_ += " " + name(g) + " crashes";
    end_trouble(g);
    at(g).lose_power(power_);
    at(g).readable = true;
    forget_answers(g);
  }

  void die(std::size_t g) {
    steps_ += " " + name(g) + " dies";
    if (chance(random_, 50)) return crash(g);
    at(g).end();
    forget_answers(g);
  }

  void stop(std::size_t g) {
    ++cluster_tally.stops;
    steps_ += " " + name(g) + " stop";
    bool may = at(g).daemon().begin_stop();
    for (int n = 0; n < 60 && !may && acts(g); ++n) {
      pass_time(kStepNs, kStepNs);
      may = acts(g) && at(g).daemon().may_stop();
    }
    if (!acts(g)) return;
    demand(may, "a gateway does not end within 6 s");
    at(g).daemon().stop();
    take_commits(g);
    demand(!at(g).kernel.open, "a daemon that was stopped has left the gates open");
    at(g).end();
    forget_answers(g);
  }

  void bring_back(std::size_t g) {
    if (at(g).runs()) {
      steps_ += " " + name(g) + " acts again";
      nodes[g]->hangs = false;
      return;
    }
    if (chance(random_, 30)) {
      make_trouble(g);
      start_gateway(g);
      end_trouble(g);
    }
    if (!at(g).runs()) start_gateway(g);
  }

  /// What a start takes, the other gateway and its kernel live through, too.
  void start_gateway(std::size_t g) {
    ++cluster_tally.starts;
    steps_ += " " + name(g) + " start";
    const bool troubled = clients_[g].troubled;
    const std::uint64_t begun = at(g).clock.monotonic;
    nodes[g]->hangs = false;
    bool started = false;
    std::string why;
    guarded(g, [&] {
      const auto failure = at(g).start();
      started = !failure;
      if (failure && !failure->lines.empty()) why = failure->lines.front();
    });
    at(g).kernel.advance_to(at(g).clock.monotonic);
    auto& other = nodes[1 - g]->bench;
    other.clock.monotonic += at(g).clock.monotonic - begun;
    other.kernel.advance_to(other.clock.monotonic);
    at(g).commits.clear();  // of the start itself
    if (started) return;
    demand(troubled, "it does not start: " + why);
    at(g).end();
    demand(!at(g).kernel.passes() || !at(g).kernel.open || troubled, "a failed start leaves open");
  }

  // --- turns and time ----------------------------------------------------------------------------

  void take_commits(std::size_t g) {
    auto& clients = clients_[g];
    for (const Result<void>& done : std::exchange(at(g).commits, {})) {
      for (const auto& [key, request] : clients.held)
        if (done)
          note_granted(g, request);
        else
          clients.unsure.insert(key);
      clients.held.clear();
    }
  }

  void take_pending(std::size_t g) {
    for (std::size_t i = 0; i < pending_.size() && acts(g);) {
      if (pending_[i].gateway != g) {
        ++i;
        continue;
      }
      const auto slice = pending_[i].slices();
      if (!slice) {
        ++i;
        continue;
      }
      const control::Admit request = pending_[i].request;
      pending_.erase(pending_.begin() + static_cast<std::ptrdiff_t>(i));
      take_answer(g, request, slice->body, false);
    }
  }

  bool turn(std::size_t g) {
    bool more = link(g).deliver();
    const std::size_t sent = link(g).sent.size();
    at(g).act();
    take_commits(g);
    if (at(g).reading().busy()) {
      at(g).reading().finish();
      more = true;
    }
    take_pending(g);
    return more || (link(g).answers && link(g).sent.size() != sent);
  }

  void settle() {
    bool more = true;
    for (int turns = 0; more; ++turns) {
      more = false;
      for (std::size_t g = 0; g < kGateways; ++g)
        if (acts(g)) guarded(g, [&] { more = turn(g) || more; });
      demand(turns < kMostTurns, "it never comes to rest");
      if (!wrong_.empty()) return;
    }
  }

  void pass_time(std::uint64_t time, std::uint64_t step) {
    for (std::uint64_t gone = 0; gone < time && wrong_.empty(); gone += step) {
      passed_ += step;
      for (std::size_t g = 0; g < kGateways; ++g) {
        at(g).clock.monotonic += step;
        at(g).kernel.advance_to(at(g).clock.monotonic);
      }
      check_medium();
      for (std::size_t g = 0; g < kGateways; ++g)
        if (acts(g))
          guarded(g, [&] {
            at(g).daemon().beat();
            if (passed_ % kSecondNs < step) at(g).round();
          });
      settle();
      check_medium();
    }
  }

  // --- what must hold ----------------------------------------------------------------------------

  ServiceBefore now(std::size_t g) {
    const core::State& state = at(g).state();
    ServiceBefore out{core::testing::service(state), state.admissions(), {}};
    for (std::size_t r = 0; r < state.system().resources(); ++r)
      out.reserved.push_back(state.ledger().reserved(r));
    return out;
  }

  const FakeGate* gate_on(std::size_t g, const std::string& network) {
    const auto& kernel = at(g).kernel;
    const auto found = kernel.interfaces.find(network);
    if (found == kernel.interfaces.end() || !found->second.up || !kernel.passes()) return nullptr;
    const auto gate = kernel.gates.find(found->second.ifindex);
    return gate == kernel.gates.end() ? nullptr : &gate->second;
  }

  /// What the gates of a gateway let pass to the shared bus, 1e-6 of its time.
  std::uint64_t load_of(std::size_t g) {
    const FakeGate* const gate = gate_on(g, "shared");
    if (gate == nullptr) return 0;
    const FakeGate* const own = gate_on(g, "own" + std::to_string(g));
    std::uint64_t load = 0;
    std::set<core::Subject> counted;
    for (const auto& [entry, rule] : gate->rules) {
      if (!rule.pass || entry.direction != core::Direction::egress || entry.from_kernel) continue;
      Value period = rule.policing.per_frame;
      if (entry.source_port && own != nullptr && counted.insert(entry.subject).second)
        for (const auto& [in, of] : own->rules)
          if (of.pass && in.direction == core::Direction::ingress && in.subject == entry.subject)
            period = of.policing.per_frame;
      if (period != 0) load += kFrameTime * kWholeBus / period;
    }
    return load;
  }

  void check_medium() {
    std::uint64_t load = 0;
    std::size_t sending = 0;
    for (std::size_t g = 0; g < kGateways; ++g) {
      const std::uint64_t one = load_of(g);
      load += one;
      sending += one != 0 ? 1 : 0;
      check_lease(g);
    }
    if (sending == kGateways) ++cluster_tally.both;
    cluster_tally.most_load = std::max(cluster_tally.most_load, load);
    demand(load <= kWholeBus + kToleranceOfClocks,
           "both together pass more than the bus carries: " + std::to_string(load));
  }

  static bool is_described(core::Subject subject) { return subject == 1 || subject == 3; }

  /// c0, and c2 by another description, need no lease.
  void check_lease(std::size_t g) {
    const FakeGate* const gate = gate_on(g, "shared");
    if (gate == nullptr || at(g).clock.monotonic < link(g).leased_from + kLease) return;
    for (const auto& [entry, rule] : gate->rules)
      demand(!rule.pass || entry.direction != core::Direction::egress || entry.from_kernel ||
                 is_described(entry.subject),
             name(g) + " passes subject " + std::to_string(entry.subject) +
                 " although its lease may have ended");
  }

  /// What is reserved in the store fits the bus. Entries of one admission are for the same traffic:
  /// one that ends may still be there when the next one is prepared.
  void check_store() {
    std::map<std::tuple<std::string, core::AdmissionId, std::string>, std::uint64_t> loads;
    const std::string prefix = "/mlcca/pair/r/shared/";
    for (const auto& [key, entry] : store.entries) {
      if (!key.starts_with(prefix)) continue;
      const auto taken = codec_.taken(entry.value, kSharedBus);
      if (!taken) continue;
      const std::string gateway = key.substr(prefix.size(), key.rfind('/') - prefix.size());
      for (const auto& one : taken->part.bus)
        if (one.source.admission != 0) {
          auto& load = loads[{gateway, one.source.admission, taken->channel}];
          load = std::max(load, static_cast<std::uint64_t>(one.message.transmission) * kWholeBus /
                                    static_cast<std::uint64_t>(one.message.period));
        }
    }
    std::uint64_t load = 0;
    for (const auto& [of, one] : loads) load += one;
    demand(load <= kWholeBus, "more is reserved than the bus carries: " + std::to_string(load));
  }

  /// Whether all gateways that an admission in the store needs have agreed to it by then.
  [[nodiscard]] bool is_agreed_by_all(const core::cluster::Entry& entry,
                                      const core::cluster::RouteRequest& asked) const {
    const std::string of = entry.key.substr(kAskedInStore.size());  // gateway/number
    return std::ranges::all_of(asked.gateways, [&](std::size_t g) {
      const auto there = read_entries_.find("/mlcca/pair/a/" + name(g) + '/' + of);
      const auto vote =
          there == read_entries_.end() ? std::nullopt : codec_.vote(there->second.value);
      return vote && vote->vote.ok && vote->asked == entry.create;
    });
  }

  /// Nothing is granted in the store before the latest votes of all gateways on its way are for it.
  void check_grants() {
    for (; read_ < store.log.size(); ++read_) {
      for (const core::cluster::Entry& entry : store.log[read_].entries) {
        if (entry.gone || !entry.key.starts_with(kAskedInStore)) continue;
        const auto asked = codec_.asked(entry.value);
        const auto former = read_entries_.find(entry.key);
        const auto was =
            former == read_entries_.end() ? std::nullopt : codec_.asked(former->second.value);
        if (!asked || asked->stage != core::cluster::Stage::granted ||
            (was && was->stage == core::cluster::Stage::granted))
          continue;
        demand(is_agreed_by_all(entry, *asked), entry.key + " is granted without all votes");
        ++cluster_tally.grants;
      }
      for (const core::cluster::Entry& entry : store.log[read_].entries)
        read_entries_.insert_or_assign(entry.key, entry);  // gone: without a value
    }
  }

  void check() {
    if (!wrong_.empty()) return;
    check_medium();
    check_store();
    check_grants();
    for (std::size_t g = 0; g < kGateways; ++g) {
      if (!acts(g)) continue;
      const std::string gate = wrong_gate(at(g));
      demand(gate.empty(), name(g) + ": " + gate);
      if (chance(random_, 30)) check_disk(g);
    }
  }

  /// A subscriber of a publisher that the other gateway has admitted ends with it.
  static bool ends_by_itself(const control::Admit& request) {
    return request.lease_ns != 0 || request.hold || request.from.empty();
  }

  void check_disk(std::size_t g) {
    auto& clients = clients_[g];
    std::set<std::string> there;
    for (const control::Request& r : at(g).recorded(power_).admissions) {
      const std::string& key = std::get<control::Admit>(r.body).key;
      there.insert(key);
      demand(!clients.refused.contains(key) || clients.unsure.contains(key),
             name(g) + ": " + key + " was refused or released, and is on disk");
    }
    std::erase_if(clients.granted, [&](const auto& known) {
      if (there.contains(known.first)) return false;
      demand(ends_by_itself(known.second) || clients.unsure.contains(known.first),
             name(g) + ": " + known.first + " was answered and is not on disk");
      return true;
    });
  }

  // --- the end -----------------------------------------------------------------------------------

  std::string phase(std::size_t g) {
    const auto body = at(g).ask(control::ClusterRequest{}).reply.body;
    const auto* const cluster = std::get_if<control::Cluster>(&body);
    return cluster == nullptr ? "no answer" : cluster->phase;
  }

  void mend_machine(std::size_t g) {
    end_trouble(g);
    auto& bench = at(g);
    bench.texts.full = false;
    bench.readable = true;
    for (const std::string& network : {std::string("shared"), "own" + std::to_string(g)}) {
      if (!bench.kernel.interfaces.contains(network)) bench.kernel.plug(network);
      bench.kernel.interfaces.at(network).up = true;
    }
    nodes[g]->hangs = false;
    if (!bench.runs()) start_gateway(g);
    if (bench.runs()) bench.daemon().links_changed();
  }

  /// An operator does what the state of a gateway asks for.
  void operate(std::size_t g) {
    const std::string how = phase(g);
    if (how == "drained" || how == "draining") at(g).ask(control::JoinRequest{});
    if (how == "gone-back" && !epoch_written_) {
      epoch_written_ = true;
      store.write({{.key = "/mlcca/pair/e", .value = std::string(16, 'n')}});
    }
    if (how == "description-pending" && at(g).digest != 1) {
      at(g).digest = 1;
      at(g).system = with_a_described_publisher();
      at(g).ask(control::ReloadRequest{});
    }
    if (how == "other-description") {
      control::RolloutRequest request;
      request.accept = true;
      at(g).ask(request);
    }
  }

  void recover() {
    steps_ += " all is well";
    mend_store();
    for (std::size_t g = 0; g < kGateways; ++g) mend_machine(g);
    std::array<std::string, kGateways> how;
    bool all_in = false;
    for (int n = 0; n < 80 && !all_in && wrong_.empty(); ++n) {
      pass_time(4 * kSecondNs, 5 * kStepNs);
      if (!wrong_.empty()) return;
      all_in = true;
      for (std::size_t g = 0; g < kGateways; ++g) {
        how[g] = phase(g);
        all_in = all_in && how[g] == "in";
        operate(g);
      }
    }
    demand(all_in, "all is well, and a gateway is no member: " + how[0] + ", " + how[1]);
    // A withdrawal is of one gateway alone: the other one does not know of it.
    for (std::size_t g = 0; g < kGateways; ++g)
      for (std::size_t c = 0; c < 6; ++c)
        at(g).ask(control::ReinstateRequest{"c" + std::to_string(c)});
    pass_time(45 * kSecondNs, 5 * kStepNs);
    if (!wrong_.empty()) return;
    check();
    check_agreed();
    for (std::size_t g = 0; g < kGateways && wrong_.empty(); ++g) check_disk(g);
    if (wrong_.empty()) give_all_back();
  }

  /// Deliveries from the own bus of one gateway to that of the other one.
  std::set<std::pair<core::Subject, std::string>> across(std::size_t g, std::size_t from) {
    std::set<std::pair<core::Subject, std::string>> all;
    const core::State& state = at(g).state();
    const std::string own = "own" + std::to_string(from);
    const std::string to = "own" + std::to_string(1 - from);
    for (std::size_t c = 0; c < state.decisions().size(); ++c)
      for (const auto& d : state.grants(c).deliveries)
        if (d.to == to && (d.publisher.starts_with(own) || (from == 0 && d.publisher[0] == 'p')))
          all.emplace(state.system().channels[c].subject, d.publisher);
    return all;
  }

  static std::string text_of(const std::set<std::pair<core::Subject, std::string>>& all) {
    std::string text;
    for (const auto& [subject, publisher] : all)
      text += " " + publisher + " of subject " + std::to_string(subject);
    return text.empty() ? " nothing" : text;
  }

  /// What the gateway of a publisher grants over the other one, that one grants as well, and
  /// nothing else.
  void check_agreed() {
    for (std::size_t from = 0; from < kGateways; ++from)
      demand(across(1 - from, from) == across(from, from),
             "from own" + std::to_string(from) + " its gateway grants" +
                 text_of(across(from, from)) + ", and the other one" +
                 text_of(across(1 - from, from)));
    demand(at(0).daemon().scene().digest == at(1).daemon().scene().digest,
           "they have different descriptions");
    demand(pending_.empty(), "a request has no answer");
  }

  void give_all_back() {
    steps_ += " give all back";
    for (std::size_t g = 0; g < kGateways; ++g) {
      clients_[g].granted.clear();
      for (const control::Request& r : at(g).recorded(power_).admissions)
        at(g).ask(control::ReleaseRequest{
            .channel = {}, .admission = 0, .key = std::get<control::Admit>(r.body).key});
    }
    pass_time(12 * kSecondNs, 5 * kStepNs);
    if (!wrong_.empty()) return;
    for (const char* kind : {"r/", "x/", "a/"})
      demand(entries(kind) == 0, std::string("the store has what nobody holds: ") + kind);
    for (std::size_t g = 0; g < kGateways; ++g) {
      demand(at(g).state().admissions().empty(), "an admission is left at " + name(g));
      demand(at(g).recorded(power_).admissions.empty(),
             "an admission is on the disk of " + name(g));
    }
    check();
    demand(passes(0, 0), "what is described does not pass when all is well");
  }

  Random random_;
  std::mt19937 power_;
  std::array<ClientsOf, kGateways> clients_;
  std::vector<PendingAnswer> pending_;
  cluster::RecordCodec codec_{with_a_described_publisher(), core::cluster::Digest{1}};
  std::size_t read_ = 0;  ///< of the log of the store
  std::map<std::string, core::cluster::Entry> read_entries_;
  std::uint64_t keys_ = 0;
  std::uint64_t passed_ = 0;
  bool epoch_written_ = false;
  std::string steps_;
  std::string wrong_;
};

TEST(ClusterMachine, WhateverHappensBothGatewaysKeepWhatTheyPromiseTogether) {
  const std::uint64_t sets = play_histories(kClusterSets, cluster_tally, [](std::uint64_t seed) {
    return ClusterMachine(seed).run_history();
  });
  EXPECT_GE(cluster_tally.steps, sets);
  const auto number = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  std::printf(
      "%llu steps: %llu admitted (%llu over the shared bus), %llu refused, %llu failed, %llu "
      "released, %llu rollouts, %llu starts, %llu crashes, %llu stops, %llu times an empty store, "
      "%llu grants in the store, %llu moments with both on the bus, at most %llu ppm of it\n",
      number(cluster_tally.steps), number(cluster_tally.admitted), number(cluster_tally.shared),
      number(cluster_tally.refused), number(cluster_tally.failed), number(cluster_tally.released),
      number(cluster_tally.rollouts), number(cluster_tally.starts), number(cluster_tally.crashes),
      number(cluster_tally.stops), number(cluster_tally.emptied), number(cluster_tally.grants),
      number(cluster_tally.both), number(cluster_tally.most_load));
}

}  // namespace
}  // namespace mlcca::test
