// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/gateway.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>
#include <utility>

#include "base/clock.hpp"
#include "core/admission/progress.hpp"
#include "core/gates/control_traffic.hpp"
#include "core/model/text.hpp"
#include "daemon/gates/interrupted.hpp"
#include "daemon/gateway/in_time.hpp"
#include "daemon/gateway/report.hpp"
#include "daemon/manager.hpp"
#include "description/read.hpp"

namespace mlcca {
namespace {

/// How long a start waits for the sources of links: well below the grace in which the gates stay
/// as they were.
constexpr std::uint64_t kFirstReports = 2'500'000'000;

void put_graph(core::State& state, std::size_t network, const core::mesh::LinkTable& table) {
  std::vector<std::string> addresses;
  addresses.reserve(table.graph().nodes);
  for (std::uint32_t n = 0; n < table.graph().nodes; ++n) addresses.push_back(table.address(n));
  state.set_graph(network, table.graph(), std::move(addresses));
}

std::string host_name() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) < 0) return {};
  return name.data();
}

std::expected<std::size_t, std::string> find_self(const core::System& system,
                                                  const std::string& name) {
  const std::string host = host_name();
  std::string known;
  for (std::size_t g = 0; g < system.gateways.size(); ++g) {
    if (name.empty() ? system.gateways[g].host == host : system.gateways[g].name == name) return g;
    known += (known.empty() ? "" : ", ") + system.gateways[g].name;
  }
  if (name.empty() && system.gateways.size() == 1) return 0;
  if (name.empty())
    return std::unexpected(
        fmt::format("no gateway of the description has the host '{}': say which one this is with "
                    "--gateway ({})",
                    host, known.empty() ? "it has none" : known));
  return std::unexpected(fmt::format("no gateway of the description is called '{}' (there are: {})",
                                     name, known.empty() ? "none" : known));
}

}  // namespace

Gateway::Gateway(Options options, SystemLog log, enforce::Control control, net::Links links,
                 net::FactsOf facts_of, sd_event* loop)
    : options_(std::move(options)),
      log_(std::move(log)),
      control_(std::move(control)),
      links_(std::move(links)),
      ports_(
          links_, control_, options_.bpf_root, std::move(facts_of),
          [this](const std::string& network, const std::string& line, bool problem) {
            log_.write({.kind = Kind::interface,
                        .priority = problem ? 4 : 6,
                        .message = line,
                        .network = network});
          },
          [this](Kind kind, const std::string& line, bool problem) {
            log_.write({.kind = kind, .priority = problem ? 3 : 5, .message = line});
          }),
      meshes_(
          loop, [this](std::size_t network) { dirty_meshes_.insert(network); },
          [this](const std::string& network, const std::string& line, bool problem) {
            log_.write({.kind = Kind::interface,
                        .priority = problem ? 4 : 6,
                        .message = line,
                        .network = network});
          }),
      forwarder_(std::make_unique<net::KernelCanRules>(),
                 [this](const std::string& line, bool problem) {
                   log_.write({.kind = problem ? Kind::trouble : Kind::interface,
                               .priority = problem ? 4 : 6,
                               .message = line});
                 }),
      aside_(loop),
      reading_(loop) {
  ports_.on_step([this] { pulse(); });
  plan_rounds();
}

// --- start, stop, reload -------------------------------------------------------------------------

/// Shares nothing with a gateway: may run on another thread.
Gateway::LoadResult Gateway::read(const Options& options) {
  auto system = description::read(options.description);
  if (!system) {
    StartError refused{.lines = {}, .bad_input = true};
    for (const auto& problem : system.error()) {
      refused.lines.push_back(description::to_string(problem));
      if (problem.id == core::FindingId::unreadable) refused.bad_input = false;
    }
    return std::unexpected(std::move(refused));
  }
  const auto self = find_self(*system, options.gateway);
  if (!self) return std::unexpected(StartError{{options.description + ": " + self.error()}, true});
  Loaded loaded{std::make_unique<core::State>(std::move(*system)), *self, {}};
  ::malloc_trim(0);  // reading leaves several times the memory of what was read
  return loaded;
}  // NOLINT(clang-analyzer-cplusplus.NewDeleteLeaks): the state moves with what is returned

