// SPDX-License-Identifier: BSD-2-Clause
// What follows from the replies of FAMOUSO's broker. A gate has closed what they contradict before
// this runs: here the verdicts follow, and tags that are learned or dealt again open.
#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/control_traffic.hpp"
#include "daemon/clock.hpp"
#include "daemon/gateway.hpp"

namespace mlcca {

/// Of one look, over all gates.
struct Gateway::TagNews {
  bool changed = false;
  std::map<Tag*, std::uint16_t> moved;  ///< tags that are another now; 0: nobody knows which
  std::vector<Tag*> confirmed;          ///< contradicted, and dealt as stated since
};

/// For a description that has just become the one in force, before it is decided. What the gates
/// have learned under a daemon before this one is still so, unless they say otherwise.
void Gateway::take_up_tags() {
  tags_.describe(state_->system(), self_);
  for (std::size_t p = 0; p < ports_.size(); ++p) {
    const enforce::Gate* gate = ports_.can_gate(p);
    if (gate == nullptr || ports_.profile(p) != core::Profile::famouso) continue;
    for (const enforce::FoundBinding& found : gate->bindings().found()) {
      Tag* const tag = tags_.find(ports_.network_number(p), found.subject);
      if (tag == nullptr) continue;
      if (tag->dynamic && tag->etag == 0 && !found.contradicted) tag->etag = found.etag;
      if (tag->etag == found.etag && found.contradicted && tag->contradiction.empty()) {
        tag->contradiction = contradiction_words(*tag, found);
        tell_tag(*tag, 3, tag->contradiction);
      }
    }
  }
  for (const Tag& tag : tags_.all()) {
    if (!tag.dynamic) continue;
    if (tag.channel)
      state_->set_tag(tag.network, *tag.channel, tag.etag);
    else
      state_->set_subscribe_tag(tag.network, tag.etag);
  }
  tag_news_.clear();
  state_tags();
}

void Gateway::state_tags() {
  for (std::size_t p = 0; p < ports_.size(); ++p)
    if (enforce::Gate* gate = ports_.can_gate(p);
        gate != nullptr && ports_.profile(p) == core::Profile::famouso)
      gate->bindings().state(tags_.stated(ports_.network_number(p)));
}

void Gateway::take_tag_news(std::size_t port, const enforce::FoundBinding& found, TagNews& news) {
  Tag* const tag = tags_.find(ports_.network_number(port), found.subject);
  if (tag == nullptr || tag->etag != found.etag) return;
  if (found.contradicted && tag->contradiction.empty()) {
    tag->contradiction = contradiction_words(*tag, found);
    if (!tag->dynamic) tell_tag(*tag, 3, tag->contradiction + ": its frames are dropped");
    news.changed = true;
  }
  // At first only half of the other subject may have been known.
  if (found.contradicted && found.halves == 3)
    if (auto whole = contradiction_words(*tag, found); whole != tag->contradiction) {
      tag->contradiction = std::move(whole);
      news.changed = true;
    }
  if (found.confirmed) news.confirmed.push_back(tag);
  if (!tag->dynamic || found.dealt == tag->etag) return;
  if (found.dealt != 0 || found.contradicted) news.moved[tag] = found.dealt;
}

/// The old identifier is closed before the new one opens. False: nothing is left of this round.
bool Gateway::look_at_tags() {
  TagNews news;
  for (std::size_t p = 0; p < ports_.size(); ++p) {
    const enforce::Gate* gate = ports_.can_gate(p);
    if (gate == nullptr || ports_.profile(p) != core::Profile::famouso) continue;
    const enforce::Bindings bindings = gate->bindings();
    const std::uint32_t now = bindings.news();
    const auto seen = tag_news_.find(gate->ifindex());
    if (seen != tag_news_.end() && seen->second == now) continue;
    tag_news_[gate->ifindex()] = now;
    for (const enforce::FoundBinding& found : bindings.found()) take_tag_news(p, found, news);
  }
  if (news.changed) {
    put_conditions(*state_);
    static_cast<void>(settle());
  }
  if (news.moved.empty() && news.confirmed.empty()) return false;
  core::FormerRules left;
  for (const auto& [tag, etag] : news.moved) move_tag(*tag, etag, left);
  state_tags();
  for (Tag* const tag : news.confirmed) {
    if (news.moved.contains(tag) || tag->contradiction.empty() || !agree_on(*tag)) continue;
    tag->contradiction.clear();
    tell_tag(
        *tag, 5,
        fmt::format("the broker deals it tag {:#x} on {} again", tag->etag, tag->network_name));
  }
  put_conditions(*state_);
  static_cast<void>(settle(left));
  static_cast<void>(enforce());  // control traffic has moved, too
  return false;
}

/// Nothing of it is granted any more: see look_at_tags().
void Gateway::move_tag(Tag& tag, std::uint16_t etag, core::FormerRules& left) {
  if (tag.channel) {
    left.insert_or_assign(*tag.channel, state_->gate_state(self_, *tag.channel));
    state_->set_tag(tag.network, *tag.channel, etag);
  } else {
    state_->set_subscribe_tag(tag.network, etag);
  }
  if (etag == 0)
    tell_tag(tag, 4, tag.contradiction + ": it waits for another one");
  else
    tell_tag(tag, 5, fmt::format("it has tag {:#x} on {} now", etag, tag.network_name));
  tag.etag = etag;
  tag.contradiction.clear();
  tag.asked = tag.wait = 0;
}

/// Every gate of the network has heard that the tag is dealt as stated, after all contradictions.
bool Gateway::agree_on(const Tag& tag) {
  bool agree = true;
  for (std::size_t p = 0; p < ports_.size(); ++p) {
    const enforce::Gate* gate = ports_.can_gate(p);
    if (gate == nullptr || ports_.network_number(p) != tag.network) continue;
    enforce::Bindings bindings = gate->bindings();
    for (const enforce::FoundBinding& found : bindings.found())
      if (found.subject == tag.subject && found.contradicted)
        agree = agree && found.confirmed && bindings.settle(tag.subject);
  }
  return agree;
}

/// One request a second on each bus.
bool Gateway::ask_for_tags() {
  const std::uint64_t now = monotonic_ns();
  for (std::size_t p = 0; p < ports_.size(); ++p) {
    const enforce::Gate* gate = ports_.can_gate(p);
    const auto node = ports_.described(p).node;
    if (gate == nullptr || !node || !ports_.problem(p).empty()) continue;
    Tag* const tag = tags_.to_ask_for(ports_.network_number(p), now);
    if (tag == nullptr) continue;
    ask_for_tag(gate->ifindex(), *node, tag->subject);
    tag->asked = now;
    tag->wait = tag->wait == 0 ? kFirstTagWait : std::min(2 * tag->wait, kLongestTagWait);
  }
  return false;
}

void Gateway::tell_tag(const Tag& tag, int priority, std::string message) {
  Note note{Kind::binding,
            priority,
            tag.name + ": " + std::move(message),
            tag.subject,
            tag.name,
            tag.network_name,
            {},
            {}};
  tell(std::move(note));
}

}  // namespace mlcca
