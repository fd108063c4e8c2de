// SPDX-License-Identifier: BSD-2-Clause
#include "tests/daemon/gateway/bench.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "base/handle.hpp"
#include "base/number.hpp"
#include "core/gates/control_traffic.hpp"
#include "daemon/store/journal.hpp"

namespace mlcca::test {
namespace {

/// The loop for link sources and for reports that are made aside, of which these tests have none.
sd_event* idle_loop() {
  static const std::unique_ptr<sd_event, FreeWith<sd_event_unref>> loop([] {
    sd_event* made = nullptr;
    sd_event_new(&made);
    return made;
  }());
  return loop.get();
}

core::Place network(std::size_t n) { return {core::Place::Kind::network, n}; }
core::Place gateway() { return {core::Place::Kind::gateway, 0}; }

AttributeSet traffic(Value period) {
  return AttributeSet{}.set(Attribute::period, period).set(Attribute::max_payload, 8);
}

core::Network bus(std::size_t number) {
  core::Network out;
  out.name = "can" + std::to_string(number);
  out.profile = core::Profile::raw;
  out.bus.bitrate = 125'000;
  out.provision.set(Attribute::max_payload, 8);
  out.unlisted = {.allowed = true, .subject = kUnlistedSubjects, .bits = 8, .most = 2};
  return out;
}

core::Network ethernet() {
  core::Network out;
  out.name = "eth0";
  out.kind = core::NetworkKind::udp_multicast;
  out.profile = core::Profile::famouso;
  out.provision = AttributeSet{}
                      .set(Attribute::latency, kMs)
                      .set(Attribute::jitter, kMs)
                      .set(Attribute::period, kMs)
                      .set(Attribute::omission, 0)
                      .set(Attribute::bandwidth, 2'000)
                      .set(Attribute::max_payload, 1'400);
  out.unlisted = {.allowed = true, .subject = kUnlistedSubjects, .bits = 8, .most = 2};
  return out;
}

core::System bare(std::size_t buses) {
  core::System system;
  system.name = "bench";
  for (std::size_t b = 0; b < buses; ++b) system.networks.push_back(bus(b));
  system.networks.push_back(ethernet());
  core::Gateway g;
  g.name = "g";
  g.provision.set(Attribute::latency, kMs).set(Attribute::jitter, kMs);
  g.relay = 990;
  for (std::size_t n = 0; n <= buses; ++n) {
    core::Port port;
    port.network = n;
    port.identity.name = system.networks[n].name;
    port.queue_length = 40;
    g.ports.push_back(port);
  }
  system.gateways.push_back(g);
  return system;
}

void add_channel(core::System& system, Value period) {
  const std::size_t c = system.channels.size();
  core::EventChannel channel;
  channel.name = "c" + std::to_string(c);
  channel.subject = c + 1;
  channel.attributes = traffic(period);
  system.channels.push_back(channel);
  for (core::Network& n : system.networks) {
    if (n.kind != core::NetworkKind::can) continue;
    core::Binding binding;
    binding.channel = c;
    binding.id = static_cast<std::uint32_t>(0x10 + c);
    n.bindings.push_back(binding);
  }
}

void add_publisher(core::System& system, std::size_t channel, core::Place place) {
  core::Publisher p;
  p.name = "p" + std::to_string(system.publishers.size());
  p.channel = channel;
  p.place = place;
  p.attributes = system.channels[channel].attributes;
  p.lower = system.channels[channel].lower;
  if (place.kind == core::Place::Kind::gateway) p.uid = 1000;
  system.publishers.push_back(p);
}

void add_subscriber(core::System& system, std::size_t channel, core::Place place) {
  core::Subscriber s;
  s.name = "s" + std::to_string(system.subscribers.size());
  s.channel = channel;
  s.place = place;
  s.attributes = system.channels[channel].attributes;
  s.lower = system.channels[channel].lower;
  system.subscribers.push_back(s);
}

core::Place anywhere(Random& random, const core::System& system) {
  const std::size_t i = below(random, system.networks.size() + 1);
  return i == system.networks.size() ? gateway() : network(i);
}

}  // namespace

control::Admit newcomer() {
  control::Admit request;
  request.channel = "c1";
  request.from = "can0";
  request.to = "can1";
  request.publisher = "new";
  request.subscriber = "late";
  return request;
}

core::System small_system() {
  core::System system = bare(2);
  add_channel(system, 50 * kMs);
  add_channel(system, 50 * kMs);
  add_publisher(system, 0, network(0));
  add_subscriber(system, 0, network(1));
  return system;
}

core::System random_system(Random& random) {
  core::System system = bare(2 + below(random, 2));
  const std::size_t channels = 4 + below(random, 4);
  for (std::size_t c = 0; c < channels; ++c) {
    add_channel(system, (4 + below(random, 40)) * kMs);
    core::EventChannel& channel = system.channels.back();
    channel.importance = static_cast<std::uint8_t>(below(random, 3));
    if (chance(random, 30)) {
      channel.priority = 1;
      channel.lower = {{0, traffic(200 * kMs), {}}};
    }
    if (chance(random, 75)) add_publisher(system, c, anywhere(random, system));
    for (std::size_t i = below(random, 3); i > 0; --i)
      add_subscriber(system, c, anywhere(random, system));
  }
  return system;
}

core::System varied(Random& random, core::System system) {
  switch (below(random, 5)) {
    case 0:
      if (!system.subscribers.empty()) system.subscribers.pop_back();
      break;
    case 1:
      std::ranges::reverse(system.gateways[0].ports);
      break;
    case 2:
      if (system.gateways[0].ports.size() > 2) system.gateways[0].ports.pop_back();
      break;
    case 3:
      system.networks[0].bus.bitrate = system.networks[0].bus.bitrate == 125'000 ? 50'000 : 125'000;
      system.networks[1].unlisted.allowed = !system.networks[1].unlisted.allowed;
      break;
    default:
      add_subscriber(system, below(random, system.channels.size()), anywhere(random, system));
  }
  return system;
}

serve::Peer member(std::uint64_t session) {
  return {.pid = 1, .uid = 1000, .may_change = true, .session = session};
}
serve::Peer outsider(std::uint64_t session) {
  return {.pid = 1, .uid = 1001, .may_change = false, .session = session};
}

// --- the bench -----------------------------------------------------------------------------------

Bench::Bench(core::System described)
    : system(std::move(described)), memory_(std::make_unique<store::test::MemoryDisk>()) {
  for (const core::Network& n : system.networks) kernel.plug(n.name);
  disk_ = std::make_unique<store::test::TroubledDisk>(*memory_, memory_.get());
}

std::optional<StartError> Bench::start() {
  end();
  log_ = std::make_unique<EventLog>(SystemLog::to_journald("/nowhere/at/all"));
  log_->on_event([this](const control::Event& event) {
    events.push_back(event.kind);
    published.push_back(event);
  });
  links_ = std::make_unique<FakeLinks>(kernel);
  gates_ = std::make_unique<FakeGates>(kernel, *links_);
  control_ = std::make_unique<FakeControl>(kernel);
  reading_ = std::make_unique<FakeBackground>(clock);
  Options options;
  options.state_directory = state_directory;
  options.bpf_root = "/nowhere/at/all";
  options.lease_ns = lease_ns;
  options.initial_audit = initial_audit;
  controller_ = std::make_unique<Controller>(
      options, Outside{.gates = *gates_,
                       .control = *control_,
                       .links = *links_,
                       .can = can,
                       .clock = clock,
                       .disk = *disk_,
                       .reading = *reading_,
                       .log = *log_,
                       .read = [this]() -> DescribedResult {
                         if (!readable)
                           return std::unexpected(StartError{{"no description"}, true});
                         return Described{.state = std::make_unique<core::State>(system),
                                          .self = self,
                                          .digest = Sha256::Digest{digest},
                                          .text = std::to_string(digest)};
                       },
                       .read_text = [this](const std::string& text) -> DescribedResult {
                         const auto number = number_in<std::uint8_t>(text);
                         const auto known = handed_on.find(number.value_or(0));
                         if (known == handed_on.end())
                           return std::unexpected(StartError{{"line 3: no such network"}, true});
                         return Described{.state = std::make_unique<core::State>(known->second),
                                          .self = self,
                                          .digest = Sha256::Digest{known->first}};
                       },
                       .texts = &texts,
                       .can_rules = std::make_unique<FakeCanRules>(kernel),
                       .loop = idle_loop(),
                       .threads = threads,
                       .cluster = cluster});
  controller_->on_commit([this](const Result<void>& done) { commits.push_back(done); });
  return controller_->start();
}

void Bench::end() {
  if (log_) log_->on_event({});
  controller_.reset();
}

void Bench::lose_disk() {
  end();
  memory_ = std::make_unique<store::test::MemoryDisk>();
  disk_ = std::make_unique<store::test::TroubledDisk>(*memory_, memory_.get());
}

void Bench::lose_power(std::mt19937& random) {
  end();
  memory_ = memory_->after_power_loss(random);
  disk_ = std::make_unique<store::test::TroubledDisk>(*memory_, memory_.get());
}

serve::Answer Bench::ask(decltype(control::Request::body) body, serve::Peer peer) {
  return controller_->answer({.id = 1, .body = std::move(body), .slices = false}, peer);
}

void Bench::round() {
  controller_->begin_round();
  for (int i = 0; i < 1'000 && controller_->has_work(); ++i) controller_->work();
}

core::GateState Bench::wanted() const {
  core::GateState all = state().gate_state(self);
  std::ranges::copy(core::control_rules(state().system(), self, ::geteuid()),
                    std::back_inserter(all));
  return all;
}

store::Contents Bench::recorded(std::mt19937& random) const {
  const auto copy = memory_->after_power_loss(random);
  const auto journal = store::Journal::open(state_directory, *copy);
  return journal ? journal->contents() : store::Contents{};
}

}  // namespace mlcca::test
