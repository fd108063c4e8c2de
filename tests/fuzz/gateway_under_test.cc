// SPDX-License-Identifier: BSD-2-Clause
#include "tests/fuzz/gateway_under_test.hpp"

#include <fmt/format.h>
#include <sanitizer/allocator_interface.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <systemd/sd-event.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <utility>

#include "base/listen.hpp"
#include "control/codec.hpp"
#include "core/gates/control_traffic.hpp"
#include "daemon/gateway/controller.hpp"
#include "daemon/loop.hpp"
#include "daemon/real_outside.hpp"
#include "daemon/serve/session.hpp"
#include "daemon/store/journal.hpp"
#include "description/read.hpp"
#include "tests/daemon/gateway/who_may.hpp"
#include "tests/fuzz/demand.hpp"
#include "tests/fuzz/surroundings.hpp"
#include "tools/readback/differences.hpp"

namespace mlcca::fuzz {
namespace {

/// A request of somebody else than root and the control group that is not refused changes nothing.
bool changes(const control::Request& request) {
  return test::who_may(request) == test::Who::member;
}

}  // namespace

struct GatewayUnderTest::Parts {
  Options options;
  EventLoop loop = new_event_loop();
  std::optional<RealOutside> world;
  std::optional<Controller> gateway;
  std::optional<Loop> sources;
  std::unique_ptr<serve::Server> server;

