// SPDX-License-Identifier: BSD-2-Clause
// What clients ask of the gateway, one handle() for each kind of request.
#include <fmt/core.h>

#include <algorithm>
#include <utility>
#include <variant>

#include "control/version.hpp"
#include "core/text.hpp"
#include "daemon/gateway.hpp"
#include "daemon/report.hpp"

namespace mlcca {
namespace {

bool wants_change(const control::Request& request) {
  return std::holds_alternative<control::Admit>(request.body) ||
         std::holds_alternative<control::ReleaseRequest>(request.body) ||
         std::holds_alternative<control::ModeRequest>(request.body) ||
         std::holds_alternative<control::ReloadRequest>(request.body);
}

control::Error error(control::ErrorKind kind, std::string message) {
  return {kind, std::move(message), {}};
}

}  // namespace

Gateway::Body Gateway::handle(const control::ReloadRequest&) {
  auto loaded = load();
  if (!loaded) {
    last_error_ = loaded.error().front();
    tell({Kind::reload,
          3,
          fmt::format("reload refused, nothing changed: {}{}", last_error_,
                      loaded.error().size() > 1
                          ? fmt::format(" (and {} more)", loaded.error().size() - 1)
                          : ""),
          0,
          {},
          {}});
    return control::Error{control::ErrorKind::unreadable,
                          "the description cannot be used, nothing was changed",
                          std::move(loaded.error())};
  }
  last_error_.clear();
  const std::size_t old_self = std::exchange(self_, loaded->self);
  auto old = std::exchange(state_, std::move(loaded->state));
  if (const auto done = settle(); !done) {
    state_ = std::move(old);
    self_ = old_self;
    last_error_ = done.error().text;
    tell({Kind::reload, 3, "reload refused, back to what was: " + last_error_, 0, {}, {}});
    static_cast<void>(settle());
    return error(control::ErrorKind::world, last_error_);
  }
  loaded_ = std::time(nullptr);
  for (std::string& line : loaded->left_out) tell({Kind::trouble, 4, std::move(line), 0, {}, {}});
  tell({Kind::reload, 5, "reloaded: " + summary(), 0, {}, {}});
  for (const auto& verdicts : state_->decision().channels)
    for (const core::Verdict& v : verdicts)
      tell_verdict(v.granted ? Kind::granted : Kind::refused, v);
  return control::Done{"reloaded: " + summary()};
}

/// Brings interfaces and gates in line with a description that has just become the one in force.
Result<void> Gateway::settle() {
  ports_.describe(state_->system(), self_);
  ports_.follow();
  state_->set_conditions(ports_.conditions(state_->system().networks.size()));
  state_->decide();
  auto done = enforce();
  drops_.forget();
  look_at_drops(false);
  open_unless_lost();
  return done;
}

control::Reply Gateway::answer(const control::Request& request, const serve::Peer& peer) {
  if (wants_change(request) && !peer.may_change)
    return {request.id,
            error(control::ErrorKind::forbidden,
                  fmt::format("only root and members of the group {} may change anything",
                              options_.group))};
  return {request.id, std::visit([this](const auto& body) { return handle(body); }, request.body)};
}

Gateway::Body Gateway::handle(const control::StatusRequest&) {
  control::Status s;
  s.version = kVersion;
  s.gateway = state_->system().gateways[self_].name;
  s.system = state_->system().name;
  s.description_file = options_.description;
  s.mode = mode_name();
  s.open = control_.is_open() && !control_.lapsed();
  s.grace_ns = control_.grace();
  s.lapses = control_.lapses();
  for (const auto& verdicts : state_->decision().channels)
    for (const core::Verdict& v : verdicts) ++(v.granted ? s.channels_granted : s.channels_refused);
  s.started_unix_s = static_cast<std::uint64_t>(started_);
  s.loaded_unix_s = static_cast<std::uint64_t>(loaded_);
  s.last_error = last_error_;
  if (ports_.out_of_hand()) s.problem = "an interface cannot be held: everything is denied";
  s.interfaces = ports_.report();
  return s;
}

Gateway::Body Gateway::handle(const control::NetworksRequest&) {
  control::Networks out;
  for (std::size_t n = 0; n < state_->system().networks.size(); ++n)
    out.networks.push_back(network_report(*state_, n));
  return out;
}

Gateway::Body Gateway::handle(const control::ChannelsRequest&) {
  control::Channels out;
  for (const auto& verdicts : state_->decision().channels)
    for (const core::Verdict& v : verdicts) out.channels.push_back(report(v));
  return out;
}

Gateway::Body Gateway::handle(const control::ExplainRequest& request) {
  const auto channel = channel_named(*state_, request.channel);
  if (!channel) return error(control::ErrorKind::invalid, channel.error().text);
  return report_known({*channel, {}, {}, {}});
}

Gateway::Body Gateway::answer_to(const core::Proposal& proposal, const Asked& asked,
                                 const char* to_do) const {
  control::Channels out;
  for (const core::Verdict* v : proposal.verdicts())
    out.channels.push_back(channel_report(*state_, *v, {}));
  if (!out.channels.empty()) return out;
  return error(control::ErrorKind::invalid,
               fmt::format("nobody {} {}: there is nothing to {}",
                           asked.admission->publisher ? "subscribes" : "publishes",
                           state_->system().channels[asked.channel].name, to_do));
}

Gateway::Body Gateway::handle(const control::Query& request) {
  const auto asked = understand(*state_, request, stored_.next_id);
  if (!asked) return error(control::ErrorKind::invalid, asked.error().text);
  if (!asked->admission) return report_known(*asked);
  return answer_to(state_->propose(*asked->admission), *asked, "decide");
}

Gateway::Body Gateway::admit_known(const Asked& asked) {
  if (state_->released(asked.channel)) {
    const auto before = state_->decision().channels;
    store::Contents next = stored_;
    std::erase(next.released,
               core::format_subject(state_->system().channels[asked.channel].subject));
    if (const auto saved = store_.save(next); !saved)
      return error(control::ErrorKind::world, saved.error().text);
    stored_ = std::move(next);
    state_->set_released(asked.channel, false);
    state_->decide();
    const auto done = enforce();
    tell_changes(before);
    if (!done) return error(control::ErrorKind::world, done.error().text);
  }
  return report_known(asked);
}

Gateway::Body Gateway::handle(const control::Admit& request) {
  const auto asked = understand(*state_, request, stored_.next_id);
  if (!asked) return error(control::ErrorKind::invalid, asked.error().text);
  if (!asked->admission) return admit_known(*asked);

  core::Proposal proposal = state_->propose(*asked->admission);
  Body out = answer_to(proposal, *asked, "admit");
  if (!proposal.fit()) {
    for (const core::Verdict* v : proposal.verdicts())
      if (!v->granted) tell_verdict(Kind::refused, *v);
    return out;
  }
  const core::GateChanges changes = proposal.changes(self_);
  if (const auto done = ports_.apply(changes); !done)
    return error(control::ErrorKind::world, "nothing was changed: " + done.error().text);
  store::Contents next = stored_;
  next.admissions.push_back({next.next_id, request});
  ++next.next_id;
  if (const auto saved = store_.save(next); !saved) {
    static_cast<void>(ports_.sync(state_->gate_state(self_)));
    return error(control::ErrorKind::world, "nothing was changed: " + saved.error().text);
  }
  stored_ = std::move(next);
  std::vector<core::Verdict> granted;
  for (const core::Verdict* v : proposal.verdicts()) granted.push_back(*v);
  std::move(proposal).accept();
  for (const core::Verdict& v : granted) tell_verdict(Kind::granted, v);
  return out;
}

Gateway::Body Gateway::handle(const control::ReleaseRequest& request) {
  store::Contents next = stored_;
  std::vector<core::AdmissionId> gone;
  std::optional<std::size_t> channel;
  if (request.admission != 0) {
    gone.push_back(request.admission);
  } else {
    const auto named = channel_named(*state_, request.channel);
    if (!named) return error(control::ErrorKind::invalid, named.error().text);
    channel = *named;
    for (const core::Admission& a : state_->admissions())
      if (a.channel == *channel) gone.push_back(a.id);
  }
  const auto removed = std::erase_if(next.admissions, [&gone](const control::Request& r) {
    return std::ranges::find(gone, r.id) != gone.end();
  });
  if (request.admission != 0 && removed == 0)
    return error(control::ErrorKind::invalid,
                 fmt::format("there is no admission {}", request.admission));
  std::string what = fmt::format("admission {}", request.admission);
  core::Subject subject = 0;
  if (channel) {
    const core::EventChannel& c = state_->system().channels[*channel];
    subject = c.subject;
    what = c.name;
    const std::string text = core::format_subject(subject);
    if (std::ranges::find(next.released, text) == next.released.end())
      next.released.push_back(text);
  }
  const auto before = state_->decision().channels;
  if (const auto saved = store_.save(next); !saved)
    return error(control::ErrorKind::world, "nothing was changed: " + saved.error().text);
  stored_ = std::move(next);
  for (const core::AdmissionId id : gone) state_->remove(id);
  if (channel) state_->set_released(*channel, true);
  state_->decide();
  const auto done = enforce();
  tell({Kind::released, 5, "released by the operator: " + what, subject, channel ? what : "", {}});
  if (!done) return error(control::ErrorKind::world, done.error().text);
  tell_changes(before);
  return control::Done{"released " + what};
}

// NOLINTNEXTLINE(readability-convert-member-functions-to-static): one of the handle()s
Gateway::Body Gateway::handle(const control::MonitorRequest&) {
  return control::Done{"events follow"};
}

Gateway::Body Gateway::handle(const control::ModeRequest& request) {
  if (request.mode != "enforce" && request.mode != "audit")
    return error(control::ErrorKind::invalid,
                 fmt::format("there is no mode '{}': it is enforce or audit", request.mode));
  const bool audit = request.mode == "audit";
  control_.set_mode(audit ? enforce::Mode::audit : enforce::Mode::enforce);
  const std::string line = audit ? "AUDIT MODE: nothing is dropped, everything is only counted"
                                 : "enforcing: what is not "
                                   "admitted is dropped";
  tell({Kind::mode, audit ? 4 : 5, line, 0, {}, {}});
  return control::Done{line};
}

}  // namespace mlcca