std::string Gateway::not_read_in_time() const {
  return fmt::format(
      "{} could not be read within {}: does a look-up of users hang, or a file system?",
      options_.description, core::format_value(Attribute::latency, options_.read_limit_ns));
}

/// With what was admitted at run time.
Gateway::LoadResult Gateway::complete(LoadResult loaded) const {
  if (!loaded) return loaded;
  restore_into(*loaded);
  if (const auto lack = loaded->state->lacks_room(loaded->self))
    return std::unexpected(StartError{{options_.description + ": " + *lack}, true});
  return loaded;
}

void Gateway::restore_into(Loaded& loaded) const {
  core::State& state = *loaded.state;
  for (const control::Request& request : stored().admissions) {
    const auto* admit = std::get_if<control::Admit>(&request.body);
    if (admit == nullptr) continue;
    const auto listed = list(state, *admit);
    const auto asked =
        listed ? understand(state, *admit, request.id) : std::unexpected(listed.error());
    if (asked && asked->admission)
      state.restore(*asked->admission);
    else
      loaded.left_out.emplace(
          request.id, fmt::format("admission {} of {} is left out: {}", request.id, admit->channel,
                                  asked ? "the description has it now" : asked.error().text));
  }
  for (const std::string& subject : stored().released)
    if (const auto channel = state.find_channel(subject)) state.set_withdrawn(*channel, true);
}

/// After a start nobody is connected: leases begin anew.
void Gateway::remember_leases_and_keys() {
  for (const control::Request& request : stored().admissions) {
    const auto* admit = std::get_if<control::Admit>(&request.body);
    if (admit == nullptr) continue;
    keys_.put(admit->key, request.id);
    const std::uint64_t length = lease_of(*admit);
    if (length != 0) leases_.set(request.id, length, monotonic_ns());
  }
}

std::optional<StartError> Gateway::start() {
  started_ = std::time(nullptr);
  const auto give_up = [this](StartError why) {
    control_.close_all();
    return why;
  };
  if (const auto set = control_.set_grace(options_.grace_ns); !set)
    return give_up({{set.error().text}});
  if (auto begun = enforce::Starting::begin(control_, options_.start_limit_ns, monotonic_ns()))
    starting_.emplace(std::move(*begun));
  else
    log_.warning(Kind::trouble, "nothing is kept beyond the grace: " + begun.error().text);
  is_starting_ = true;
  const core::Progress goes_on([this] { pulse(); });
  pulse();
  auto opened =
      patience_.wait_for([this] { return store::Journal::open(options_.state_directory); });
  if (!opened) return give_up({{opened.error().text}});
  store_.emplace(std::move(*opened));
  history_.emplace(
      patience_.wait_for([this] { return store::History::open(options_.state_directory); }));
  log_.keep_in(*history_);
  auto described = in_time([options = options_] { return read(options); }, options_.read_limit_ns,
                           [this] { pulse(); });
  reads_for_ever_ = !described;
  if (!described) return give_up({{not_read_in_time()}});
  pulse();
  auto loaded = complete(std::move(*described));
  pulse();
  if (!loaded) return give_up(std::move(loaded.error()));
  scene_.state = std::move(loaded->state);
  scene_.self = loaded->self;
  loaded_ = std::time(nullptr);
  if (const auto& cut = store_->recovered()) log_.notice(Kind::trouble, *cut);
  remember_leases_and_keys();
  const Granted before = granted();

  if (const auto done = enforce::undo_interrupted_step(control_); !done)
    return give_up({{done.error().text}});
  meshes_.describe(scene_.state->system(), scene_.self);
  meshes_.await_first_reports(kFirstReports, [this] { pulse(); });
  if (const auto done = put_in_force(before); !done) log_.error(Kind::trouble, done.error().text);

  auto events = enforce::EventReader::open(control_.events_fd(),
                                           {[this](const gate_event& event) { hear(event); },
                                            [this](const gate_sample& s) { hear(s); }});
  if (!events) return give_up({{events.error().text}});
  events_.emplace(std::move(*events));
  if (const auto alive = control_.beat(monotonic_ns()); !alive)
    return give_up({{alive.error().text}});
  if (const auto armed = control_.arm(); !armed) return give_up({{armed.error().text}});
  if (control_.lapsed())
    if (const auto cleared = control_.clear_lapse(monotonic_ns()); !cleared)
      return give_up({{cleared.error().text}});
  if (starting_) starting_->finish();
  is_starting_ = false;
  forget_drops();  // what a former daemon has seen is not news
  open_unless_lost();
  log_.notice(Kind::started, "started: " + summary());
  if (control_.mode() == enforce::Mode::audit)
    log_.warning(Kind::mode, "AUDIT MODE: nothing is dropped, everything is only counted");
  left_out_ = std::move(loaded->left_out);
  report_outcome(before);
  forwarder_.act();
  commit();
  return std::nullopt;
}

