// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/requests/adopted.hpp"

#include <algorithm>
#include <optional>
#include <utility>
#include <variant>

#include "core/cluster/footprint.hpp"
#include "core/model/text.hpp"
#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/can_forwarding.hpp"
#include "daemon/gateway/delivery_events.hpp"
#include "daemon/gateway/membership.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/report.hpp"
#include "daemon/gateway/requests/parsed_request.hpp"
#include "daemon/gateway/requests/shared.hpp"
#include "daemon/gateway/tag_bindings.hpp"
#include "daemon/gateway/turn.hpp"
#include "daemon/outside/gate_driver.hpp"

namespace mlcca::requests {
namespace {

constexpr const char* kNobodyThere = "nobody is there on the other side";

Result<ParsedRequest> understood_adopted(core::State& state, const control::Request& request) {
  const auto& admit = std::get<control::Admit>(request.body);
  if (const auto listed = list(state, admit); !listed) return std::unexpected(listed.error());
  auto asked = understand(state, admit, request.id);
  if (asked && !asked->admission) return fail("these ends are described here");
  return asked;
}

/// While it lives, a channel that is not described has its tags.
class Tagged {
 public:
  Tagged(TagBindings& tags, const control::Request& request)
      : tags_(tags), unlisted_(std::get<control::Admit>(request.body).unlisted) {
    if (unlisted_) tags_.claim();
  }
  Tagged(const Tagged&) = delete;
  Tagged& operator=(const Tagged&) = delete;
  Tagged(Tagged&&) = delete;
  Tagged& operator=(Tagged&&) = delete;
  ~Tagged() {
    if (unlisted_) tags_.leave_unused();
  }

