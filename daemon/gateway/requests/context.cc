// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/requests/context.hpp"

#include <fmt/core.h>

#include <utility>

#include "core/model/text.hpp"
#include "daemon/gateway/channel_reports.hpp"
#include "daemon/gateway/quotas.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/report.hpp"
#include "daemon/gateway/report_size.hpp"
#include "daemon/gateway/turn.hpp"
#include "daemon/outside/gate_control.hpp"
#include "description/rules.hpp"

namespace mlcca {

Response made_aside(Context& context, const Asker& asker, Aside::Make make) {
  return Response(context.aside.ask(asker.peer, std::move(make), asker.may_slice));
}

Response made_in_slices(Context& context, std::size_t least_bytes,
                        std::function<serve::Slice()> next) {
  return Response(
      [&context, description = context.scene.description, next = std::move(next)] {
        if (description == context.scene.description) return std::optional(next());
        return std::optional(
            serve::Slice{failed("the description was reloaded meanwhile: ask again")});
      },
      least_bytes);
}

Response known(Context& context, const Asker& asker, const ParsedRequest& asked) {
  if (!context.channels.has_many_lines(asked.channel)) return context.channels.known(asked);
  return made_aside(context, asker, [&context, asked] { return context.channels.known(asked); });
}

Result<void> set_withdrawn(Context& context, std::size_t channel, bool withdrawn) {
  context.turn.commit();
  const std::string subject =
      core::format_subject(context.scene.state->system().channels[channel].subject);
  const store::Entry entry =
      withdrawn ? store::Entry(store::Released{subject}) : store::Entry(store::Reinstated{subject});
  if (auto done = context.recorder.write_at_once({entry}); !done) return done;
  context.scene.state->set_withdrawn(channel, withdrawn);
  // A gate that the kernel refuses to change denies everything, and the log says so. The decision
  // stands.
  static_cast<void>(context.turn.settle());
  return {};
}

core::Proposal as_it_could_be(Context& context, const core::Admission& admission) {
  core::State& state = *context.scene.state;
  {
    core::Proposal proposal = state.propose(admission);
    if (context.membership == nullptr || proposal.fit()) return proposal;
  }
  return state.wish(admission);
}

Body outcome_of(const Context& context, const core::Proposal& proposal, const ParsedRequest& asked,
                const char* to_do) {
  const core::State& state = *context.scene.state;
  control::Channels out;
  auto verdicts = proposal.verdicts();
  out.left_out = leave_out(state, verdicts);
  const auto shared = core::shared_rules(state.system(), state.members(), asked.channel,
                                         proposal.decision().verdicts, context.scene.self);
  for (const core::Verdict* v : verdicts) {
    out.channels.push_back(channel_report(state, *v, {}));
    if (v->granted)
      set_not_supervised(
          out.channels.back(),
          context.delivery_health.look_alikes_of(
              core::gate_state(state.system(), state.members(), *v, context.scene.self), shared));
  }
  if (!proposal.fit())
    for (control::Channel& channel : out.channels)
      if (channel.admission == asked.admission->id) channel.admission = 0;
  if (!out.channels.empty()) return out;
  const bool publishes = asked.admission->publisher.has_value();
  const bool elsewhere = context.membership != nullptr && !publishes;
  return invalid(fmt::format(
      "no endpoint {} {}: there is nothing to {}{}", publishes ? "subscribes" : "publishes",
      state.system().channels[asked.channel].name, to_do,
      elsewhere
          ? ". A publisher that another gateway has admitted on its own networks alone is not "
            "in the store: say where it is (--from)"
          : ""));
}

std::optional<std::string> lacks_pairs(const Context& context, const ParsedRequest& asked) {
  const core::Members& members = context.scene.state->members();
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
                     subscribers, context.scene.state->system().channels[asked.channel].name,
                     description::kMaxPairs);
}

}  // namespace mlcca