  ~Parts() {
    server.reset();
    sources.reset();
    if (world) world->log().on_event([](const control::Event&) {});
    while (gateway && gateway->is_reading()) sd_event_run(loop.get(), 1'000'000);
    gateway.reset();
    world.reset();
    // A child that makes a report holds what it has inherited, the lock of the journal too.
    while (::waitpid(-1, nullptr, 0) > 0) {
    }
  }
};

GatewayUnderTest::GatewayUnderTest() {
  const std::string state = surroundings().folder + "/state";
  std::filesystem::remove_all(state);
  std::filesystem::create_directories(state);
  describe(0);
  start();
}

void GatewayUnderTest::ask(decltype(control::Request::body) body) {
  send(0, control::encode(control::Request{1, std::move(body)}));
  settle();
}

void GatewayUnderTest::begin() {
  memory_ = 0;
  while (!clients_.empty()) close(0);
  settle();
  connect(User::root);
  if (written_ != 0 || in_force_ != 0) {
    describe(0);
    ask(control::ReloadRequest{});
  }
  const store::Contents before = stored();
  for (const auto& admitted : before.admissions)
    if (alive_.contains(admitted.id)) ask(control::ReleaseRequest{"", admitted.id, ""});
  for (const std::string& subject : before.released) ask(control::ReinstateRequest{subject});
  if (audit_) ask(control::ModeRequest{"enforce"});
  close(0);
  settle();
  const store::Contents after = stored();
  demand(after.admissions.empty() && after.released.empty(),
         "something is still released or admitted");
  first_id_ = after.next_id;
  memory_ = __sanitizer_get_current_allocated_bytes();
}

GatewayUnderTest::~GatewayUnderTest() {
  parts_->gateway->stop();
  parts_.reset();
}

void GatewayUnderTest::start() {
  const std::string& folder = surroundings().folder;
  parts_ = std::make_unique<Parts>();
  Parts& p = *parts_;
  p.options.description = folder + "/system.xml";
  p.options.gateway = "gate";
  p.options.socket = folder + "/control.sock";
  p.options.bpf_root = surroundings().bpf_root;
  p.options.state_directory = folder + "/state";
  p.options.grace_ns = 600'000'000'000;
  auto control = gates::Control::create(p.options.bpf_root);
  demand(control.has_value(), control ? "" : control.error().text);
  audit_ = control->mode() == gates::Mode::audit;
  auto links = net::Links::open();
  demand(links.has_value(), links ? "" : links.error().text);
  p.world.emplace(
      p.options, SystemLog::to_stderr(), std::move(*control), std::move(*links),
      [](int) { return net::UdevFacts{}; }, p.loop.get());
  p.gateway.emplace(p.options, p.world->outside());
  const auto problem = p.gateway->start();
  demand(!problem, problem ? problem->lines.front() : "");
  auto sources = Loop::open(p.loop.get(), *p.gateway, *p.world);
  demand(sources.has_value(), "an event loop");
  p.sources.emplace(std::move(*sources));
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  auto socket = listen_at(p.options.socket, SOCK_STREAM, 0666);
  demand(socket.has_value(), "a control socket");
  Controller& gateway = *p.gateway;
  auto server = serve::Server::open(
      p.loop.get(), std::move(*socket), kGroup,
      [&gateway](const auto& request, const auto& peer) { return gateway.answer(request, peer); });
  demand(server.has_value(), "a control server");
  p.server = std::move(*server);
  serve::Server& server_there = *p.server;
  gateway.on_commit([&server_there](const Result<void>& done) { server_there.release(done); });
  p.server->on_close([&gateway](std::uint64_t session) { gateway.session_closed(session); });
  gateway.on_slice([&server_there](std::uint64_t session) { server_there.resume(session); });
  gateway.on_begin(
      [&server_there](std::uint64_t session) { return server_there.is_gone(session); });
  gateway.set_report_rates({{1'000'000, 1'000'000}, {1'000'000, 1'000'000}, 0});
  p.world->log().on_event(
      [&server_there](const control::Event& event) { server_there.publish(event); });
  in_force_ = written_;
  auto system = description::read(p.options.description);
  demand(system.has_value(), "it has started with what cannot be read");
  names_ = std::make_unique<core::State>(std::move(*system));
}

// --- what happens --------------------------------------------------------------------------------

void GatewayUnderTest::connect(User user) {
  if (clients_.size() == kMostClients) return;
  auto client = std::make_unique<Client>();
  client->socket = connected(parts_->options.socket, user);
  client->user = user;
  clients_.push_back(std::move(client));
}

void GatewayUnderTest::send(std::size_t number, std::string_view octets) {
  if (number >= clients_.size() || clients_[number]->is_shut) return;
  Client& client = *clients_[number];
  client.unsent += octets;
  client.sent.append(octets);
  while (!client.is_broken) {
    auto request = control::decode_request(client.sent);
    if (!request) client.is_broken = true;
    if (!request || !*request) break;
    if (std::holds_alternative<control::MonitorRequest>((*request)->body)) client.monitors = true;
    client.asked.push_back(std::move(**request));
  }
}

/// The answers that it has not received are unknown now.
void GatewayUnderTest::lose(Client& client) {
  for (const auto& request : client.asked)
    if (changes(request) && client.user != User::outsider) unsure_ = true;
}

void GatewayUnderTest::close(std::size_t number) {
  if (number >= clients_.size()) return;
  lose(*clients_[number]);
  clients_.erase(clients_.begin() + static_cast<std::ptrdiff_t>(number));
}

void GatewayUnderTest::shut(std::size_t number) {
  if (number >= clients_.size() || clients_[number]->is_shut) return;
  Client& client = *clients_[number];
  client.is_shut = true;
  ::shutdown(client.socket.get(), SHUT_WR);
}

void GatewayUnderTest::set_reading(std::size_t number, bool reads) {
  if (number < clients_.size()) clients_[number]->reads = reads;
}

void GatewayUnderTest::describe(std::size_t number) {
  written_ = number % kDescriptions;
  std::ofstream(surroundings().folder + "/system.xml") << description(written_);
}

void GatewayUnderTest::run_round() {
  parts_->gateway->begin_round();
  while (parts_->gateway->has_work()) parts_->gateway->work();
  parts_->gateway->act();  // as at the end of each turn of the loop
}

void GatewayUnderTest::restart(bool in_order) {
  for (const auto& client : clients_) lose(*client);
  clients_.clear();
  if (in_order) parts_->gateway->stop();
  parts_.reset();
  if (written_ == kUnreadable) describe(in_force_);
  start();
}

// --- what is said --------------------------------------------------------------------------------

void GatewayUnderTest::run_loop(std::uint64_t micros) {
  demand(sd_event_run(parts_->loop.get(), micros) >= 0, "the loop has ended");
}

/// False when nothing moves any more.
bool GatewayUnderTest::exchange() {
  bool moves = sd_event_run(parts_->loop.get(), 0) > 0;
  for (std::size_t i = 0; i < clients_.size(); ++i) {
    Client& client = *clients_[i];
    if (!client.unsent.empty()) {
      const ssize_t sent = ::send(client.socket.get(), client.unsent.data(), client.unsent.size(),
                                  MSG_DONTWAIT | MSG_NOSIGNAL);
      if (sent > 0) client.unsent.erase(0, static_cast<std::size_t>(sent));
      if (sent < 0 && errno != EAGAIN) client.unsent.clear();
      moves = moves || sent > 0;
    }
    if (!client.reads) continue;
    std::array<char, 65536> room{};
    const ssize_t size = ::recv(client.socket.get(), room.data(), room.size(), MSG_DONTWAIT);
    if (size > 0) {
      client.received.append({room.data(), static_cast<std::size_t>(size)});
      receive(client);
      moves = true;
    } else if (size == 0 || errno != EAGAIN) {
      // A client that has sent what is no request gets an error, and so may one that sends no more.
      demand(client.is_broken || client.is_shut, "a client was hung up on");
      demand(client.is_shut || client.asked.empty(), "hung up on without an answer");
      close(i--);
      moves = true;
    }
  }
  return moves;
}

void GatewayUnderTest::settle() {
  const auto waits = [](const auto& client) {
    return client->reads && !client->is_shut &&
           (!client->asked.empty() || client->is_broken || !client->unsent.empty());
  };
  for (int patience = 0;
       exchange() || std::ranges::any_of(clients_, waits) || parts_->gateway->is_reading();) {
    if (!std::ranges::any_of(clients_, waits) && !parts_->gateway->is_reading()) continue;
    run_loop(1000);
    demand(++patience < 20'000, "a client waits for ever for an answer");
  }
  check();
}

void GatewayUnderTest::finish() { check(true); }

void GatewayUnderTest::receive(Client& client) {
  for (;;) {
    const auto reply = control::decode_reply(client.received);
    demand(reply.has_value(), "a reply that cannot be read");
    if (!*reply) return;
    take(client, **reply);
  }
}

void GatewayUnderTest::take(Client& client, const control::Reply& reply) {
  if (std::holds_alternative<control::Event>(reply.body)) {
    demand(reply.id == 0, "an event with a number");
    return;
  }
  if (client.asked.empty()) {
    demand(client.is_broken && reply.id == 0 && std::holds_alternative<control::Error>(reply.body),
           "an answer without a request");
    return;
  }
  const control::Request& request = client.asked.front();
  demand(reply.id == request.id, "an answer to another question");
  demand(!reply.more || request.slices, "a slice without a request");
  judge(client, request, reply);
  if (!reply.more) client.asked.pop_front();
}

std::optional<std::uint64_t> GatewayUnderTest::subject_named(const std::string& name) const {
  const auto channel = names_->find_channel(name);
  if (!channel) return core::parse_subject(name);
  return names_->system().channels[*channel].subject;
}

void GatewayUnderTest::judge(const Client& client, const control::Request& request,
                             const control::Reply& reply) {
  if (const auto* error = std::get_if<control::Error>(&reply.body)) {
    demand(!error->message.empty(), "a refusal without a word");
    return;
  }
  demand(client.user != User::outsider || !changes(request), "an outsider has changed something");
  if (const auto* admit = std::get_if<control::Admit>(&request.body)) {
    const auto* channels = std::get_if<control::Channels>(&reply.body);
    demand(channels != nullptr, "an admission that is answered with something else");
    for (const auto& c : channels->channels)
      if (c.admission != 0 && (!admit->publisher.empty() || !admit->subscriber.empty() ||
                               !admit->key.empty() || admit->node || admit->priority ||
                               !admit->user.empty() || !admit->from.empty() || !admit->to.empty()))
        alive_.try_emplace(c.admission,
                           Alive{c.subject, admit->key, admit->lease_ns != 0 || admit->hold});
  } else if (const auto* release = std::get_if<control::ReleaseRequest>(&request.body)) {
    judge_release(*release);
  } else if (const auto* mode = std::get_if<control::ModeRequest>(&request.body)) {
    audit_ = mode->mode == "audit";
  } else if (std::holds_alternative<control::ReloadRequest>(request.body)) {
    demand(written_ != kUnreadable, "a description that cannot be read is in force");
    in_force_ = written_;
    auto system = description::read(parts_->options.description);
    demand(system.has_value(), "what cannot be read is in force");
    names_ = std::make_unique<core::State>(std::move(*system));
  }
}

void GatewayUnderTest::judge_release(const control::ReleaseRequest& request) {
  if (!request.key.empty())
    std::erase_if(alive_, [&](const auto& a) { return a.second.key == request.key; });
  else if (request.admission != 0)
    alive_.erase(request.admission);
  else if (const auto subject = subject_named(request.channel))
    std::erase_if(alive_, [&](const auto& a) { return a.second.subject == *subject; });
}

// --- what must hold ------------------------------------------------------------------------------

/// As it is on disk.
store::Contents GatewayUnderTest::stored() const {
  const std::string& folder = surroundings().folder;
  const std::string copy = folder + "/copy";
  std::filesystem::remove_all(copy);
  std::filesystem::create_directories(copy);
  std::filesystem::copy_file(folder + "/state/journal", copy + "/journal");
  auto journal = store::Journal::open(copy);
  demand(journal.has_value(), journal ? "" : "the journal: " + journal.error().text);
  return journal->contents();
}

void GatewayUnderTest::check(bool gates_too) {
  store::Contents journal = stored();
  check_admissions(journal);
  if (gates_too || journal != checked_) check_gates(journal);
  checked_ = std::move(journal);
  const std::size_t bound =
      (std::size_t{8} << 20) +
      clients_.size() * (2 * serve::Session::kBusy + 2 * control::Request::kMaxBytes);
  const std::size_t now = __sanitizer_get_current_allocated_bytes();
  demand(memory_ == 0 || now < memory_ + bound,
         fmt::format("{} bytes more than at the start", now - memory_));
}

void GatewayUnderTest::check_admissions(const store::Contents& journal) {
  if (unsure_) {
    // What is there counts from now on.
    if (std::ranges::none_of(clients_, [](const auto& c) { return !c->asked.empty(); })) {
      unsure_ = false;
      alive_.clear();
      for (const auto& request : journal.admissions) {
        const auto& admit = std::get<control::Admit>(request.body);
        alive_[request.id] = {subject_named(admit.channel).value_or(0), admit.key,
                              admit.lease_ns != 0 || admit.hold};
      }
    }
    return;
  }
  std::erase_if(alive_, [&](const auto& known) {
    const bool there = journal.admissions.find(known.first) != nullptr;
    demand(there || known.second.may_end,
           fmt::format("admission {} was answered and is not on disk", known.first));
    return !there;
  });
  if (std::ranges::any_of(clients_, [](const auto& c) { return !c->asked.empty(); })) return;
  for (const auto& request : journal.admissions)
    demand(
        alive_.contains(request.id),
        fmt::format("admission {} is on disk, and was not answered or was released", request.id));
}

void GatewayUnderTest::check_gates(const store::Contents& journal) const {
  auto reading = gates::read_back(parts_->options.bpf_root);
  demand(reading.has_value(), reading ? "" : reading.error().text);
  demand(reading->open && !reading->lapsed, "the gates are closed");
  if (std::ranges::all_of(clients_, [](const auto& c) { return c->asked.empty(); }) && !unsure_)
    demand(reading->audit == audit_, "another mode than was said");
  demand(reading->gates.size() == 2, "a gate is missing");
  readback::compare_slots(*reading, journal);
  demand(reading->problems.empty(), reading->problems.empty() ? "" : reading->problems.front());
  for (const auto& gate : reading->gates) {
    demand(gate.readable, gate.interface + ": its slots cannot be read");
    demand(gate.problems.empty(), gate.problems.empty() ? "" : gate.problems.front());
    for (const auto& slot : gate.slots)
      if (slot.pass) check_slot(slot, journal, gate.interface);
  }
}

/// Of a channel that is not described: every network allows its subject, and on the bus its tag is
/// that of one admission only.
void GatewayUnderTest::check_unlisted_slot(const gates::SlotSpec& slot,
                                           const store::Contents& journal,
                                           const std::string& what) const {
  const core::System& system = names_->system();
  for (const core::Network& network : system.networks)
    demand(network.unlisted.admits(slot.subject), what + ", and no channel has it");
  constexpr std::uint32_t tag = 0x3fff;
  if (slot.id == 0) return;  // on Ethernet
  for (const core::Network& network : system.networks)
    for (const core::Binding& b : network.bindings)
      demand(b.id != (slot.id & tag), what + ", by the tag of another channel");
  for (const auto& request : journal.admissions) {
    const auto& admit = std::get<control::Admit>(request.body);
    if (subject_named(admit.channel) == slot.subject &&
        std::ranges::find(admit.identifiers, slot.id & tag, &control::Identifier::id) !=
            admit.identifiers.end())
      return;
  }
  demand(false,
         fmt::format("{}, by tag {:#x}, which was granted to no subject", what, slot.id & tag));
}

/// By the description and the admissions alone, whatever the daemon has made of them.
void GatewayUnderTest::check_slot(const gates::SlotSpec& slot, const store::Contents& journal,
                                  const std::string& where) const {
  if (slot.subject == 0 || slot.source == GATE_NO_SOURCE) return;  // not of a channel
  const std::string what = fmt::format("{}: subject {:#x} passes", where, slot.subject);
  const core::System& system = names_->system();
  const auto c = static_cast<std::size_t>(
      std::ranges::find(system.channels, slot.subject, &core::EventChannel::subject) -
      system.channels.begin());
  if (slot.subject == core::kSubscribeSubject && c == system.channels.size()) {
    // Control traffic, which no description of this target forbids or gives to another user.
    demand(slot.direction == gates::Direction::ingress || slot.source != 0 || slot.uid == 0,
           fmt::format("{} for user {}, who sends no control traffic", what, slot.uid));
    return;
  }
  if (c == system.channels.size()) check_unlisted_slot(slot, journal, what);
  const bool released = std::ranges::any_of(
      journal.released, [&](const auto& text) { return subject_named(text) == slot.subject; });
  bool published = false;
  bool subscribed = false;
  std::set<std::uint32_t> users;
  const auto publishes = [&](std::optional<std::uint32_t> user) {
    published = true;
    if (user) users.insert(*user);
  };
  if (!released) {
    for (const auto& p : system.publishers)
      if (p.channel == c) publishes(p.uid);
    for (const auto& s : system.subscribers) subscribed = subscribed || s.channel == c;
  }
  for (const auto& request : journal.admissions) {
    const auto& admit = std::get<control::Admit>(request.body);
    if (subject_named(admit.channel) != slot.subject) continue;
    std::uint32_t user = 0;
    const auto read =
        std::from_chars(admit.user.data(), admit.user.data() + admit.user.size(), user);
    if (!admit.from.empty()) publishes(read.ec == std::errc{} ? std::optional(user) : std::nullopt);
    if (!admit.to.empty()) subscribed = true;
  }
  demand(published || released, what + ", and no endpoint publishes it");
  demand(published, what + ", and was released");
  demand(subscribed || released, what + ", and no endpoint subscribes to it");
  if (slot.direction == gates::Direction::egress && slot.source == 0)
    demand(users.contains(slot.uid),
           fmt::format("{} for user {}, who was not granted it", what, slot.uid));
}

}  // namespace mlcca::fuzz