void Gateway::stop() {
  control_.close_all();
  forwarder_.stop();
  log_.notice(Kind::stopped, "stopped: the gates stay in the kernel and deny everything");
  commit();
  if (history_) history_->flush(unix_ns());
}

// --- the world changes ---------------------------------------------------------------------------

/// What cannot be read changes nothing, and is read again with the next look.
void Gateway::links_changed() {
  const std::string told = links_.problem();
  const auto changed = links_.refresh();
  if (!changed && told.empty())
    log_.error(Kind::trouble,
               changed.error().text + ": what is in force stays until they can be read");
  if (changed && !told.empty()) log_.notice(Kind::trouble, "the interfaces can be read again");
  if (changed && (*changed || ports_.in_doubt())) follow_world();
  if (links_.take_tc_changed() && ports_.repair()) follow_world();
}

void Gateway::put_conditions(core::State& state) const {
  auto conditions = ports_.conditions(state.system().networks.size());
  for (const auto& [network, beyond] : beyond_) {
    if (network >= conditions.size()) continue;
    core::Condition& condition = conditions[network];
    condition.background = BusLoad::at_most(beyond.strangers);
    condition.heard = beyond.heard;
    for (core::Heard& heard : condition.heard) {
      heard.load = BusLoad::at_most(heard.load + BusLoad::kStep);
      condition.background += heard.load;
    }
  }
  for (std::size_t n = 0; n < conditions.size(); ++n) {
    conditions[n].contradicted = tags_.contradicted(n);
    state.set_condition(n, std::move(conditions[n]));
  }
}

void Gateway::put_graphs(core::State& state) const {
  for (std::size_t n = 0; n < state.system().networks.size(); ++n)
    if (const auto* table = meshes_.table(n)) put_graph(state, n, *table);
}

void Gateway::follow_world() {
  ports_.follow();
  note_ports();
  state_tags();
  put_conditions(*scene_.state);
  static_cast<void>(settle());
  // An interface that became another one needs all of its slots anew.
  static_cast<void>(enforce());
  open_unless_lost();
}

void Gateway::act() {
  const core::Progress alive([this] { pulse(); });
  for (const std::size_t n : std::exchange(dirty_meshes_, {}))
    if (const auto* table = meshes_.table(n)) put_graph(*scene_.state, n, *table);
  static_cast<void>(settle());
  forwarder_.act();  // before the answers go out
  commit();
}

Result<void> Gateway::settle(const core::FormerRules& left) {
  const std::vector<core::Change> changes = scene_.state->settle();
  if (changes.empty()) return {};
  Result<void> done = ports_.apply(scene_.state->gate_changes(changes, scene_.self, left));
  if (!done) done = enforce();
  set_bands();
  for (const core::Change& change : changes) {
    note(change.channel);
    forward(change.channel);
  }
  deliveries_.changes(changes);
  return done;
}

