// SPDX-License-Identifier: BSD-2-Clause
#include "core/admission/unlisted.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "base/number.hpp"
#include "core/model/text.hpp"
#include "core/profiles/profile.hpp"

namespace mlcca::core {
namespace {

Binding as_binding(const Network& network, std::size_t channel, const UnlistedBinding& wanted) {
  Binding b;
  b.channel = channel;
  b.id = wanted.id;
  const IdentifierForm form = traits_of(network.profile).form;
  b.extended = form == IdentifierForm::stated ? wanted.extended : form == IdentifierForm::extended;
  return b;
}

Result<void> check_identifier(const Network& network, const Binding& b) {
  const ProfileTraits& traits = traits_of(network.profile);
  const std::uint32_t last = std::min(traits.last, b.extended ? kExtendedBits : kStandardBits);
  if (b.id < traits.first || b.id > last)
    return fail("identifier " + hexadecimal(b.id) + " is not right on " + network.name + ": " +
                hexadecimal(traits.first) + " to " + hexadecimal(last));
  if (has_broker(network) && b.id == network.subscribe_tag)
    return fail("identifier " + hexadecimal(b.id) + " on " + network.name +
                " is that of SUBSCRIB: choose another");
  auto problem = traits.unlisted_problem == nullptr ? std::string() : traits.unlisted_problem(b);
  return problem.empty() ? Result<void>() : fail(std::move(problem));
}

Result<void> check_binding(const System& system, std::size_t channel,
                           const UnlistedBinding& wanted) {
  const Network& network = system.networks[wanted.network];
  if (network.kind != NetworkKind::can)
    return fail(network.name +
                " is no CAN network: frames there name the subject itself, and an "
                "identifier has no meaning");
  const Binding b = as_binding(network, channel, wanted);
  if (auto right = check_identifier(network, b); !right) return right;
  for (const Binding& other : network.bindings)
    if (other.channel != channel && clash(network.profile, b, other))
      return fail("identifier " + hexadecimal(b.id) + " on " + network.name + " is channel " +
                  system.channels[other.channel].name + "'s: choose another");
  return {};
}

Result<void> check_policy(const Network& network, Subject subject) {
  if (network.unlisted.admits(subject)) return {};
  return fail(network.name + " admits no channel " + format_subject(subject) +
              " that is not described: its Unlisted would have to allow it");
}

}  // namespace

std::size_t unlisted_room(const System& system) {
  std::size_t room = 0;
  for (const Network& network : system.networks)
    if (network.unlisted.allowed) room += network.unlisted.most;
  return std::min(room, kMaxUnlisted);
}

Result<void> check_unlisted(const System& system, std::size_t channel,
                            const UnlistedChannel& wanted) {
  for (const std::size_t network : wanted.networks)
    if (auto allowed = check_policy(system.networks[network], wanted.subject); !allowed)
      return allowed;
  for (const UnlistedBinding& b : wanted.bindings) {
    if (auto allowed = check_policy(system.networks[b.network], wanted.subject); !allowed)
      return allowed;
    if (auto right = check_binding(system, channel, b); !right) return right;
  }
  return {};
}

Result<void> check_foreign(const System& system, const std::vector<cluster::Foreign>& foreign,
                           const UnlistedChannel& wanted) {
  for (const UnlistedBinding& b : wanted.bindings) {
    const Network& network = system.networks[b.network];
    const Binding own = as_binding(network, 0, b);
    for (const cluster::BusPart& part : foreign[b.network].bus) {
      const std::string by = part.gateway < system.gateways.size()
                                 ? "gateway " + system.gateways[part.gateway].name
                                 : "another gateway";
      const bool same =
          part.extended == own.extended && part.first_id <= own.id && own.id <= part.last_id;
      if (part.subject == wanted.subject && !same)
        return fail("channel " + format_subject(wanted.subject) + " is admitted on " +
                    network.name + " with another identifier, by " + by);
      if (part.subject != wanted.subject && same)
        return fail("identifier " + hexadecimal(own.id) + " on " + network.name + " is taken by " +
                    by + " for channel " + format_subject(part.subject) + ": choose another");
    }
  }
  return {};
}

void bind(Network& network, std::size_t channel, const UnlistedBinding& wanted) {
  const auto at = std::ranges::upper_bound(network.bindings, channel, {}, &Binding::channel);
  network.bindings.insert(at, as_binding(network, channel, wanted));
}

}  // namespace mlcca::core
