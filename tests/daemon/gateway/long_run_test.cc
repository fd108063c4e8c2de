// SPDX-License-Identifier: BSD-2-Clause
// An hour of a gateway in fast-forward: programs that announce and end, admissions with leases and
// keys, peers that subscribe, programs that carry events, links that change, reports and counters
// of the gates, samples of a mesh. Names, users, addresses and identifiers are others each time.
// What the daemon keeps does not grow.
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <variant>

#include "core/mesh/link_table.hpp"
#include "core/model/text.hpp"
#include "tests/daemon/gateway/bench.hpp"
#include "tests/daemon/store/worlds.hpp"

namespace mlcca::test {
namespace {

constexpr std::uint64_t kOneSecond = 1'000'000'000;
constexpr std::uint64_t kOneMinute = 60;               // s
constexpr std::size_t kRoom = std::size_t{96} << 10U;  // bytes that what is kept may fluctuate by
constexpr std::uint64_t kSessionLasts = 10;            // s
constexpr uid_t kLever = 1000;
constexpr uid_t kRelay = 990;
constexpr uid_t kSubscriptions = 991;
constexpr uid_t kFirstUser = 100'000;
constexpr std::size_t kLan = 2;

/// In use now, of all arenas and mappings; under a sanitizer it is 0.
std::size_t heap_in_use() {
  const auto now = ::mallinfo2();
  return now.uordblks + now.hblkhd;
}

/// The most that was kept in the first ten minutes, when all that has bounds has reached them, and
/// the least in the last ten.
class Kept {
 public:
  explicit Kept(std::uint64_t minutes) : minutes_(minutes) {}
  void at_minute(std::uint64_t minute, std::size_t bytes) {
    if (minute <= 10) most_before_ = std::max(most_before_, bytes);
    if (minute + 10 > minutes_) least_after_ = std::min(least_after_, bytes);
  }
  [[nodiscard]] std::size_t growth() const {
    return least_after_ - std::min(least_after_, most_before_);
  }

 private:
  std::uint64_t minutes_;
  std::size_t most_before_ = 0;
  std::size_t least_after_ = ~std::size_t{0};
};

/// c0 goes from a program and from a bus to a bus and to programs; c1 from the Ethernet to a bus.
core::System busy_system() {
  core::System system = small_system();
  system.gateways[0].relay = kRelay;
  for (core::Network& n : system.networks) n.provision.set(Attribute::omission, 0);
  system.gateways[0].provision.set(Attribute::omission, 0);
  system.subscribers[0].attributes.set(Attribute::omission, 6);
  core::Publisher lever;
  lever.name = "lever";
  lever.place = {core::Place::Kind::gateway, 0};
  lever.uid = kLever;
  lever.attributes = system.channels[0].attributes;
  system.publishers.push_back(lever);
  core::Subscriber lamp = system.subscribers[0];
  lamp.name = "lamp";
  lamp.place = lever.place;
  system.subscribers.push_back(lamp);
  core::Publisher far = system.publishers[0];
  far.name = "far";
  far.channel = 1;
  far.place = {core::Place::Kind::network, kLan};
  far.attributes = system.channels[1].attributes;
  system.publishers.push_back(far);
  core::Subscriber near = system.subscribers[0];
  near.name = "near";
  near.channel = 1;
  near.place = {core::Place::Kind::network, 0};
  system.subscribers.push_back(near);
  system.networks[kLan].subscriptions = {
      .accept = core::Subscribing::with_attributes, .most = 8, .origin = {}};
  for (core::Port& port : system.gateways[0].ports)
    if (port.network == kLan) port.control_uid = kSubscriptions;
  return system;
}

class BusyHour {
 public:
  BusyHour() : bench_(busy_system()), first_(bench_.system), second_(first_) {
    second_.networks[0].bus.bitrate = 250'000;
    second_.subscribers.pop_back();
    bench_.state_directory = history_.path();
    EXPECT_FALSE(bench_.start());
    // The bench would keep them.
    bench_.log().on_event([this](const control::Event& event) { ++happened_[event.kind]; });
  }

