// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/requests/shared.hpp"

#include <fmt/core.h>

#include <utility>

#include "core/model/text.hpp"
#include "daemon/gateway/channel_reports.hpp"
#include "daemon/gateway/delivery_health.hpp"
#include "daemon/gateway/quotas.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/report.hpp"
#include "daemon/gateway/report_estimates.hpp"
#include "daemon/gateway/report_size.hpp"
#include "daemon/gateway/turn.hpp"
#include "description/rules.hpp"

namespace mlcca::requests {

Response known(const ChannelReports& channels, const ReportEstimates& estimates,
               const Replies& replies, const Asker& asker, const ParsedRequest& asked) {
  if (!estimates.has_many_lines(asked.channel)) return channels.known(asked);
  return replies.aside(asker, [&channels, asked] { return channels.known(asked); });
}

Result<void> set_withdrawn(const WithdrawParts& parts, std::size_t channel, bool withdrawn) {
  parts.turn.commit();
  const std::string subject =
      core::format_subject(parts.scene.state->system().channels[channel].subject);
  const store::Entry entry =
      withdrawn ? store::Entry(store::Released{subject}) : store::Entry(store::Reinstated{subject});
  if (auto done = parts.recorder.write_at_once({entry}); !done) return done;
  parts.scene.state->set_withdrawn(channel, withdrawn);
  // A gate that the kernel refuses to change denies everything, and the log says so. The decision
  // stands.
  static_cast<void>(parts.turn.settle());
  return {};
}

core::Proposal as_it_could_be(core::State& state, const Membership* membership,
                              const core::Admission& admission) {
  {
    core::Proposal proposal = state.propose(admission);
    if (membership == nullptr || proposal.fit()) return proposal;
  }
  return state.wish(admission);
}

Body outcome_of(const Scene& scene, const DeliveryHealth& delivery_health,
                const Membership* membership, const core::Proposal& proposal,
                const ParsedRequest& asked, const char* to_do) {
  const core::State& state = *scene.state;
  control::Channels out;
  auto verdicts = proposal.verdicts();
  out.left_out = leave_out(state, verdicts);
  const auto shared = core::shared_rules(state.system(), state.members(), asked.channel,
                                         proposal.decision().verdicts, scene.self);
  for (const core::Verdict* v : verdicts) {
    out.channels.push_back(channel_report(state, *v, {}));
    if (v->granted)
      set_not_supervised(
          out.channels.back(),
          delivery_health.look_alikes_of(
              core::gate_state(state.system(), state.members(), *v, scene.self), shared));
  }
  if (!proposal.fit())
    for (control::Channel& channel : out.channels)
      if (channel.admission == asked.admission->id) channel.admission = 0;
  if (!out.channels.empty()) return out;
  const bool publishes = asked.admission->publisher.has_value();
  const bool elsewhere = membership != nullptr && !publishes;
  return invalid(fmt::format(
      "no endpoint {} {}: there is nothing to {}{}", publishes ? "subscribes" : "publishes",
      state.system().channels[asked.channel].name, to_do,
      elsewhere
          ? ". A publisher that another gateway has admitted on its own networks alone is not "
            "in the store: say where it is (--from)"
          : ""));
}

std::optional<std::string> lacks_pairs(const core::State& state, const ParsedRequest& asked) {
  const core::Members& members = state.members();
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
                     subscribers, state.system().channels[asked.channel].name,
                     description::kMaxPairs);
}

}  // namespace mlcca::requests