 private:
  TagBindings& tags_;
  bool unlisted_;
};

Reserving::Refusal refusal_by(const core::State& state, const core::Verdict& v) {
  return {.why = verdict_line(state, v), .hop = core::refusing_hop(v)};
}

/// The reason why a proposal does not fit.
Reserving::Refusal first_refusal(const core::State& state, const core::Proposal& proposal) {
  for (const core::Verdict* v : proposal.verdicts())
    if (!v->granted) return refusal_by(state, *v);
  return {.why = kNobodyThere};
}

std::unexpected<Reserving::Refusal> refuse(std::string why) {
  return std::unexpected(Reserving::Refusal{.why = std::move(why)});
}

}  // namespace

Reserving::Refusal AdmissionsOfOthers::misfit_of_present(core::AdmissionId id,
                                                         std::size_t channel) const {
  core::State& state = *parts_.scene.state;
  const core::Proposal wish = state.wish(channel);
  bool is_anybody_there = false;
  for (const core::Verdict& v : wish.decision().verdicts) {
    if (!parts_.deliveries.concerns(v, id)) continue;
    if (!v.granted) return refusal_by(state, v);
    is_anybody_there = true;
  }
  return {.why = is_anybody_there ? "" : kNobodyThere};
}

Reserving::Refusal AdmissionsOfOthers::misfit(const control::Request& request) {
  core::State& state = *parts_.scene.state;
  if (const auto known = state.admissions().find(request.id); known != state.admissions().end())
    return misfit_of_present(request.id, known->second);
  const auto asked = understood_adopted(state, request);
  const Tagged tagged(parts_.tags, request);
  if (!asked) return {.why = asked.error().text};
  if (auto lack = lacks_pairs(state, *asked)) return {.why = std::move(*lack)};
  const core::Proposal wish = state.wish(*asked->admission);
  return wish.fit() ? Reserving::Refusal() : first_refusal(state, wish);
}

std::set<core::AdmissionId> AdmissionsOfOthers::not_granted(const std::set<std::size_t>& channels) {
  const core::State& state = *parts_.scene.state;
  const core::Members& members = state.members();
  std::set<core::AdmissionId> all;
  for (const std::size_t channel : channels)
    for (const core::Verdict& v : state.decisions()[channel].verdicts) {
      if (v.granted) continue;
      all.insert(members.admission_of_publisher(v.publisher));
      for (const std::size_t s : v.subscribers) all.insert(members.admission_of_subscriber(s));
    }
  return all;
}

bool AdmissionsOfOthers::is_without_publisher(const control::Request& request) {
  const core::State& state = *parts_.scene.state;
  const auto& admit = std::get<control::Admit>(request.body);
  const auto channel = state.find_channel(admit.channel);
  if (!channel) return true;
  const auto& members = state.members();
  return std::ranges::none_of(members.publishers_of(*channel), [&](std::size_t p) {
    const core::AdmissionId id = members.admission_of_publisher(p);
    const bool own =
        id == 0 || id == request.id || parts_.recorder.contents().admissions.find(id) != nullptr;
    return own &&
           (admit.from.empty() || state.find_place(admit.from) == members.publisher(p).place);
  });
}

bool AdmissionsOfOthers::is_publisher_gone(const control::Request& request) {
  if (!is_without_publisher(request)) return false;
  const auto& wanted = std::get<control::Admit>(request.body);
  const auto& recorded = parts_.recorder.contents().admissions;
  return std::ranges::none_of(
      parts_.admissions.left_out_of(wanted.channel), [&](core::AdmissionId id) {
        const control::Request* const one = recorded.find(id);
        if (one == nullptr || !recorded.through(id).empty()) return false;
        const auto& admit = std::get<control::Admit>(one->body);
        return !admit.from.empty() && (wanted.from.empty() || admit.from == wanted.from);
      });
}

std::expected<Reserving::Wish, Reserving::Refusal> AdmissionsOfOthers::wish(
    const control::Request& request, std::size_t gateway) {
  core::State& state = *parts_.scene.state;
  const auto asked = understood_adopted(state, request);
  const Tagged tagged(parts_.tags, request);
  if (!asked) return refuse(asked.error().text);
  if (!asked->admission->subscriber) return refuse("it asks for no new subscriber");
  if (asked->admission->publisher || is_without_publisher(request))
    return refuse("no publisher of it is admitted here");
  if (auto lack = lacks_pairs(state, *asked)) return refuse(std::move(*lack));
  const core::Proposal wish = state.wish(*asked->admission);
  if (auto lack = wish.exceeds_capacity(parts_.scene.self)) return refuse(std::move(*lack));
  if (!wish.fit()) return std::unexpected(first_refusal(state, wish));
  auto footprint =
      core::cluster::footprint_of(wish, parts_.membership->baseline(), parts_.scene.self);
  // The other gateway follows the publisher, also where the way does not lead over it.
  core::cluster::add_gateway(footprint, gateway);
  cluster::StoredRequest for_others{.channel = state.system().channels[asked->channel].name,
                                    .requests = {request}};
  parts_.membership->add_publishers(footprint, for_others);
  return Reserving::Wish{
      .footprint = std::move(footprint), .publisher = {}, .asked = std::move(for_others)};
}

Result<void> AdmissionsOfOthers::admit(const control::Request& request) {
  core::State& state = *parts_.scene.state;
  if (state.admissions().contains(request.id)) return {};
  const auto asked = understood_adopted(state, request);
  const Tagged tagged(parts_.tags, request);
  if (!asked) return std::unexpected(asked.error());
  std::optional<Error> refused;
  {
    core::Proposal proposal = state.propose(*asked->admission);
    if (const auto lack = proposal.exceeds_capacity(parts_.scene.self)) return fail(*lack);
    if (!proposal.fit()) return fail(first_refusal(state, proposal).why);
    if (const auto done = parts_.gates.apply(proposal.changes(parts_.scene.self)); done)
      std::move(proposal).accept();
    else
      refused = done.error();
  }
  if (refused) {
    // The gates may hold a part of it.
    static_cast<void>(parts_.turn.enforce());
    return std::unexpected(*refused);
  }
  parts_.turn.set_bands();
  parts_.recorder.note(asked->channel);
  parts_.forwarding.want(asked->channel);
  for (const core::Verdict& v : state.decisions()[asked->channel].verdicts)
    if (parts_.deliveries.concerns(v, request.id))
      parts_.deliveries.verdict(Kind::granted, v, verdict_line(state, v));
  return {};
}

Result<void> AdmissionsOfOthers::take_in(const control::Request& request) {
  core::State& state = *parts_.scene.state;
  if (state.admissions().contains(request.id)) return {};
  const auto asked = understood_adopted(state, request);
  const Tagged tagged(parts_.tags, request);
  if (!asked) return std::unexpected(asked.error());
  if (auto lack = lacks_pairs(state, *asked)) return fail(std::move(*lack));
  state.restore(*asked->admission);
  return {};
}

void AdmissionsOfOthers::remove(const std::vector<core::AdmissionId>& gone) {
  core::State& state = *parts_.scene.state;
  core::FormerRules left;
  for (const core::AdmissionId id : gone) {
    const auto known = state.admissions().find(id);
    if (known == state.admissions().end()) continue;
    const std::size_t channel = known->second;
    if (!left.contains(channel))
      left.emplace(channel, state.gate_state(parts_.scene.self, channel));
    state.remove(id);
  }
  static_cast<void>(parts_.turn.settle(left));
  parts_.tags.leave_unused();
}

void AdmissionsOfOthers::restore(const control::Request& request) {
  core::State& state = *parts_.scene.state;
  if (state.admissions().contains(request.id)) return;
  const auto asked = understood_adopted(state, request);
  if (asked) state.restore(*asked->admission);
}

}  // namespace mlcca::requests