  void go_on_for(std::uint64_t seconds) {
    for (std::uint64_t i = 0; i < seconds; ++i) one_second();
  }
  /// Without the journal: a disk has room for it, and it is written again when it is large.
  [[nodiscard]] std::size_t heap() const {
    const std::size_t all = heap_in_use();
    return all - std::min(all, bench_.held_by_disk());
  }
  [[nodiscard]] std::uint64_t happened(const std::string& kind) const {
    const auto known = happened_.find(kind);
    return known == happened_.end() ? 0 : known->second;
  }
  [[nodiscard]] std::uint64_t answered() const { return answered_; }
  [[nodiscard]] std::size_t admissions() const { return bench_.state().admissions().size(); }

 private:
  static serve::Peer user(uid_t uid, std::uint64_t session) {
    return {.pid = 9, .uid = uid, .session = session};
  }
  template <class Body>
  serve::Answer ask(Body body, serve::Peer peer = member()) {
    serve::Answer answer = bench_.ask(std::move(body), std::move(peer));
    answered_ += std::holds_alternative<control::Error>(answer.reply.body) ? 0 : 1;
    return answer;
  }
  [[nodiscard]] bool each(std::uint64_t seconds, std::uint64_t at = 0) const {
    return now_ % seconds == at;
  }

  void one_second() {
    ++now_;
    bench_.clock.monotonic += kOneSecond;
    bench_.clock.wall += kOneSecond;
    bench_.kernel.advance_to(bench_.clock.monotonic);
    bench_.daemon().beat();
    programs();
    admissions_of_members();
    peers();
    carriers();
    gates();
    if (each(7)) links();
    operators();
    readers();
    bench_.round();
    bench_.act();
    if (now_ > kSessionLasts) bench_.daemon().session_closed(now_ - kSessionLasts);
    // What the fakes write down.
    bench_.commits.clear();
    bench_.kernel.order.clear();
    bench_.can.sent.clear();
  }

  /// A program that subscribes, and one that publishes.
  void programs() {
    control::AnnounceRequest lamp{"c0", control::Role::subscriber, "lamp", {}, address()};
    ask(lamp, user(kFirstUser + static_cast<uid_t>(now_), now_));
    lamp.local = address();  // its key changes
    ask(lamp, user(kFirstUser + static_cast<uid_t>(now_), now_));
    ask(control::AnnounceRequest{"c0", control::Role::publisher, "lever", {}}, user(kLever, now_));
    ask(control::AnnounceRequest{"c0", control::Role::publisher, name("none"), {}},
        user(kLever, now_));
  }

