// SPDX-License-Identifier: BSD-2-Clause
// What the gateway looks at by itself, in rounds, and what it tells of all that happens.
#include <fmt/core.h>
#include <linux/can.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "base/clock.hpp"
#include "bpf/gate.h"
#include "core/model/text.hpp"
#include "daemon/gateway/gateway.hpp"
#include "daemon/gateway/report.hpp"
#include "daemon/ports/gates_lock.hpp"

namespace mlcca {
namespace {

constexpr std::uint64_t kTryAgain = 10'000'000'000;  // ns

// Of a piece of a round:
constexpr std::size_t kLeasesEndedTogether = 64;  // and synced together
constexpr std::size_t kHeardAtOnce = 64;          // channels

/// What drops and comes and goes each second is for the log, not for the history.
bool is_history(Kind kind) { return kind != Kind::dropping; }

/// "123", "FD 1ABCDEF0", "0x44697374616e6365 on its way out"
std::string frame_name(const gate_sample& sample) {
  const char* const way = sample.direction == GATE_EGRESS ? " on its way out" : "";
  if (sample.format == 0) {
    enforce::Mac mac;
    std::ranges::copy(sample.mac, mac.begin());
    return fmt::format("{}{} from {}", core::format_subject(sample.subject), way,
                       enforce::sender_text(sample.station, mac));
  }
  const char* const remote = (sample.can_id & CAN_RTR_FLAG) != 0 ? "remote " : "";
  std::string format;
  if (sample.format == GATE_FD) format = "FD ";
  if (sample.format == GATE_XL) format = "XL ";
  return (sample.can_id & CAN_EFF_FLAG) != 0
             ? fmt::format("{}{}{:08X}{}", format, remote, sample.can_id & CAN_EFF_MASK, way)
             : fmt::format("{}{}{:03X}{}", format, remote, sample.can_id & CAN_SFF_MASK, way);
}

}  // namespace

/// Each of these does one thing of many, or a few that are short.
void Gateway::plan_rounds() {
  rounds_.add([this] { return look_around(); });
  rounds_.add([this] { return repair_next(); });
  rounds_.add([this] { return end_some_leases(); });
  rounds_.add([this] { return measure_some_buses(); });
  rounds_.add([this] { return look_at_some_drops(); });
  rounds_.add([this] { return drops_.tidy(); });
  rounds_.add([this] { return look_at_next_unknown(); });
  rounds_.add([this] { return look_for_next_bypass(); });
  rounds_.add([this] { return look_at_tags(); });
  rounds_.add([this] { return ask_for_tags(); });
  rounds_.add([this] { return write_some_history(); });
}

/// What does not grow with channels or ports; the rules of can-gw are read in one answer.
bool Gateway::look_around() {
  const auto again = control_.keep_pinned();
  if (unpinned_.is_new(again ? "" : "the control word is not pinned: " + again.error().text))
    tell(Kind::trouble, 3, unpinned_.text());
  if (again && *again)
    tell(Kind::drift, 3,
         "somebody unpinned what closes the gates when this daemon dies: it is pinned again");
  if (lock_) keep_lock();
  if (!links_.problem().empty() || ports_.in_doubt()) links_changed();
  ports_.begin_repair();
  at_gate_ = 0;
  keep_journal();
  forwarder_.look();
  aside_.look();
  if (reading_.waits() && monotonic_ns() - reading_.begun() > options_.read_limit_ns) {
    reading_.forget();
    const std::string why = "nothing was changed: " + not_read_in_time();
    tell(Kind::reload, 3, why);
    end_reload(control::Error{control::ErrorKind::unreadable, why, {}});
  }
  return false;
}

void Gateway::keep_lock() {
  const auto locked = mlcca::keep_lock(lock_, options_.bpf_root);
  if (unlocked_.is_new(locked ? ""
                              : "two daemons may change the same gates: " + locked.error().text))
    tell(Kind::trouble, 3, unlocked_.text());
  if (locked && *locked)
    tell(Kind::drift, 3,
         "somebody removed the lock of " + options_.bpf_root + ": it is held again");
}

bool Gateway::repair_next() {
  if (const auto gate = ports_.next_gate(at_gate_)) {
    at_gate_ = *gate;
    // A client's turn in between would be told of changes that an interface without a gate ignores.
    if (!ports_.repair(*gate)) follow_world();
    return true;
  }
  at_gate_ = 0;
  if (ports_.wants_gate()) follow_world();
  return false;
}

bool Gateway::look_for_next_bypass() {
  const auto gate = ports_.next_gate(at_gate_);
  at_gate_ = gate.value_or(0);
  if (gate) ports_.look_for_bypass(*gate, monotonic_s());
  return gate.has_value();
}

bool Gateway::write_some_history() {
  if (!history_) return false;
  const bool more = patience_.wait_for([this] { return history_->flush_some(unix_ns()); });
  for (std::string& line : history_->take_troubles()) tell(Kind::trouble, 4, std::move(line));
  return more;
}

bool Gateway::end_some_leases() {
  const std::vector<core::AdmissionId> expired =
      leases_.expired(monotonic_ns(), kLeasesEndedTogether);
  if (expired.empty()) return false;
  const auto done = release(expired, "its lease ended and was not renewed");
  if (done) return true;
  tell(Kind::trouble, 3, done.error().text);
  // What could not be written down stays reserved, and is tried again.
  for (const core::AdmissionId id : expired) leases_.postpone(id, kTryAgain, monotonic_ns());
  return true;
}

void Gateway::session_closed(std::uint64_t session) {
  for (auto it = held_.begin(); it != held_.end();) {
    if (it->second.erase(session) == 0 || !it->second.empty()) {
      ++it;
      continue;
    }
    const control::Request* request = stored().admissions.find(it->first);
    if (request != nullptr)
      leases_.set(it->first, lease_of(std::get<control::Admit>(request->body)), monotonic_ns());
    it = held_.erase(it);
  }
}

/// The bands of queues by priority, as the analysis has them.
void Gateway::set_bands() {
  for (std::size_t p = 0; p < ports_.size(); ++p) {
    if (!ports_.queues_by_priority(p)) continue;
    const std::size_t network = ports_.network_number(p);
    const core::can::Schedule* bus = state_->ledger().schedule(network);
    if (bus == nullptr) continue;
    const std::uint32_t queue = core::queue_of(state_->system(), self_, network);
    const auto bands = core::can::bands_of(bus->assumptions(), bus->messages());
    std::array<std::uint32_t, GATE_BANDS - 1> limits{};
    limits.fill(~0U);
    for (std::size_t m = 0; m < bands.size(); ++m) {
      const core::can::Message& message = bus->messages()[m];
      if (message.queue != queue || bands[m] >= limits.size()) continue;
      std::uint32_t& limit = limits[bands[m]];
      const std::uint32_t last = std::max(message.priority, message.lowest_priority);
      limit = limit == ~0U ? last : std::max(limit, last);
    }
    ports_.set_bands(p, limits);
  }
}

bool Gateway::is_measured(std::size_t port) {
  const std::size_t network = ports_.network_number(port);
  return state_->ledger().schedule(network) != nullptr &&
         state_->system().networks[network].bus.measured && ports_.bus_counters(port).has_value();
}

/// Of one port after the other: who is heard on its bus, some channels at a time, then its load.
bool Gateway::measure_some_buses() {
  if (hearing_.description != description_) hearing_ = {};
  hearing_.description = description_;
  const std::size_t port = hearing_.port;
  if (port >= ports_.size()) {
    if (hearing_.changed) {
      put_conditions(*state_);
      static_cast<void>(settle());
    }
    hearing_ = {};
    return false;
  }
  if (!is_measured(port)) {
    hearing_.next_port();
    return true;
  }
  const std::size_t channels = state_->decisions().size();
  const std::size_t end = std::min(hearing_.channel + kHeardAtOnce, channels);
  for (; hearing_.channel < end; ++hearing_.channel)
    hear_refused(state_->decisions()[hearing_.channel], port);
  if (end < channels) return true;
  hearing_.changed |= measure_bus(port, std::move(hearing_.refused));
  hearing_.next_port();
  return true;
}

/// More on a bus than was analysed: somebody sends who was not admitted, or more than he said. What
/// the gate drops has been on the bus all the same. True if that is not as it was.
bool Gateway::measure_bus(std::size_t p, std::vector<core::Heard> senders) {
  const std::size_t network = ports_.network_number(p);
  const core::can::Schedule* bus = state_->ledger().schedule(network);
  const auto counters = ports_.bus_counters(p);
  if (bus == nullptr || !counters) return false;
  auto& [strangers, told, heard] = beyond_[network];
  // Expected are what was declared, the messages of the analysis, and who is known and refused.
  std::uint64_t expected =
      bus->utilisation_ppm() -
      std::min<std::uint64_t>(bus->assumptions().background, bus->utilisation_ppm()) +
      state_->system().networks[network].bus.background;
  // Its frames and those of the bus are not counted at the same moment.
  for (const core::Heard& sender : senders) expected += sender.load + BusLoad::kStep;
  const std::uint32_t now = loads_[ports_.network_of(p)].measure(
      *counters, bus->assumptions().timing.bitrate, expected, monotonic_ns());
  if (now == strangers && senders == heard) return false;
  strangers = now;
  heard = std::move(senders);
  // A load that swings is told when it comes, when it goes, and when it is quite another.
  constexpr std::uint32_t large = 200'000;
  const std::uint32_t difference = told > now ? told - now : now - told;
  if ((told == 0) == (now == 0) && difference < large) return true;
  told = now;
  tell(Kind::interface, now != 0 ? 4 : 5,
       now != 0 ? fmt::format("{} carries at least {:.1f} % more than was admitted: somebody "
                              "sends who was not, or more than he said",
                              ports_.network_of(p), now / 1e4)
                : fmt::format("{} carries no more than was admitted again", ports_.network_of(p)),
       ports_.network_of(p));
  return true;
}

/// Who sends on the bus of a port without being granted anything, as far as its gate tells them
/// apart.
void Gateway::hear_refused(const core::Decision& decision, std::size_t port) {
  const std::size_t network = ports_.network_number(port);
  const core::can::Schedule& bus = *state_->ledger().schedule(network);
  const core::Place here{core::Place::Kind::network, network};
  for (const core::Verdict& v : decision.verdicts) {
    if (state_->members().publisher(v.publisher).place != here ||
        !hearing_.looked_at.insert(v.publisher).second)
      continue;
    auto rules = core::gate_state(state_->system(), state_->members(), v, self_);
    std::erase_if(rules, [port](const core::GateRule& rule) {
      return rule.entry.port != port || rule.entry.direction != core::Direction::ingress;
    });
    if (rules.empty()) continue;
    const Frames frames = ports_.frames(rules);
    const std::uint32_t load = senders_[{port, v.publisher}].measure(
        frames.passed + frames.dropped + frames.would_drop, rules.front().entry.max_length,
        bus.assumptions().timing.bitrate, monotonic_ns());
    if (load != 0 && !bus.contains(core::Ledger::key_of({v.publisher, network, core::Flow::kOwn})))
      hearing_.refused.push_back({v.publisher, load});
  }
}

void Gateway::events_came() {
  if (const auto read = events_->read(); !read) tell(Kind::trouble, 3, read.error().text);
}

/// Of a slot that was given to another grant meanwhile it concerns nobody any more.
void Gateway::hear(const gate_event& event) {
  if (event.kind == GATE_E_BOUND) {
    look_at_tags();
    return;
  }
  const auto channel = state_->channel_of(event.subject);
  if (!channel) return;
  for (const core::Verdict& v : state_->decisions()[*channel].verdicts)
    if (v.granted &&
        ports_.is_of(event, core::gate_state(state_->system(), state_->members(), v, self_))) {
      if (event.kind == GATE_E_MISSING) troubled_.insert(*channel);
      tell_heard(v, event);
    }
}

/// A stranger that was not heard before; the kernel sees to it that there are not too many.
void Gateway::hear(const gate_sample& sample) {
  const std::string interface = links_.name_of(static_cast<int>(sample.ifindex));
  for (std::size_t p = 0; p < ports_.size(); ++p) {
    if (ports_.interface_name(p) != interface) continue;
    tell(Kind::dropping, 4,
         fmt::format("a frame that names no known subject {} {} ({}): {}, {} bytes; {} so far",
                     sample.audit != 0 ? "would be dropped on" : "was dropped on", interface,
                     ports_.network_of(p), frame_name(sample), sample.len, sample.frames),
         ports_.network_of(p));
    return;
  }
}

/// The kernel tells it, once the newcomer has its answer and holds what it was granted.
void Gateway::tell_missing_again(const core::Verdict& v) {
  const auto told =
      ports_.tell_again(core::gate_state(state_->system(), state_->members(), v, self_));
  if (!told) tell(Kind::trouble, 3, told.error().text);
}

// --- telling -------------------------------------------------------------------------------------

control::Actor Gateway::actor_of(const serve::Peer& peer) {
  return {
      .uid = peer.uid, .user = users_.of(peer.uid), .pid = static_cast<std::uint32_t>(peer.pid)};
}

void Gateway::tell(Note note) {
  note.by = actor_;
  if (note.by) note.message += " (" + by_line(*note.by) + ")";
  journal_.write(note);
  const std::uint64_t now = unix_ns();
  if (is_history(note.kind)) ++rows_told_;
  if (history_ && is_history(note.kind))
    history_->append({now, name_of(note.kind), note.subject, note.channel, note.from,
                      note.from.empty() ? "" : note.network, note.from.empty() ? note.network : "",
                      note.message, note.by});
  if (!publish_) return;
  control::Event event;
  event.unix_ns = now;
  event.kind = name_of(note.kind);
  event.subject = note.subject;
  event.channel = std::move(note.channel);
  event.network = std::move(note.network);
  event.message = std::move(note.message);
  event.admissions = std::move(note.admissions);
  event.silent_ns = note.silent_ns;
  event.missing = note.missing;
  event.by = std::move(note.by);
  publish_(event);
}

std::vector<core::AdmissionId> Gateway::admissions_of(const core::Verdict& v) const {
  const core::Members& members = state_->members();
  return core::each_once(members.admission_of_publisher(v.publisher),
                         std::span<const std::size_t>(v.subscribers),
                         [&](std::size_t s) { return members.admission_of_subscriber(s); });
}

bool Gateway::concerns(const core::Verdict& v, core::AdmissionId id) const {
  const core::Members::Admitted ends = state_->members().admitted(id);
  return ends.publisher == v.publisher ||
         (ends.subscriber &&
          std::ranges::find(v.subscribers, *ends.subscriber) != v.subscribers.end());
}

void Gateway::tell_verdict(Kind kind, const core::Verdict& v, const std::string& line) {
  const core::EventChannel& channel = state_->system().channels[v.channel];
  tell({kind, v.granted ? 6 : 4, line, channel.subject, channel.name,
        core::name_of(state_->system(), v.to),
        core::name_of(state_->system(), state_->members().publisher(v.publisher).place),
        admissions_of(v)});
}

/// Whoever holds the publisher or a subscriber hears of it.
void Gateway::tell_heard(const core::Verdict& v, const gate_event& event) {
  const core::EventChannel& channel = state_->system().channels[v.channel];
  const core::Publisher& publisher = state_->members().publisher(v.publisher);
  const Value period = std::max<Value>(core::attributes_in(publisher, v.set)[Attribute::period], 1);
  const std::string what = fmt::format("{} ({}) of {}", channel.name,
                                       core::format_subject(channel.subject), publisher.name);
  const auto time = core::format_value(Attribute::latency, event.silent / 1'000 * 1'000);
  const bool missing = event.kind == GATE_E_MISSING;
  Note note{missing ? Kind::missing : Kind::restored,
            missing ? 4 : 5,
            {},
            channel.subject,
            channel.name,
            core::name_of(state_->system(), v.to),
            core::name_of(state_->system(), publisher.place),
            admissions_of(v)};
  note.silent_ns = event.silent;
  // Half a period is late, unless no more comes.
  note.missing = missing ? event.silent / period : (event.silent + period / 2) / period - 1;
  if (missing)
    note.message = fmt::format(
        "{} towards {}: {} {}, {} events are missing where {} may be", what, note.network,
        event.never != 0 ? "nothing has come since it was granted, for" : "nothing has come for",
        time, note.missing, v.requirement[Attribute::omission]);
  else
    note.message =
        fmt::format("{} towards {} comes again, after {} without", what, note.network, time);
  tell(std::move(note));
}

Gateway::Told Gateway::told_of(const core::State& state) {
  Told told;
  for (const core::Decision& decision : state.decisions()) {
    for (const core::Verdict& v : decision.verdicts)
      told.emplace(std::pair(core::format_subject(state.system().channels[v.channel].subject),
                             state.delivery_of(v)),
                   std::pair(v.set, verdict_line(state, v)));
    pulse();
  }
  return told;
}

/// After a start or a reload: everything that was not told before as it is, and of what was granted
/// before what is not any more.
void Gateway::tell_outcome(const Granted& before, const Told& told) {
  for (const auto& [id, why] : left_out_) {
    const auto* request = stored().admissions.find(id);
    const auto* admit = request != nullptr ? std::get_if<control::Admit>(&request->body) : nullptr;
    tell({Kind::trouble, 4, why, 0, admit != nullptr ? admit->channel : "", {}, {}, {id}});
  }
  Granted lost = before;
  for (const core::Decision& decision : state_->decisions()) {
    for (const core::Verdict& v : decision.verdicts) {
      const std::string subject =
          core::format_subject(state_->system().channels[v.channel].subject);
      const core::Delivery delivery = state_->delivery_of(v);
      const auto known = lost.find(subject);
      const bool was = known != lost.end() && std::erase(known->second.deliveries, delivery) != 0;
      const std::pair outcome(v.set, verdict_line(*state_, v));
      const auto as_told = told.find({subject, delivery});
      if (as_told != told.end() && as_told->second == outcome) continue;
      const Kind not_granted = was ? Kind::withdrawn : Kind::refused;
      tell_verdict(v.granted ? Kind::granted : not_granted, v, outcome.second);
      pulse();
    }
    pulse();
  }
  for (const auto& [subject, grants] : lost)
    for (const core::Delivery& delivery : grants.deliveries) {
      tell_gone(subject, delivery);
      pulse();
    }
}

/// Was granted, and one of those whom it concerned is not there any more.
void Gateway::tell_gone(const std::string& subject, const core::Delivery& delivery) {
  const auto channel = state_->find_channel(subject);
  const std::string name = channel ? state_->system().channels[*channel].name : subject;
  tell({Kind::withdrawn,
        4,
        fmt::format("{} ({}) of {} to {} is gone: the description has it no more", name, subject,
                    delivery.publisher, delivery.to),
        core::parse_subject(subject).value_or(0),
        name,
        delivery.to,
        {},
        delivery.admission != 0 ? std::vector{delivery.admission}
                                : std::vector<core::AdmissionId>{}});
}

void Gateway::tell_released(const std::vector<core::AdmissionId>& gone, const std::string& why) {
  for (const core::AdmissionId id : gone) {
    const auto known = state_->admissions().find(id);
    const core::EventChannel* channel =
        known != state_->admissions().end() ? &state_->system().channels[known->second] : nullptr;
    tell({Kind::released,
          5,
          fmt::format("admission {}{}: {}", id, channel != nullptr ? " of " + channel->name : "",
                      why),
          channel != nullptr ? channel->subject : 0,
          channel != nullptr ? channel->name : "",
          {},
          {},
          {id}});
  }
}

void Gateway::tell_changes(const std::vector<core::Change>& changes) {
  for (const core::Change& change : changes) {
    for (const core::Verdict& v : state_->decisions()[change.channel].verdicts) {
      const core::Verdict* old = core::same_delivery(change.before, v);
      const bool was = old != nullptr && old->granted;
      if (v.granted && !was) tell_verdict(Kind::granted, v, verdict_line(*state_, v));
      if (!v.granted && was) tell_verdict(Kind::withdrawn, v, verdict_line(*state_, v));
      if (v.granted && was && v.set != old->set)
        tell_verdict(Kind::switched, v, switch_line(*state_, v, old->set));
      pulse();
    }
  }
}

}  // namespace mlcca
