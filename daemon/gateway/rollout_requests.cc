// SPDX-License-Identifier: BSD-2-Clause
// Requests of clients about rollouts.
#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "base/many.hpp"
#include "daemon/gateway/rollout.hpp"

namespace mlcca {
namespace {

namespace cc = core::cluster;

Response not_handed_over(const std::string& why) { return failed("nothing was changed: " + why); }

}  // namespace

void Rollout::session_closed(std::uint64_t session) { uploads_.end(session); }

Response Rollout::take(const Asker& asker, const control::RolloutRequest& request,
                       const cc::Member& member) {
  const std::uint64_t session = asker.peer.session;
  if (request.back || request.accept) {
    uploads_.end(session);
    return request.back ? back(request, member) : accept(member);
  }
  if (request.more) {
    const auto size = uploads_.add(session, asker.peer.uid, request.part);
    if (!size) return not_handed_over(size.error().text);
    return control::Done{many(*size, "byte")};
  }
  auto text = uploads_.finish(session, asker.peer.uid, request.part);
  if (!text) return not_handed_over(text.error().text);
  return begin(std::move(*text), request.without, member);
}

Response Rollout::begin(std::string text, const std::vector<std::string>& without,
                        const cc::Member& member) {
  const auto& keys = member.view().keys();
  if (text.empty()) return invalid("there is no description");
  for (const std::string& name : without) {
    if (keys.gateway(name) == member.self())
      return invalid(name + " is this gateway, which is not off");
  }
  const auto& next = member.view().records().next;
  if (next.mod != 0 && !next.value)
    return failed(
        "nothing was changed: what is proposed in the store cannot be read (d/next); it is removed "
        "after two minutes");
  const bool gives_way = cc::Rollouts::gives_way(member.view().records(), without);
  const bool open = check_ || next_check_ || staged_ || own_.state == "staging" ||
                    own_.state == "judged" || (next.mod != 0 && !gives_way);
  if (open) return failed("nothing was changed: another description is being rolled out");
  own_ = Own{.number = own_.number + 1,
             .digest = {},
             .state = "checking",
             .why = {},
             .without = without,
             .actor = parts_.log.actor()};
  next_check_ =
      std::make_shared<Check>(Check{.why = Why::propose,
                                    .digest = {},
                                    .text = std::make_shared<const std::string>(std::move(text))});
  return state(member);
}

Response Rollout::back(const control::RolloutRequest& request, const cc::Member& member) {
  const auto& current = member.view().records().current.value;
  if (!current || current->former == Digest{})
    return failed("nothing was changed: there was no description before");
  // The one before may be coming back already.
  const Digest& before = current->undone && !current->open ? current->digest : current->former;
  auto text = kept(before);
  if (const Text stored = text ? nullptr : in_store(before, member)) text = *stored;
  if (!text)
    return failed(fmt::format("nothing was changed: description {} is not kept any more",
                              shown_digits(before)));
  return begin(std::move(*text), request.without, member);
}

Response Rollout::accept(const cc::Member& member) {
  const auto& current = member.view().records().current.value;
  if (!current) return failed("nothing was changed: no description is in force in the cluster");
  if (current->digest == parts_.scene.digest)
    return control::Done{"this gateway has the description that is in force: nothing was changed"};
  if (!in_store(current->digest, member) && !kept(current->digest))
    return failed(fmt::format("nothing was changed: the store does not have the text of {}",
                              shown_digits(current->digest)));
  following_.wanted = current->digest;
  return control::Done{
      fmt::format("description {} is taken up from the cluster", shown_digits(current->digest))};
}

control::Rollout Rollout::state(const cc::Member& member) const {
  const auto& view = member.view();
  const auto& records = view.records();
  control::Rollout out{.number = own_.number,
                       .state = own_.state,
                       .why = own_.why,
                       .waiting = {},
                       .description = hex_of_digest(parts_.scene.digest)};
  if (const auto& current = records.current.value) {
    out.current = hex_of_digest(current->digest);
    out.former = hex_of_digest(current->former);
    out.open = current->open;
    out.generation = current->generation;
  }
  const auto& next = records.next.value;
  if (next) {
    out.next = hex_of_digest(next->digest);
    out.by = next->by;
  }
  for (std::size_t g = 0; g < view.keys().gateways(); ++g) {
    const std::string& name = view.keys().gateway_name(g);
    const auto& vote = records.rollout_votes[g].value;
    const bool voted = vote && vote->next == records.next.mod;
    const bool is_off = next && std::ranges::find(next->without, name) != next->without.end();
    const bool missing = next ? !voted && !is_off
                              : records.current.value && !records.current.value->open &&
                                    !core::cluster::Rollouts::is_in(view, g);
    if (missing) out.waiting.push_back(name);
  }
  return out;
}

}  // namespace mlcca