  /// An admission that is held by a connection, renewed, released, or that nobody renews.
  void admissions_of_members() {
    serve::Peer peer = member(now_);
    peer.uid = kFirstUser + static_cast<uid_t>(random_() % 100'000);
    control::Admit more = newcomer();
    more.channel = each(2) ? "c0" : "c1";
    more.publisher = name("p");
    more.subscriber = name("s");
    more.hold = each(4);
    if (each(3)) more.key = name("key");
    if (!more.hold) more.lease_ns = (5 + random_() % 10) * kOneSecond;
    if (each(5)) more.required = {{"Latency", 1, "ns", false}};  // nobody can
    const serve::Answer answer = ask(more, peer);
    if (each(6) && !more.key.empty()) ask(control::RenewRequest{0, more.key}, peer);
    if (each(9) && !more.key.empty()) ask(control::ReleaseRequest{"", 0, more.key}, peer);
    if (each(3, 1) && answer.owned != 0) ask(control::ReleaseRequest{"", answer.owned, ""}, peer);
    control::Admit unlisted = newcomer();
    unlisted.unlisted = true;
    unlisted.channel = core::format_subject(kUnlistedSubjects + random_() % 0x100'0000);
    unlisted.identifiers = {{"can0", 0x400U + static_cast<std::uint32_t>(now_ % 256), false},
                            {"can1", 0x400U + static_cast<std::uint32_t>(now_ % 256), false}};
    unlisted.offered = {{"Period", 100 * kMs, "ns", false}, {"MaxPayload", 8, "bytes", false}};
    unlisted.lease_ns = 5 * kOneSecond;
    ask(unlisted, peer);
  }

  /// Of other gateways: they subscribe, refuse further on, and announce themselves.
  void peers() {
    control::SubscribeRequest wanted;
    wanted.subject = bench_.state().system().channels[0].subject;
    wanted.network = bench_.state().system().networks[kLan].name;
    wanted.source = "192.0." + std::to_string(random_() % 250) + ".7";
    wanted.required = {{.name = "Deadline", .value = 40 * kMs, .unit = {}, .dynamic = false}};
    wanted.states_attributes = !each(11);
    wanted.lease_ns = 10 * kOneSecond;
    ask(wanted, user(kSubscriptions, 1));
    if (each(4)) {
      wanted.end = true;
      ask(wanted, user(kSubscriptions, 1));
    }
    if (each(13))
      ask(control::RefusalRequest{.subject = bench_.state().system().channels[1].subject,
                                  .network = wanted.network,
                                  .source = wanted.source,
                                  .reason = each(2) ? "" : name("no way")},
          user(kSubscriptions, 1));
    ask(control::PresenceRequest{.network = wanted.network,
                                 .gateway = name("gateway"),
                                 .lasts_ns = kOneSecond,
                                 .forwards = true,
                                 .not_received = {}},
        user(kSubscriptions, 1));
  }

  /// It asks what it is to carry, and carries it too late.
  void carriers() {
    ask(control::TransfersRequest{each(2) ? "c1" : "", kRelay}, user(kRelay, now_));
    ask(control::DelayRequest{.subject = bench_.state().system().channels[1].subject,
                              .publisher = "far",
                              .from = bench_.state().system().networks[kLan].name,
                              .to = bench_.state().system().networks[0].name,
                              .late = 3,
                              .longest_ns = 20 * kMs},
        user(kRelay, now_));
  }

  /// Events that stay out and come again, frames that are dropped, are too many or are of nobody.
  void gates() {
    FakeGates& gates = bench_.gates();
    gate_event event{};
    event.kind = each(2) ? GATE_E_MISSING : GATE_E_RESTORED;
    event.subject = each(3) ? 1 : 2;
    event.silent = 10 * kOneSecond;
    event.slot = static_cast<std::uint32_t>(random_() % 64);
    bench_.control().events.push_back(event);
    bench_.daemon().gates_reported();
    for (const core::Subject subject : {core::Subject{1}, core::Subject{2}}) {
      Frames& frames = gates.counted[subject];
      frames.passed += 20;
      if (each(40)) frames.dropped += 3, frames.last_reason = core::FrameReason::excess;
      if (each(70)) frames.excess += 2;
    }
    for (const auto& [interface, there] : bench_.kernel.interfaces) {
      gates.carried[interface].frames += random_() % 500;
      gates.carried[interface].bytes += random_() % 4'000;
      gates.unknown[interface].dropped += 2;
      auto& seen = gates.seen[interface];
      if (seen.size() > 40) seen.erase(seen.begin());
      seen.push_back({.can_id = static_cast<std::uint32_t>(random_() % 0x800),
                      .subject = random_(),
                      .len = 8,
                      .format = GATE_CLASSIC,
                      .count = 1,
                      .sequence = ++sequence_,
                      .station = random_()});
    }
  }

  void links() {
    const auto& networks = first_.networks;
    const std::string& name = networks[random_() % networks.size()].name;
    const auto known = bench_.kernel.interfaces.find(name);
    if (known == bench_.kernel.interfaces.end()) {
      bench_.kernel.plug(name);
    } else if (chance(random_, 50)) {
      bench_.kernel.unplug(name);  // it comes again with another index
    } else {
      known->second.up = !known->second.up;
    }
    bench_.daemon().links_changed();
  }

  void operators() {
    if (each(20)) ask(control::WithdrawRequest{"c0"});
    if (each(20, 5)) ask(control::ReinstateRequest{"c0"});
    if (each(90)) ask(control::ModeRequest{"audit", 0});
    if (each(90, 30)) ask(control::ModeRequest{"enforce", 0});
    if (!each(60)) return;
    bench_.system = each(120) ? first_ : second_;
    ++bench_.digest;
    ask(control::ReloadRequest{});
    bench_.reading().finish();
  }

  /// Reports in slices, of which some are not read to their end.
  void readers() {
    control::HistoryRequest latest;
    latest.limit = 200;
    const std::array answers{ask(control::StatusRequest{}), ask(control::ChannelsRequest{}),
                             ask(control::ExplainRequest{"c0"}), ask(control::AuditRequest{}),
                             ask(latest)};
    for (const serve::Answer& answer : answers) {
      auto slice = answer.slices ? answer.slices() : std::nullopt;
      for (int i = 0; slice && slice->more && i < 4; ++i) slice = answer.slices();
    }
  }

  [[nodiscard]] std::string name(const std::string& of) const { return of + std::to_string(now_); }
  /// Of a socket on the gateway.
  std::string address() {
    std::string out;
    while (out.size() < 21) out += "0123456789abcdef"[random_() % 16];
    return out;
  }

  store::test::Folder history_;
  Bench bench_;
  core::System first_;
  core::System second_;
  Random random_{2026};
  std::uint64_t now_ = 0;  ///< s; the session that began then
  std::uint64_t sequence_ = 0;
  std::uint64_t answered_ = 0;
  std::map<std::string, std::uint64_t> happened_;
};

TEST(LongRunTest, AnHourOfAGatewayKeepsNoMoreThanItsFirstMinutes) {
  BusyHour hour;
  Kept kept(60);
  for (std::uint64_t minute = 1; minute <= 60; ++minute) {
    hour.go_on_for(kOneMinute);
    kept.at_minute(minute, hour.heap());
  }
  for (const char* kind :
       {"granted", "refused", "revoked", "released", "reinstated", "network-down", "dropped",
        "policed", "missing", "restored", "late", "interface", "mode", "reload", "local"})
    EXPECT_GT(hour.happened(kind), 10U) << kind << ": where nothing happens nothing grows";
  EXPECT_GT(hour.answered(), 30'000U);
  EXPECT_LE(hour.admissions(), 64U);
  EXPECT_LE(kept.growth(), kRoom);
}

/// A source reports links of stations that come and go, each with an address of its own.
TEST(LongRunTest, AnHourOfSamplesKeepsNoMoreThanItsFirstMinutes) {
  core::mesh::Mesh mesh;
  mesh.nodes = {{"a", "02:00:00:00:00:01", {}, {}}, {"b", "02:00:00:00:00:02", {}, {}}};
  mesh.sources.resize(2);
  mesh.sources[0].kind = core::mesh::SourceKind::nl80211;
  mesh.sources[1].kind = core::mesh::SourceKind::babel;
  core::mesh::LinkTable table(mesh);
  Random random{2026};
  Kept kept(60);
  const auto sample = [&](const std::string& to, std::uint64_t now) {
    core::mesh::Sample out;
    out.from = mesh.nodes[0].address;
    out.to = to;
    out.rate = (1 + random() % 54) * 1'000'000;
    out.taken = now;
    return out;
  };
  std::uint64_t changes = 0;
  for (std::uint64_t second = 1; second <= 60 * kOneMinute; ++second) {
    const std::uint64_t now = second * kOneSecond;
    for (const std::size_t source : {std::size_t{0}, std::size_t{1}}) {
      core::mesh::Snapshot snapshot;
      if (!chance(random, 10)) snapshot.links.push_back(sample(mesh.nodes[1].address, now));
      for (int i = 0; i < 40; ++i) {
        const std::string station = "02:00:00:" + std::to_string(10 + random() % 90) + ':' +
                                    std::to_string(10 + random() % 90) + ':' +
                                    std::to_string(10 + random() % 90);
        snapshot.links.push_back(sample(station, now));
        snapshot.next_hops.push_back({mesh.nodes[0].address, station, mesh.nodes[1].address});
      }
      if (chance(random, 2)) snapshot = {.links = {}, .next_hops = {}, .problem = "no answer"};
      changes += table.take(source, snapshot, now) ? 1 : 0;
    }
    changes += table.expire(now + kOneSecond / 2) ? 1 : 0;
    if (second % kOneMinute == 0) kept.at_minute(second / kOneMinute, heap_in_use());
  }
  EXPECT_GT(changes, 3'000U);
  EXPECT_LE(table.size(), core::mesh::kMaxLinks);
  EXPECT_LE(kept.growth(), kRoom);
}

}  // namespace
}  // namespace mlcca::test