/// Interfaces, links and gates for a description that has just become the one in force; what was
/// granted before is served first.
Result<void> Gateway::put_in_force(const Granted& granted_before) {
  ports_.describe(scene_.state->system(), scene_.self);
  ports_.follow();
  note_ports();
  take_up_tags();
  put_conditions(*scene_.state);
  put_graphs(*scene_.state);
  dirty_meshes_.clear();
  std::map<std::size_t, core::Grants> before;
  for (const auto& [subject, grants] : granted_before) {
    if (const auto channel = scene_.state->find_channel(subject))
      before.emplace(*channel, grants);
    else
      note_granted(subject, {});
  }
  pulse();
  scene_.state->decide(before);
  for (std::size_t c = 0; c < scene_.state->decisions().size(); ++c) {
    note_granted(c);
    pulse();
  }
  return enforce();
}

void Gateway::open_unless_lost() {
  if (ports_.out_of_hand())
    control_.close_all();
  else
    control_.open();
}

Result<void> Gateway::enforce() {
  set_bands();
  pulse();
  auto wanted = scene_.state->gate_state(scene_.self);
  std::ranges::copy(core::control_rules(scene_.state->system(), scene_.self, ::geteuid()),
                    std::back_inserter(wanted));
  pulse();
  auto done = ports_.sync(wanted);
  pulse();
  note_slots(std::move(wanted));
  forward_all();
  if (!done)
    log_.error(Kind::trouble,
               "denied as a whole, because the kernel refused: " + done.error().text);
  return done;
}

void Gateway::beat() {
  auto alive = control_.beat(monotonic_ns());
  if (control_.lapsed()) links_changed();
  // We were silent for longer than the grace: what we know may be old. Look first, then open.
  if (control_.lapsed() && links_.problem().empty()) {
    follow_world();
    alive = control_.clear_lapse(monotonic_ns());
    log_.error(
        Kind::lapsed,
        fmt::format("the kernel had closed all gates because this daemon was silent for more than "
                    "{}; they follow the verdicts again",
                    core::format_value(Attribute::latency, control_.grace())));
  }
  if (!alive)
    log_.critical(Kind::trouble, "the gates close soon: no heart-beat, " + alive.error().text);
}

/// A gate that has closed meanwhile stays closed until beat() has looked.
void Gateway::pulse() {
  const std::uint64_t now = monotonic_ns();
  if (now - pulsed_ < control_.beat_interval() / 4) return;
  pulsed_ = now;
  if (is_starting_) {
    if (starting_) starting_->beat(control_, now);
    notify("EXTEND_TIMEOUT_USEC=30000000");
    return;
  }
  if (!control_.lapsed()) static_cast<void>(control_.beat(now));
  notify("WATCHDOG=1");
}

// --- reports -------------------------------------------------------------------------------------

std::vector<control::Channel> Gateway::report(
    const std::vector<const core::Verdict*>& verdicts) const {
  std::vector<control::Channel> out;
  if (verdicts.empty()) return out;
  const std::size_t channel = verdicts.front()->channel;
  const auto shared = shared_entries_of(channel);
  for (const core::Verdict* v : verdicts) {
    const auto rules =
        core::gate_state(scene_.state->system(), scene_.state->members(), *v, scene_.self);
    out.push_back(channel_report(*scene_.state, *v, ports_.frames(rules, shared)));
    if (!v->granted) continue;
    out.back().watch = ports_.watch(rules);
    out.back().troubles = troubles_of(*v, rules, shared, out.back().watch);
  }
  return out;
}

control::Channels Gateway::report_known(const Asked& asked) const {
  std::vector<const core::Verdict*> known;
  for (const core::Verdict& v : scene_.state->decisions()[asked.channel].verdicts) {
    if (asked.from && scene_.state->members().publisher(v.publisher).place != *asked.from) continue;
    if (asked.to && v.to != *asked.to) continue;
    known.push_back(&v);
  }
  return {report(known)};
}

const char* Gateway::mode_name() const {
  return control_.mode() == enforce::Mode::audit ? "audit" : "enforce";
}

std::string Gateway::summary() const {
  return fmt::format("{} of {}: {} granted, {} refused, {}{}",
                     scene_.state->system().gateways[scene_.self].name, scene_.state->system().name,
                     scene_.state->granted(), scene_.state->refused(), mode_name(),
                     control_.is_open() ? "" : ", closed");
}

}  // namespace mlcca
