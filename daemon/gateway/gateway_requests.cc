// SPDX-License-Identifier: BSD-2-Clause
// What clients want to have changed, one handle() for each kind of request; and what they would
// get.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <type_traits>
#include <utility>
#include <variant>

#include "base/clock.hpp"
#include "core/admission/progress.hpp"
#include "core/model/text.hpp"
#include "daemon/gateway/gateway.hpp"
#include "daemon/gateway/report.hpp"
#include "daemon/gateway/report_size.hpp"
#include "description/rules.hpp"

namespace mlcca {
namespace {

template <class T, class... Others>
constexpr bool kIsOneOf = (std::is_same_v<T, Others> || ...);

/// What is not listed here changes something.
template <class Asked>
constexpr bool kOnlyReads =
    kIsOneOf<Asked, control::StatusRequest, control::NetworksRequest, control::ChannelsRequest,
             control::Query, control::ExplainRequest, control::MonitorRequest,
             control::RoutesRequest, control::ReservationsRequest, control::WhatIfRequest,
             control::HistoryRequest, control::GateRequest>;

bool wants_change(const control::Request& request) {
  return std::visit(
      [](const auto& asked) { return !kOnlyReads<std::remove_cvref_t<decltype(asked)>>; },
      request.body);
}

/// A renewal is in memory only.
bool makes_history(const control::Request& request) {
  return wants_change(request) && !std::holds_alternative<control::RenewRequest>(request.body);
}

control::Error error(control::ErrorKind kind, std::string message) {
  return {kind, std::move(message), {}};
}

}  // namespace

/// Reads on a thread, and goes on in the loop when that is done.
Gateway::Body Gateway::handle(const control::ReloadRequest&) {
  const auto read = std::make_shared<std::optional<LoadResult>>();
  const auto reload = std::make_shared<Reload>(Reload{std::nullopt, peer_.session, log_.actor()});
  const bool begun = reading_.begin([read, options = options_] { *read = Gateway::read(options); },
                                    [this, read] { end_reload(reload_with(std::move(**read))); });
  if (!begun)
    return error(control::ErrorKind::world,
                 "nothing was changed: the description is being read already; ask again later");
  log_.add_rows(Quotas::kRowsOfReload);
  reload_ = reload;
  slices_ = [reload]() -> std::optional<serve::Slice> {
    if (!reload->body) return std::nullopt;
    return serve::Slice{*reload->body};
  };
  return {};
}

void Gateway::reload() {
  peer_ = {};
  const Body body = handle(control::ReloadRequest{});
  slices_ = nullptr;
  if (const auto* busy = std::get_if<control::Error>(&body); busy != nullptr && !reload_)
    log_.error(Kind::reload, busy->message);
}

void Gateway::end_reload(Body body) {
  const auto reload = std::exchange(reload_, nullptr);
  if (!reload) return;
  reload->body = std::move(body);
  if (ready_) ready_(reload->session);
}

Gateway::Body Gateway::reload_with(LoadResult read) {
  const EventLog::Acting acting(log_, reload_ ? reload_->actor : std::nullopt);
  const core::Progress alive([this] { pulse(); });
  commit();
  const Granted before = granted();
  auto loaded = complete(std::move(read));
  if (!loaded) {
    last_error_ = loaded.error().lines.front();
    log_.error(Kind::reload,
               fmt::format("reload refused, nothing changed: {}{}", last_error_,
                           loaded.error().lines.size() > 1
                               ? fmt::format(" (and {} more)", loaded.error().lines.size() - 1)
                               : ""));
    return control::Error{control::ErrorKind::unreadable,
                          "the description cannot be used, nothing was changed",
                          std::move(loaded.error().lines)};
  }
  last_error_.clear();
  const std::size_t old_self = std::exchange(scene_.self, loaded->self);
  ++scene_.description;
  auto old = std::exchange(scene_.state, std::move(loaded->state));
  const auto old_beyond = std::exchange(beyond_, {});
  // A stranger does not go away with a description.
  for (const auto& [network, beyond] : old_beyond)
    if (const auto place = scene_.state->find_place(old->system().networks[network].name);
        place && place->kind == core::Place::Kind::network)
      beyond_[place->index] = {beyond.strangers, beyond.told, {}};
  senders_.clear();
  meshes_.describe(scene_.state->system(), scene_.self);
  auto done = put_in_force(before);
  if (!done) {
    ++scene_.description;
    scene_.state = std::move(old);
    scene_.self = old_self;
    beyond_ = old_beyond;
    last_error_ = done.error().text;
    log_.error(Kind::reload, "reload refused, back to what was: " + last_error_);
    meshes_.describe(scene_.state->system(), scene_.self);
    static_cast<void>(put_in_force(before));
  }
  forget_drops();
  open_unless_lost();
  if (!done) return error(control::ErrorKind::world, last_error_);
  loaded_ = std::time(nullptr);
  left_out_ = std::move(loaded->left_out);
  log_.notice(Kind::reload, "reloaded: " + summary());
  report_outcome(before, deliveries_.reported_of(*old));
  return control::Done{"reloaded: " + summary()};
}

serve::Answer Gateway::answer(const control::Request& request, const serve::Peer& peer) {
  if (wants_change(request) && !peer.may_change)
    return {
        {request.id, error(control::ErrorKind::forbidden,
                           fmt::format("only root and members of the group {} may change anything",
                                       options_.group))}};
  const bool counts = makes_history(request);
  if (counts)
    if (const auto why = quotas_.refuse_change(peer.uid, monotonic_ns()))
      return {{request.id, error(control::ErrorKind::world, "nothing was changed: " + *why)}};
  peer_ = peer;
  may_slice_ = request.slices;
  hold_answer_ = false;
  owned_ = 0;
  slices_ = nullptr;
  least_bytes_ = 0;
  const core::Progress alive([this] { pulse(); });
  const EventLog::Acting acting(
      log_, wants_change(request) ? std::optional(actor_of(peer)) : std::nullopt);
  const std::uint64_t rows = log_.rows();
  Body body = std::visit([this](const auto& asked) { return handle(asked); }, request.body);
  if (counts) quotas_.charge(peer.uid, log_.rows() - rows, monotonic_ns());
  if (!hold_answer_) forwarder_.act();
  return {{request.id, std::move(body)}, hold_answer_, owned_, std::move(slices_), least_bytes_};
}

Gateway::Body Gateway::answer_to(const core::Proposal& proposal, const Asked& asked,
                                 const char* to_do) const {
  control::Channels out;
  auto verdicts = proposal.verdicts();
  out.left_out = leave_out(*scene_.state, verdicts);
  for (const core::Verdict* v : verdicts)
    out.channels.push_back(channel_report(*scene_.state, *v, {}));
  if (!proposal.fit())
    for (control::Channel& channel : out.channels)
      if (channel.admission == asked.admission->id) channel.admission = 0;
  if (!out.channels.empty()) return out;
  return error(control::ErrorKind::invalid,
               fmt::format("nobody {} {}: there is nothing to {}",
                           asked.admission->publisher ? "subscribes" : "publishes",
                           scene_.state->system().channels[asked.channel].name, to_do));
}

Gateway::Body Gateway::handle(const control::Query& request) {
  if (const auto listed = list(*scene_.state, request); !listed)
    return error(control::ErrorKind::invalid, listed.error().text);
  const auto asked = understand(*scene_.state, request, stored().next_id);
  if (!asked) return error(control::ErrorKind::invalid, asked.error().text);
  if (!asked->admission) return known_or_aside(*asked);
  if (!has_many_ends(asked->channel)) return would_be(*asked);
  return aside([this, asked = *asked] { return would_be(asked); });
}

Gateway::Body Gateway::would_be(const Asked& asked) {
  if (const auto lack = lacks_pairs(asked)) return error(control::ErrorKind::invalid, *lack);
  const core::Proposal proposal = scene_.state->propose(*asked.admission);
  if (const auto lack = proposal.lacks_room(scene_.self))
    return error(control::ErrorKind::invalid, *lack);
  return answer_to(proposal, asked, "decide");
}

/// Each pair of ends of a channel is decided and reported: of one channel there are as many as in a
/// description, and of all channels as many as there is memory for, also at the next start.
std::optional<std::string> Gateway::lacks_pairs(const Asked& asked) const {
  const core::Members& members = scene_.state->members();
  const std::size_t publishers =
      members.publishers_of(asked.channel).size() + (asked.admission->publisher ? 1 : 0);
  const std::size_t subscribers =
      members.subscribers_of(asked.channel).size() + (asked.admission->subscriber ? 1 : 0);
  if (publishers * subscribers <= description::kMaxPairs) {
    const std::size_t before =
        members.publishers_of(asked.channel).size() * members.subscribers_of(asked.channel).size();
    return Quotas::refuse_pairs(members.admitted_pairs(), publishers * subscribers - before);
  }
  return fmt::format("{} publishers and {} subscribers of {}: at most {} pairs", publishers,
                     subscribers, scene_.state->system().channels[asked.channel].name,
                     description::kMaxPairs);
}

// --- admit ---------------------------------------------------------------------------------------

Gateway::Body Gateway::handle(const control::Admit& request) {
  if (const auto key = check_key(request.key); !key)
    return error(control::ErrorKind::invalid, key.error().text);
  if (auto again = admit_again(request)) return std::move(*again);
  if (const auto listed = list(*scene_.state, request); !listed)
    return error(control::ErrorKind::invalid, listed.error().text);
  if (!request.unlisted) return admit(request);
  claim_tags();
  Body body = admit(request);
  leave_unused_tags();
  return body;
}

Gateway::Body Gateway::admit(const control::Admit& request) {
  const auto asked = understand(*scene_.state, request, stored().next_id);
  if (!asked) return error(control::ErrorKind::invalid, asked.error().text);
  if (asked->admission) return admit_new(request, *asked);
  if (!request.key.empty() || request.lease_ns != 0 || request.hold)
    return error(control::ErrorKind::invalid,
                 "these ends are described: a key, a lease or hold needs a new publisher or "
                 "subscriber (say its attributes, or give it a name)");
  return known_or_aside(*asked);
}

/// A key that was granted before is answered as now, and its lease begins anew.
std::optional<Gateway::Body> Gateway::admit_again(const control::Admit& request) {
  const auto known = keys_.find(request.key);
  if (!known) return std::nullopt;
  const core::AdmissionId id = *known;
  const control::Request* granted = stored().admissions.find(id);
  if (granted == nullptr) return std::nullopt;
  if (std::get<control::Admit>(granted->body) != request)
    return error(
        control::ErrorKind::invalid,
        fmt::format("admission {} has the key '{}' and was asked for otherwise: release it "
                    "first, or take another key",
                    id, request.key));
  if (const auto out = left_out_.find(id); out != left_out_.end())
    return error(control::ErrorKind::invalid,
                 out->second + ": release it, or mend the description");
  own(id, request);
  hold_answer_ = std::ranges::find(uncommitted_, id) != uncommitted_.end();
  return report_admission(id);
}

Gateway::Body Gateway::admit_new(const control::Admit& request, const Asked& asked) {
  if (const auto why = Quotas::refuse_admission(peer_.uid, stored().admissions))
    return error(control::ErrorKind::world, "nothing was changed: " + *why);
  if (const auto lack = lacks_pairs(asked)) return error(control::ErrorKind::invalid, *lack);
  const core::AdmissionId id = asked.admission->id;
  Body out;
  Result<void> done;
  {
    core::Proposal proposal = scene_.state->propose(*asked.admission);
    if (const auto lack = proposal.lacks_room(scene_.self))
      return error(control::ErrorKind::invalid, *lack);
    out = answer_to(proposal, asked, "admit");
    if (!proposal.fit()) {
      for (const core::Verdict* v : proposal.verdicts())
        if (!v->granted) deliveries_.verdict(Kind::refused, *v, verdict_line(*scene_.state, *v));
      return out;
    }
    done = store_->append(store::Admitted{{id, request}, peer_.uid});
    if (done) done = ports_.apply(proposal.changes(scene_.self));
    if (done) std::move(proposal).accept();
  }
  if (!done) {
    if (stored().admissions.find(id) != nullptr)
      static_cast<void>(store_->append(store::Removed{id}));
    static_cast<void>(enforce());
    return error(control::ErrorKind::world, "nothing was changed: " + done.error().text);
  }
  set_bands();
  uncommitted_.push_back(id);
  hold_answer_ = true;
  keys_.put(request.key, id);
  own(id, request);
  if (lease_of(request) != 0) log_.add_rows(1);  // when it ends
  note(asked.channel);
  forward(asked.channel);
  for (const core::Verdict& v : scene_.state->decisions()[asked.channel].verdicts)
    if (deliveries_.concerns(v, id)) {
      deliveries_.verdict(Kind::granted, v, verdict_line(*scene_.state, v));
      tell_missing_again(v);
    }
  return out;
}

/// The lease of an admission that a connection holds does not run.
void Gateway::own(core::AdmissionId id, const control::Admit& request) {
  if (request.hold) {
    held_[id].insert(peer_.session);
    owned_ = id;
    leases_.forget(id);
  } else if (request.lease_ns != 0) {
    leases_.set(id, request.lease_ns, monotonic_ns());
  }
}

/// By its key, or else by its number; one that was granted, and perhaps left out since.
Result<core::AdmissionId> Gateway::admission_named(core::AdmissionId id,
                                                   const std::string& key) const {
  if (!key.empty()) {
    if (const auto known = keys_.find(key)) return *known;
    return fail(fmt::format("there is no admission with the key '{}'", key));
  }
  if (stored().admissions.find(id) == nullptr)
    return fail(fmt::format("there is no admission {}", id));
  return id;
}

Gateway::Body Gateway::handle(const control::RenewRequest& request) {
  const auto named = admission_named(request.admission, request.key);
  if (!named) return error(control::ErrorKind::invalid, named.error().text);
  const core::AdmissionId id = *named;
  if (const auto out = left_out_.find(id); out != left_out_.end())
    return error(control::ErrorKind::invalid, out->second);
  if (!leases_.remaining(id, monotonic_ns())) {
    const bool held = held_.contains(id);
    return control::Done{
        fmt::format("admission {} {}", id, held ? "is held by a connection" : "has no lease")};
  }
  leases_.renew(id, monotonic_ns());
  return control::Done{
      fmt::format("renewed: admission {} has {} left", id,
                  core::format_value(Attribute::latency, *leases_.remaining(id, monotonic_ns())))};
}

// --- release -------------------------------------------------------------------------------------

Gateway::Body Gateway::handle(const control::ReleaseRequest& request) {
  std::vector<core::AdmissionId> gone;
  if (request.admission != 0 || !request.key.empty()) {
    const auto named = admission_named(request.admission, request.key);
    if (!named) return error(control::ErrorKind::invalid, named.error().text);
    gone.push_back(*named);
  } else {
    const auto named = channel_named(*scene_.state, request.channel);
    if (!named) return error(control::ErrorKind::invalid, named.error().text);
    for (const auto& [admission, of] : scene_.state->admissions())
      if (of == *named) gone.push_back(admission);
    if (gone.empty())
      return error(control::ErrorKind::invalid,
                   fmt::format("{0} has no run-time admission: what is described of it is stopped "
                               "by 'mlccactl withdraw {0}'",
                               scene_.state->system().channels[*named].name));
  }
  if (const auto done = release(gone, "released"); !done)
    return error(control::ErrorKind::world, done.error().text);
  return control::Done{
      fmt::format("released admission{} {}", gone.size() == 1 ? "" : "s", fmt::join(gone, ", "))};
}

/// Takes admissions back: on disk first, then in the kernel.
Result<void> Gateway::release(const std::vector<core::AdmissionId>& gone, const std::string& why) {
  commit();
  Result<void> done;
  for (const core::AdmissionId id : gone)
    if (done) done = store_->append(store::Removed{id});
  if (done && store_->dirty()) done = patience_.wait_for([this] { return store_->commit(); });
  if (!done) {
    store_->roll_back();
    return fail("nothing was changed: " + done.error().text);
  }
  deliveries_.released(gone, why);
  done = settle(forget(gone));
  leave_unused_tags();
  return done;
}

Gateway::Body Gateway::handle(const control::WithdrawRequest& request) {
  const auto channel = channel_named(*scene_.state, request.channel);
  if (!channel) return error(control::ErrorKind::invalid, channel.error().text);
  const core::EventChannel& withdrawn = scene_.state->system().channels[*channel];
  if (withdrawn.unlisted)
    return error(
        control::ErrorKind::invalid,
        fmt::format("{0} is not described, only admitted: 'mlccactl release {0}' ends that",
                    withdrawn.name));
  if (scene_.state->withdrawn(*channel))
    return control::Done{withdrawn.name + " is withdrawn already"};
  if (const auto done = set_withdrawn(*channel, true); !done)
    return error(control::ErrorKind::world, done.error().text);
  const std::string line = fmt::format(
      "withdrawn: everything of {0} is refused until 'mlccactl reinstate {0}'", withdrawn.name);
  log_.warning(Kind::withdrawn, line, {.subject = withdrawn.subject, .channel = withdrawn.name});
  return control::Done{line};
}

Gateway::Body Gateway::handle(const control::ReinstateRequest& request) {
  const auto channel = channel_named(*scene_.state, request.channel);
  if (!channel) return error(control::ErrorKind::invalid, channel.error().text);
  const core::EventChannel& reinstated = scene_.state->system().channels[*channel];
  if (!scene_.state->withdrawn(*channel))
    return control::Done{reinstated.name + " is not withdrawn: nothing was changed"};
  if (const auto done = set_withdrawn(*channel, false); !done)
    return error(control::ErrorKind::world, done.error().text);
  const auto& verdicts = scene_.state->decisions()[*channel].verdicts;
  const std::string line = fmt::format("reinstated: {} of {} deliveries of {} are granted",
                                       std::ranges::count_if(verdicts, &core::Verdict::granted),
                                       verdicts.size(), reinstated.name);
  log_.notice(Kind::reinstated, line, {.subject = reinstated.subject, .channel = reinstated.name});
  return control::Done{line};
}

/// On disk first, then in the kernel.
Result<void> Gateway::set_withdrawn(std::size_t channel, bool withdrawn) {
  commit();
  const std::string subject =
      core::format_subject(scene_.state->system().channels[channel].subject);
  Result<void> done = withdrawn ? store_->append(store::Released{subject})
                                : store_->append(store::Reinstated{subject});
  if (done) done = patience_.wait_for([this] { return store_->commit(); });
  if (!done) {
    store_->roll_back();
    return fail("nothing was changed: " + done.error().text);
  }
  scene_.state->set_withdrawn(channel, withdrawn);
  return settle();
}

/// Takes admissions out of everything but the disk. What the gates had of their channels.
core::FormerRules Gateway::forget(const std::vector<core::AdmissionId>& gone) {
  core::FormerRules left;
  for (const core::AdmissionId id : gone) {
    const auto known = scene_.state->admissions().find(id);
    if (known != scene_.state->admissions().end()) {
      const std::size_t channel = known->second;
      if (!left.contains(channel))
        left.emplace(channel, scene_.state->gate_state(scene_.self, channel));
      scene_.state->remove(id);
    }
    leases_.forget(id);
    held_.erase(id);
    keys_.forget(id);
    left_out_.erase(id);
  }
  return left;
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
  {
    const EventLog::Acting nobody(log_, std::nullopt);
    tell_all_drops();
  }
  control_.set_mode(audit ? enforce::Mode::audit : enforce::Mode::enforce);
  const std::string line = audit ? "AUDIT MODE: nothing is dropped, everything is only counted"
                                 : "enforcing: what is not "
                                   "admitted is dropped";
  log_.write({.kind = Kind::mode, .priority = audit ? 4 : 5, .message = line});
  return control::Done{line};
}

}  // namespace mlcca
