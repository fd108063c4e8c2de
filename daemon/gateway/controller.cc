// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/controller.hpp"

#include <fmt/core.h>
#include <malloc.h>

#include <utility>
#include <vector>

#include "core/model/progress.hpp"
#include "core/model/text.hpp"
#include "daemon/gateway/in_time.hpp"
#include "daemon/gateway/requests/table.hpp"

namespace mlcca {
namespace {

/// The time for which a start waits for the sources of links, in ns. It is well below the grace in
/// which the gates stay as they were.
constexpr std::uint64_t kFirstReports = 2'500'000'000;

void put_graph(core::State& state, std::size_t network, const core::mesh::LinkTable& table) {
  std::vector<std::string> addresses;
  addresses.reserve(table.graph().nodes);
  for (std::uint32_t n = 0; n < table.graph().nodes; ++n) addresses.push_back(table.address(n));
  state.set_graph(network, table.graph(), std::move(addresses));
}

}  // namespace

Controller::Controller(Options options, Outside outside)
    : options_(std::move(options)),
      outside_(std::move(outside)),
      meshes_(
          outside_.loop, [this](std::size_t network) { changed_meshes_.insert(network); },
          [this](const std::string& network, const std::string& line, bool problem) {
            if (problem)
              outside_.log.warning(Kind::interface, line, {.network = network});
            else
              outside_.log.info(Kind::interface, line, {.network = network});
          }),
      rollout_(make_rollout()),
      membership_(make_membership()),
      safeguards_(outside_.control, outside_.log, options_.bpf_root),
      reloads_({options_, [this] { return reader(); }, outside_.reading, outside_.clock,
                outside_.gates, scene_, outside_.log, deliveries_, delivery_health_, drops_,
                recorder_, turn_, admissions_, buses_, meshes_,
                [this](const DeliveryEvents::Granted& before) {
                  return put_in_force(before, TagBindings::Known::by_gates);
                },
                [this] { return summary(); },
                [this](uid_t user, std::uint64_t rows) {
                  quotas_.charge(user, rows, outside_.clock.monotonic_ns());
                },
                pulse_}),
      health_({scene_, outside_.gates, outside_.control, outside_.links, meshes_, recorder_,
               forwarding_, safeguards_, reloads_, tags_, admissions_, delivery_health_, presence_,
               outside_.clock, modes_, membership_.get()}),
      aside_(outside_.loop) {
  outside_.gates.on_step(pulse_);
  turn_.add(buses_);
  turn_.add(tags_);
  turn_.on_lost([this](const auto& lost) { admissions_.take_back(lost); });
  on_commit([](const auto&) {});
  if (membership_) {
    admissions_.on_gone([this](const auto& gone) { membership_->admissions_gone(gone); });
    admissions_.need_agreements();
  }
  turn_.on_changed([this](const core::Change& change) {
    drops_.verdicts_changed(change);
    delivery_health_.restart(change.channel);
  });
  drops_.on_polled([this](const auto& polled) { delivery_health_.judge(polled); });
  plan_rounds();
}

// --- start and stop ------------------------------------------------------------------------------

std::optional<StartError> Controller::start() {
  const core::Progress goes_on(pulse_);
  auto failure = begin_start();
  if (!failure) failure = read_what_was();
  if (!failure) failure = open_gates();
  if (failure) outside_.control.close_all();
  return failure;
}

/// First step of a start. Whatever a previous daemon has left in the gates stays in force.
std::optional<StartError> Controller::begin_start() {
  started_ = outside_.clock.unix_ns() / 1'000'000'000;
  if (const auto set = outside_.control.set_grace(options_.grace_ns); !set)
    return StartError{{set.error().text}};
  if (const auto begun = heartbeat_.begin_start(options_.start_limit_ns); !begun)
    outside_.log.warning(Kind::trouble, "nothing is kept after the grace: " + begun.error().text);
  heartbeat_.pulse();
  return std::nullopt;
}

/// Second step of a start: reads the journal, the history and the description.
std::optional<StartError> Controller::read_what_was() {
  if (const auto opened = recorder_.open(options_.state_directory, outside_.disk); !opened)
    return StartError{{opened.error().text}};
  history_.emplace(
      patience_.wait_for([this] { return store::History::open(options_.state_directory); }));
  outside_.log.keep_in(*history_);
  if (rollout_) rollout_->restore(recorder_.contents().membership);
  const ReadDescription from = reader();
  auto read =
      outside_.threads ? in_time(from, options_.read_limit_ns, pulse_) : std::optional(from());
  reads_for_ever_ = !read;
  if (!read) return StartError{{not_read_in_time(options_)}};
  heartbeat_.pulse();
  DescribedResult& described = *read;
  if (!described) return described.error();
  for (const std::string& note : described->notes) outside_.log.warning(Kind::trouble, note);
  auto left_out = reloads_.complete(*described);
  heartbeat_.pulse();
  if (!left_out) return left_out.error();
  scene_.state = std::move(described->state);
  scene_.self = described->self;
  scene_.digest = described->digest;
  scene_.file_digest = described->file_digest;
  scene_.unchecked = described->unchecked;
  scene_.text = std::move(described->text);
  admissions_.set_left_out(std::move(*left_out));
  reloads_.note_loaded();
  if (const auto& cut = recorder_.recovered()) outside_.log.notice(Kind::trouble, *cut);
  admissions_.remember();
  context_.emplace(Context{options_,
                           outside_.clock,
                           outside_.gates,
                           outside_.control,
                           scene_,
                           outside_.log,
                           deliveries_,
                           turn_,
                           recorder_,
                           admissions_,
                           tags_,
                           gate_events_,
                           audit_,
                           audit_keeper_,
                           modes_,
                           delivery_health_,
                           health_,
                           channels_,
                           endpoints_,
                           carriers_,
                           presence_,
                           local_ends_,
                           forwarding_,
                           meshes_,
                           reloads_,
                           aside_,
                           patience_,
                           *history_,
                           membership_.get(),
                           started_});
  return std::nullopt;
}

/// Last step of a start: writes the decided slots to the gates, and lets the gates use their
/// verdicts.
std::optional<StartError> Controller::open_gates() {
  const auto before = recorder_.granted();
  GateControl& control = outside_.control;
  modes_.begin(options_.initial_audit);
  if (const auto done = control.undo_interrupted_step(); !done)
    return StartError{{done.error().text}};
  meshes_.describe(scene_.state->system(), scene_.self);
  meshes_.await_first_reports(kFirstReports, pulse_);
  presence_.start();
  if (membership_) {
    membership_->begin();
    membership_->await(kFirstReports);
  }
  if (const auto done = put_in_force(before, TagBindings::Known::by_gates_and_disk); !done)
    outside_.log.error(Kind::trouble, done.error().text);
  if (membership_) membership_->in_force();
  if (const auto uncapped = forget_cap(); !uncapped) return StartError{{uncapped.error().text}};
  if (const auto done =
          control.listen({[this](const gate_event& event) { gate_events_.on_event(event); },
                          [this](const gate_sample& sample) { gate_events_.on_sample(sample); }});
      !done)
    return StartError{{done.error().text}};
  if (const auto alive = control.beat(outside_.clock.monotonic_ns()); !alive)
    return StartError{{alive.error().text}};
  if (const auto armed = control.arm(); !armed) return StartError{{armed.error().text}};
  if (control.lapsed())
    if (const auto cleared = control.clear_lapse(outside_.clock.monotonic_ns()); !cleared)
      return StartError{{cleared.error().text}};
  heartbeat_.end_start();
  presence_.start();  // during the start nobody could announce itself
  delivery_health_.forget(pulse_);
  drops_.forget();  // what a previous daemon has counted is not reported again
  turn_.open_unless_lost();
  outside_.log.notice(Kind::started, "started: " + summary());
  modes_.report();
  if (history_) audit_keeper_.restore(*history_);
  admissions_.report_left_out();
  deliveries_.outcome(before, {});
  forwarding_.act();
  turn_.commit();
  return std::nullopt;
}

bool Controller::begin_stop() {
  if (!membership_) return true;
  membership_->leave();
  return membership_->may_end();
}

void Controller::stop() {
  outside_.control.close_all();
  forwarding_.stop();
  outside_.log.notice(Kind::stopped, "stopped: the gates stay in the kernel and deny everything");
  turn_.commit();
  if (!history_) return;
  history_->flush(outside_.clock.unix_ns());
  static_cast<void>(audit_keeper_.keep(*history_));
}

/// Sets up interfaces, links and gates for a description that has just come into force. What was
/// granted before is decided first.
Result<void> Controller::put_in_force(const DeliveryEvents::Granted& granted_before,
                                      TagBindings::Known known) {
  core::State& state = *scene_.state;
  outside_.gates.describe(state.system(), scene_.self);
  outside_.gates.follow();
  if (!outside_.gates.change()) return outside_.gates.change();
  recorder_.note_ports();
  tags_.take_up(known);
  turn_.observe();
  put_graphs();
  note_presence();
  if (membership_) {
    membership_->take_up();
    tags_.take_up(known);  // with the tags that others have asked for
  }
  std::map<std::size_t, core::Grants> before;
  for (const auto& [subject, grants] : granted_before) {
    if (const auto channel = state.find_channel(subject))
      before.emplace(*channel, grants);
    else
      recorder_.note_gone(subject);
  }
  heartbeat_.pulse();
  state.decide(before);
  for (std::size_t c = 0; c < state.decisions().size(); ++c) {
    recorder_.note_granted(c);
    heartbeat_.pulse();
  }
  return turn_.enforce();
}

void Controller::put_graphs() {
  for (std::size_t n = 0; n < scene_.state->system().networks.size(); ++n)
    if (const auto* table = meshes_.table(n)) put_graph(*scene_.state, n, *table);
  changed_meshes_.clear();
}

// --- changes of the world ------------------------------------------------------------------------

void Controller::reconcile() {
  const core::Progress alive(pulse_);
  outside_.gates.follow();
  recorder_.note_ports();
  tags_.state();
  turn_.observe();
  static_cast<void>(turn_.settle());
  // If a port has another interface now, all of its slots must be written again.
  static_cast<void>(turn_.enforce());
  turn_.open_unless_lost();
}

/// If the interfaces cannot be read, nothing changes, and they are read again in the next round.
void Controller::links_changed() {
  const core::Progress alive(pulse_);
  LinkMonitor& links = outside_.links;
  const std::string former_problem = links.problem();
  const auto changed = links.refresh();
  if (!changed && former_problem.empty())
    outside_.log.error(Kind::trouble,
                       changed.error().text + ": what is in force stays until they can be read");
  if (changed && !former_problem.empty())
    outside_.log.notice(Kind::trouble, "the interfaces can be read again");
  if (changed && (outside_.gates.needs_recheck() || (*changed && outside_.gates.needs_reconcile())))
    reconcile();
  if (links.take_tc_changed() && outside_.gates.repair()) reconcile();
}

void Controller::gates_reported() {
  if (const auto read = outside_.control.read_reports(); !read)
    outside_.log.error(Kind::trouble, read.error().text);
}

void Controller::act() {
  const core::Progress alive(pulse_);
  for (const std::size_t n : std::exchange(changed_meshes_, {}))
    if (const auto* table = meshes_.table(n)) put_graph(*scene_.state, n, *table);
  note_presence();
  if (membership_)
    membership_->act();
  else
    static_cast<void>(turn_.settle());
  forwarding_.act();  // before clients get their answers
  turn_.commit();
}

void Controller::beat() {
  GateControl& control = outside_.control;
  const std::uint64_t now = outside_.clock.monotonic_ns();
  const Lapse reason =
      control.until() != 0 && control.until() <= now ? Lapse::lease : Lapse::heartbeat;
  auto alive = control.beat(now);
  if (control.lapsed()) links_changed();
  // No heart-beat was given for longer than the grace, so our knowledge may be outdated. Reconcile
  // first, then open.
  if (control.lapsed() && outside_.links.problem().empty()) {
    if (membership_) membership_->expire();
    reconcile();
    alive = control.clear_lapse(outside_.clock.monotonic_ns());
    health_.note_lapse(reason);
    outside_.log.error(
        Kind::lapsed,
        fmt::format("the kernel had closed all gates because {}; they follow the verdicts again",
                    words_of(reason, core::format_value(Attribute::latency, control.grace()))));
  }
  if (!alive)
    outside_.log.critical(Kind::trouble,
                          "the gates close soon: no heart-beat, " + alive.error().text);
}

// --- requests ------------------------------------------------------------------------------------

serve::Answer Controller::answer(const control::Request& request, const serve::Peer& peer) {
  const bool changes = requests::privilege_of(request) == requests::Privilege::member;
  if (changes && !peer.may_change)
    return {{request.id,
             error_of(control::ErrorKind::forbidden,
                      fmt::format("only root and members of the group {} may change anything",
                                  options_.group))}};
  const bool counts = requests::trace_of(request) == requests::Trace::history;
  if (counts && !requests::takes_away(*context_, request))
    if (const auto why = quotas_.refuse_change(peer.uid, outside_.clock.monotonic_ns(),
                                               requests::least_rows_of(request)))
      return {{request.id, failed("nothing was changed: " + *why)}};
  const core::Progress alive(pulse_);
  const EventLog::Acting acting(outside_.log,
                                changes ? std::optional(actor_of(peer)) : std::nullopt);
  const std::uint64_t rows = outside_.log.rows();
  Response response = requests::handle(*context_, {peer, request.slices}, request);
  if (counts) quotas_.charge(peer.uid, outside_.log.rows() - rows, outside_.clock.monotonic_ns());
  if (!response.held) forwarding_.act();
  return {{request.id, std::move(response.body)},
          response.held,
          response.owned,
          response.follows,
          std::move(response.slices),
          response.least_bytes};
}

control::Actor Controller::actor_of(const serve::Peer& peer) {
  return {
      .uid = peer.uid, .user = users_.of(peer.uid), .pid = static_cast<std::uint32_t>(peer.pid)};
}

void Controller::on_slice(const Aside::Ready& ready) {
  reloads_.on_ready(ready);
  aside_.on_ready(ready);
  if (membership_) membership_->on_ready(ready);
}

std::string Controller::summary() const {
  const core::State& state = *scene_.state;
  return fmt::format("{} of {}: {} granted, {} refused, {}{}",
                     state.system().gateways[scene_.self].name, state.system().name,
                     state.granted(), state.refused(), modes_.name(),
                     outside_.control.is_open() ? "" : ", closed");
}

// --- rounds --------------------------------------------------------------------------------------

/// Each job of a round does a bounded amount: one item of many, or a few short ones.
void Controller::plan_rounds() {
  const auto once = [this](auto work) {
    rounds_.add([work] {
      work();
      return false;
    });
  };
  once([this] { poll_surroundings(); });
  rounds_.add([this] { return repair_next(); });
  rounds_.add([this] { return admissions_.end_some(); });
  rounds_.add([this] { return buses_.poll_some(); });
  rounds_.add([this] { return drops_.poll_some_channels(); });
  rounds_.add([this] { return drops_.tidy(); });
  rounds_.add([this] { return drops_.poll_some_ports(); });
  once([this] { silences_.poll(); });
  once([this] { modes_.poll(); });
  once([this] {
    if (history_) audit_keeper_.poll(*history_);
  });
  rounds_.add([this] { return poll_next_bypass(); });
  once([this] { tags_.poll(); });
  once([this] { tags_.ask(); });
  rounds_.add([this] { return write_some_history(); });
}

/// Polls what does not depend on the number of channels or ports. All rules of can-gw are read in
/// one answer.
void Controller::poll_surroundings() {
  safeguards_.poll();
  if (!outside_.links.problem().empty() || outside_.gates.needs_recheck()) links_changed();
  outside_.gates.begin_repair();
  at_gate_ = 0;
  recorder_.keep();
  forwarding_.poll();
  if (membership_) membership_->poll();
  aside_.poll();
  reloads_.poll();
}

bool Controller::repair_next() {
  if (const auto gate = outside_.gates.next_gate(at_gate_)) {
    at_gate_ = *gate;
    // The changes take effect at once: otherwise a client whose turn comes in between would get
    // reports of changes that have no effect on an interface without a gate.
    if (!outside_.gates.repair(*gate)) reconcile();
    return true;
  }
  at_gate_ = 0;
  if (outside_.gates.wants_gate()) reconcile();
  return false;
}

bool Controller::poll_next_bypass() {
  const auto gate = outside_.gates.next_gate(at_gate_);
  at_gate_ = gate.value_or(0);
  if (gate) outside_.gates.check_bypass(*gate, outside_.clock.monotonic_s());
  return gate.has_value();
}

bool Controller::write_some_history() {
  if (!history_) return false;
  const std::uint64_t now = outside_.clock.unix_ns();
  const bool more = patience_.wait_for([this, now] { return history_->flush_some(now); });
  for (std::string& line : history_->take_troubles())
    outside_.log.warning(Kind::trouble, std::move(line));
  // The events of a start or reload fill some MiB until they are written.
  if (!more && writes_much_history_) ::malloc_trim(0);
  writes_much_history_ = more;
  return more;
}

}  // namespace mlcca
