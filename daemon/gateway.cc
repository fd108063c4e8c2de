// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "core/text.hpp"
#include "daemon/report.hpp"
#include "description/read.hpp"

namespace mlcca {
namespace {

std::uint64_t monotonic_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000 +
         static_cast<std::uint64_t>(now.tv_nsec);
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

Gateway::Gateway(Options options, Journal journal, enforce::Control control, net::Links links,
                 net::FactsOf facts_of)
    : options_(std::move(options)),
      journal_(journal),
      control_(std::move(control)),
      links_(std::move(links)),
      ports_(links_, control_, options_.bpf_root, std::move(facts_of),
             [this](const std::string& network, const std::string& line, bool problem) {
               tell({Kind::interface, problem ? 4 : 6, line, 0, {}, network});
             }),
      store_(options_.state_directory) {}

// --- start, stop, reload -------------------------------------------------------------------------

Gateway::LoadResult Gateway::load() const {
  auto system = description::read(options_.description);
  if (!system) {
    std::vector<std::string> lines;
    for (const auto& problem : system.error()) lines.push_back(description::to_string(problem));
    return std::unexpected(std::move(lines));
  }
  const auto self = find_self(*system, options_.gateway);
  if (!self) return std::unexpected(std::vector{options_.description + ": " + self.error()});
  Loaded loaded{std::make_unique<core::State>(std::move(*system)), *self, {}};
  restore_into(loaded);
  ::malloc_trim(0);  // reading leaves several times the memory of what was read
  return loaded;
}  // NOLINT(clang-analyzer-cplusplus.NewDeleteLeaks): the state moves with what is returned

void Gateway::restore_into(Loaded& loaded) const {
  core::State& state = *loaded.state;
  for (const control::Request& request : stored_.admissions) {
    const auto* admit = std::get_if<control::Admit>(&request.body);
    if (admit == nullptr) continue;
    const auto asked = understand(state, *admit, request.id);
    if (asked && asked->admission)
      state.restore(*asked->admission);
    else
      loaded.left_out.push_back(
          fmt::format("admission {} of {} is left out: {}", request.id, admit->channel,
                      asked ? "the description has it now" : asked.error().text));
  }
  for (const std::string& subject : stored_.released)
    if (const auto channel = state.find_channel(subject)) state.set_released(*channel, true);
}

std::optional<StartError> Gateway::start() {
  started_ = std::time(nullptr);
  const auto give_up = [this](std::vector<std::string> lines, bool bad_input) {
    control_.close_all();
    return StartError{std::move(lines), bad_input};
  };
  if (const auto set = control_.set_grace(options_.grace_ns); !set)
    return give_up({set.error().text}, false);
  auto contents = store_.load();
  if (!contents) return give_up({contents.error().text}, true);
  stored_ = std::move(*contents);
  auto loaded = load();
  if (!loaded) return give_up(std::move(loaded.error()), true);
  state_ = std::move(loaded->state);
  self_ = loaded->self;
  loaded_ = std::time(nullptr);
  for (std::string& line : loaded->left_out) tell({Kind::trouble, 4, std::move(line), 0, {}, {}});

  ports_.describe(state_->system(), self_);
  ports_.follow();
  state_->set_conditions(ports_.conditions(state_->system().networks.size()));
  state_->decide();
  if (const auto done = ports_.sync(state_->gate_state(self_)); !done)
    tell({Kind::trouble, 3, done.error().text, 0, {}, {}});

  control_.beat(monotonic_ns());
  if (const auto armed = control_.arm(); !armed) return give_up({armed.error().text}, false);
  if (control_.lapsed()) control_.clear_lapse(monotonic_ns());
  look_at_drops(false);  // what a former daemon has seen is not news
  open_unless_lost();
  tell({Kind::started, 5, "started: " + summary(), 0, {}, {}});
  if (control_.mode() == enforce::Mode::audit)
    tell({Kind::mode, 4, "AUDIT MODE: nothing is dropped, everything is only counted", 0, {}, {}});
  for (const auto& verdicts : state_->decision().channels)
    for (const core::Verdict& v : verdicts)
      tell_verdict(v.granted ? Kind::granted : Kind::refused, v);
  return std::nullopt;
}

void Gateway::stop() {
  control_.close_all();
  tell({Kind::stopped, 5, "stopped: the gates stay in the kernel and deny everything", 0, {}, {}});
}

// --- the world changes ---------------------------------------------------------------------------

void Gateway::links_changed() {
  const auto changed = links_.refresh();
  if (!changed)
    tell({Kind::trouble, 3, changed.error().text, 0, {}, {}});
  else if (*changed)
    follow_world();
}

void Gateway::follow_world() {
  ports_.follow();
  const auto before = state_->decision().channels;
  if (state_->set_conditions(ports_.conditions(state_->system().networks.size()))) state_->decide();
  static_cast<void>(enforce());
  open_unless_lost();
  tell_changes(before);
}

void Gateway::open_unless_lost() {
  if (ports_.out_of_hand())
    control_.close_all();
  else
    control_.open();
}

Result<void> Gateway::enforce() {
  auto done = ports_.sync(state_->gate_state(self_));
  if (!done)
    tell({Kind::trouble,
          3,
          "denied as a whole, because the kernel refused: " + done.error().text,
          0,
          {},
          {}});
  return done;
}

void Gateway::beat() {
  if (control_.lapsed()) {
    // We were silent for longer than the grace: what we know may be old. Look first, then open.
    links_changed();
    follow_world();
    control_.clear_lapse(monotonic_ns());
    tell(
        {Kind::lapsed,
         3,
         fmt::format("the kernel had closed all gates because this daemon was silent for more than "
                     "{}; they follow the verdicts again",
                     core::format_value(Attribute::latency, control_.grace())),
         0,
         {},
         {}});
  }
  control_.beat(monotonic_ns());
}

void Gateway::look_around() {
  if (ports_.repair()) follow_world();
  look_at_drops(true);
}

void Gateway::look_at_drops(bool mention) {
  const auto now = static_cast<std::int64_t>(monotonic_ns() / 1'000'000'000);
  for (const auto& verdicts : state_->decision().channels) {
    for (const core::Verdict& v : verdicts) {
      const core::EventChannel& c = state_->system().channels[v.channel];
      const core::Publisher& publisher = state_->members().publisher(v.publisher);
      const std::string& to = core::name_of(state_->system(), v.to);
      const auto dropped =
          drops_.look(c.name + " " + publisher.name + " " + to, frames_of(v).dropped, now);
      if (!dropped || !mention) continue;
      const std::string line =
          v.granted ? fmt::format("{} frames dropped that named {} ({}) and differ from the grant",
                                  *dropped, c.name, core::format_subject(c.subject))
                    : fmt::format("{} frames dropped of {}", *dropped, verdict_line(*state_, v));
      tell({Kind::dropping, 4, line, c.subject, c.name,
            core::name_of(state_->system(), publisher.place)});
    }
  }
  for (std::size_t p = 0; p < ports_.size(); ++p) {
    const auto dropped = drops_.look("unknown " + std::to_string(p), ports_.unknown_frames(p), now);
    if (dropped && mention)
      tell({Kind::dropping,
            4,
            fmt::format("{} frames without a known subject dropped on {} ({})", *dropped,
                        ports_.interface_name(p), ports_.network_of(p)),
            0,
            {},
            ports_.network_of(p)});
  }
}

// --- telling -------------------------------------------------------------------------------------

void Gateway::tell(Note note) {
  journal_.write(note);
  if (!publish_) return;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  control::Event event;
  event.unix_ns =
      static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(now).count());
  event.kind = name_of(note.kind);
  event.subject = note.subject;
  event.channel = std::move(note.channel);
  event.network = std::move(note.network);
  event.message = std::move(note.message);
  publish_(event);
}

void Gateway::tell_verdict(Kind kind, const core::Verdict& v) {
  const core::EventChannel& channel = state_->system().channels[v.channel];
  tell({kind, v.granted ? 6 : 4, verdict_line(*state_, v), channel.subject, channel.name,
        core::name_of(state_->system(), v.to)});
}

void Gateway::tell_changes(const std::vector<std::vector<core::Verdict>>& before) {
  const auto& now = state_->decision().channels;
  for (std::size_t c = 0; c < now.size(); ++c) {
    for (const core::Verdict& v : now[c]) {
      const auto old = std::ranges::find_if(before[c], [&v](const core::Verdict& o) {
        return o.publisher == v.publisher && o.to == v.to;
      });
      const bool was = old != before[c].end() && old->granted;
      if (v.granted && !was) tell_verdict(Kind::granted, v);
      if (!v.granted && was) tell_verdict(Kind::withdrawn, v);
    }
  }
}

Frames Gateway::frames_of(const core::Verdict& v) const {
  return ports_.frames(
      core::gate_state(state_->system(), state_->members(), v.channel, {v}, self_));
}

control::Channel Gateway::report(const core::Verdict& v) const {
  return channel_report(*state_, v, frames_of(v));
}

control::Channels Gateway::report_known(const Asked& asked) const {
  control::Channels out;
  for (const core::Verdict& v : state_->decision().channels[asked.channel]) {
    if (asked.from && state_->members().publisher(v.publisher).place != *asked.from) continue;
    if (asked.to && v.to != *asked.to) continue;
    out.channels.push_back(report(v));
  }
  return out;
}

const char* Gateway::mode_name() const {
  return control_.mode() == enforce::Mode::audit ? "audit" : "enforce";
}

std::string Gateway::summary() const {
  std::size_t granted = 0;
  std::size_t refused = 0;
  for (const auto& verdicts : state_->decision().channels)
    for (const core::Verdict& v : verdicts) ++(v.granted ? granted : refused);
  return fmt::format("{} of {}: {} granted, {} refused, {}{}",
                     state_->system().gateways[self_].name, state_->system().name, granted, refused,
                     mode_name(), control_.is_open() ? "" : ", closed");
}

}  // namespace mlcca
