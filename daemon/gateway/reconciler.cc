// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/reconciler.hpp"

#include <map>
#include <utility>

#include "core/model/progress.hpp"

namespace mlcca {
namespace {

void put_graph(core::State& state, std::size_t network, const core::mesh::LinkTable& table) {
  std::vector<std::string> addresses;
  addresses.reserve(table.graph().nodes);
  for (std::uint32_t n = 0; n < table.graph().nodes; ++n) addresses.push_back(table.address(n));
  state.set_graph(network, table.graph(), std::move(addresses));
}

}  // namespace

/// Sets up interfaces, links and gates for a description that has just come into force. What was
/// granted before is decided first.
Result<void> Reconciler::put_in_force(const DeliveryEvents::Granted& granted_before,
                                      TagBindings::Known known) {
  core::State& state = *p_.scene.state;
  p_.gates.describe(state.system(), p_.scene.self);
  if (auto followed = p_.gates.follow(); !followed) return followed;
  p_.recorder.note_ports();
  p_.tags.take_up(known);
  p_.turn.observe();
  put_graphs();
  note_presence();
  if (p_.membership) {
    p_.membership->take_up();
    p_.tags.take_up(known);  // with the tags that others have asked for
  }
  std::map<std::size_t, core::Grants> before;
  for (const auto& [subject, grants] : granted_before) {
    if (const auto channel = state.find_channel(subject))
      before.emplace(*channel, grants);
    else
      p_.recorder.note_gone(subject);
  }
  p_.pulse();
  state.decide(before);
  for (std::size_t c = 0; c < state.decisions().size(); ++c) {
    p_.recorder.note_granted(c);
    p_.pulse();
  }
  return p_.turn.enforce();
}

void Reconciler::put_graphs() {
  for (std::size_t n = 0; n < p_.scene.state->system().networks.size(); ++n)
    if (const auto* table = p_.meshes.table(n)) put_graph(*p_.scene.state, n, *table);
  changed_.clear();
}

void Reconciler::reconcile() {
  const core::Progress alive(p_.pulse);
  static_cast<void>(p_.gates.follow());  // no description is being changed
  p_.recorder.note_ports();
  p_.tags.state();
  p_.turn.observe();
  static_cast<void>(p_.turn.settle());
  // If a port has another interface now, all of its slots must be written again.
  static_cast<void>(p_.turn.enforce());
  p_.turn.open_unless_lost();
}

/// If the interfaces cannot be read, nothing changes, and they are read again in the next round.
void Reconciler::links_changed() {
  const core::Progress alive(p_.pulse);
  LinkMonitor& links = p_.links;
  const std::string former_problem = links.problem();
  const auto changed = links.refresh();
  if (!changed && former_problem.empty())
    p_.log.error(Kind::problem,
                 changed.error().text + ": what is in force stays until they can be read");
  if (changed && !former_problem.empty())
    p_.log.notice(Kind::problem, "the interfaces can be read again");
  if (changed && (p_.gates.needs_recheck() || (*changed && p_.gates.needs_reconcile())))
    reconcile();
  if (links.take_tc_changed() && p_.gates.repair()) reconcile();
}

/// With a store, the store says which of several gateways carries a channel.
void Reconciler::note_presence() {
  if (!p_.membership) p_.presence.apply(*p_.scene.state);
}

void Reconciler::follow_links_of_meshes() {
  for (const std::size_t n : std::exchange(changed_, {}))
    if (const auto* table = p_.meshes.table(n)) put_graph(*p_.scene.state, n, *table);
}

}  // namespace mlcca
