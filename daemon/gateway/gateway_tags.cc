// SPDX-License-Identifier: BSD-2-Clause
// What follows from the replies of FAMOUSO's broker. A gate has closed what they contradict before
// this runs: here the verdicts follow, and tags that are learned or dealt again open.
#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "core/gates/control_traffic.hpp"
#include "daemon/gateway/gateway.hpp"

namespace mlcca {

/// Of one look.
struct Gateway::TagNews {
  bool changed = false;                        ///< of what is contradicted, or whose a tag is
  std::map<Tag*, enforce::FoundBinding> seen;  ///< in the gate of its network
  std::vector<Tag*> confirmed;                 ///< contradicted, and dealt as stated since
};

/// For a description that has just become the one in force, before it is decided. What the gates
/// have learned under a daemon before this one is still so, unless they say otherwise.
void Gateway::take_up_tags() {
  scene_.state->unlist_unused();
  tags_.describe(scene_.state->system(), scene_.self);
  for (std::size_t p = 0; p < ports_.size(); ++p) {
    const enforce::Gate* gate = ports_.can_gate(p);
    if (gate == nullptr || ports_.profile(p) != core::Profile::famouso) continue;
    for (const enforce::FoundBinding& found : gate->bindings().found()) {
      Tag* const tag = tags_.find(ports_.network_number(p), found.subject);
      if (tag == nullptr) continue;
      // What was stated before is no word of the broker.
      if (tag->dynamic && tag->etag == 0 && (found.contradicted || found.dealt == found.etag))
        tag->etag = found.etag;
      if (tag->dynamic && found.dealt != tag->etag) tag->dealt = found.dealt;
      if (tag->etag != 0 && tag->etag == found.etag && found.contradicted &&
          tag->contradiction.empty()) {
        tag->contradiction = contradiction_words(*tag, found);
        tell_tag(*tag, 3, tag->contradiction);
      }
    }
  }
  tell_rivals(tags_.hold_apart());
  for (Tag& tag : tags_.all()) {
    if (!tag.dynamic) continue;
    // What is due otherwise is given by the next look.
    if (tag.due() == 0) {
      tag.etag = 0;
      tag.contradiction.clear();
    }
    put_tag(tag);
  }
  tag_news_.clear();
  state_tags();
}

void Gateway::put_tag(const Tag& tag) {
  if (tag.channel)
    scene_.state->set_tag(tag.network, *tag.channel, tag.etag);
  else
    scene_.state->set_subscribe_tag(tag.network, tag.etag);
}

/// Those of channels that are not described come and go. They are held against the broker before
/// anything of them is granted.
void Gateway::claim_tags() {
  tags_.describe(scene_.state->system(), scene_.self);
  state_tags();
  look_at_tags(true);
  put_conditions(*scene_.state);  // a contradiction may be gone with its channel
  static_cast<void>(settle());
}

/// Nobody uses them any more, so that their tags may be others'.
void Gateway::leave_unused_tags() {
  if (scene_.state->unlist_unused()) claim_tags();
}

void Gateway::state_tags() {
  for (std::size_t p = 0; p < ports_.size(); ++p)
    if (enforce::Gate* gate = ports_.can_gate(p);
        gate != nullptr && ports_.profile(p) == core::Profile::famouso)
      gate->bindings().state(tags_.stated(ports_.network_number(p)));
}

void Gateway::tell_rivals(const std::vector<Tag*>& changed) {
  for (const Tag* tag : changed)
    if (!tag->rival.empty() && tag->contradiction.empty())
      tell_tag(*tag, 4, tag->rival + ": nothing passes by it");
}

void Gateway::take_tag_news(std::size_t port, const enforce::FoundBinding& found, TagNews& news) {
  Tag* const tag = tags_.find(ports_.network_number(port), found.subject);
  if (tag == nullptr || tag->etag != found.etag) return;
  news.seen.emplace(tag, found);
  if (tag->dynamic) tag->dealt = found.dealt != tag->etag ? found.dealt : std::uint16_t{0};
  if (!found.contradicted || tag->etag == 0) return;
  if (tag->contradiction.empty()) {
    tag->contradiction = contradiction_words(*tag, found);
    tell_tag(*tag, 3, tag->contradiction + ": its frames are dropped");
    news.changed = true;
  }
  // At first only half of the other subject may have been known.
  if (found.halves == 3)
    if (auto whole = contradiction_words(*tag, found); whole != tag->contradiction) {
      tag->contradiction = std::move(whole);
      news.changed = true;
    }
  if (found.confirmed) news.confirmed.push_back(tag);
}

/// The old identifier is closed before the new one opens. `anyway`: also where no gate has found
/// anything. False: nothing is left of this round.
bool Gateway::look_at_tags(bool anyway) {
  TagNews news;
  for (std::size_t p = 0; p < ports_.size(); ++p) {
    const enforce::Gate* gate = ports_.can_gate(p);
    if (gate == nullptr || ports_.profile(p) != core::Profile::famouso) continue;
    const enforce::Bindings bindings = gate->bindings();
    const std::uint32_t now = bindings.news();
    const auto seen = tag_news_.find(gate->ifindex());
    if (!anyway && seen != tag_news_.end() && seen->second == now) continue;
    tag_news_[gate->ifindex()] = now;
    for (const enforce::FoundBinding& found : bindings.found()) take_tag_news(p, found, news);
  }
  if (news.seen.empty() && !anyway) return false;
  const auto rivals = tags_.hold_apart();
  tell_rivals(rivals);
  if (news.changed || !rivals.empty()) {
    put_conditions(*scene_.state);
    static_cast<void>(settle());
  }
  core::FormerRules left;
  if (!move_tags(news, left) && news.confirmed.empty()) return false;
  state_tags();
  for (Tag* const tag : news.confirmed) {
    if (tag->contradiction.empty() || !agree_on(*tag)) continue;
    tag->contradiction.clear();
    tell_tag(
        *tag, 5,
        fmt::format("the broker deals it tag {:#x} on {} again", tag->etag, tag->network_name));
  }
  put_conditions(*scene_.state);
  static_cast<void>(settle(left));
  static_cast<void>(enforce());  // control traffic has moved, too
  return false;
}

/// True if any has moved. Without a gate that has said so a tag is only given up.
bool Gateway::move_tags(const TagNews& news, core::FormerRules& left) {
  bool moved = false;
  for (Tag& tag : tags_.all()) {
    const std::uint16_t etag = tag.due();
    const auto seen = news.seen.find(&tag);
    if (!tag.dynamic || etag == tag.etag || (etag != 0 && seen == news.seen.end())) continue;
    tag.etag = etag;
    move_tag(tag, left);
    moved = true;
    if (seen == news.seen.end()) continue;
    for (std::size_t p = 0; p < ports_.size(); ++p)
      if (enforce::Gate* gate = ports_.can_gate(p);
          gate != nullptr && ports_.network_number(p) == tag.network)
        gate->bindings().move(seen->second, etag);
  }
  return moved;
}

/// Nothing of it is granted any more: see look_at_tags().
void Gateway::move_tag(Tag& tag, core::FormerRules& left) {
  if (tag.channel)
    left.try_emplace(*tag.channel, scene_.state->gate_state(scene_.self, *tag.channel));
  put_tag(tag);
  if (tag.etag != 0) {
    tell_tag(tag, 5, fmt::format("it has tag {:#x} on {} now", tag.etag, tag.network_name));
    tag.dealt = 0;
  }
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
  log_.write({.kind = Kind::binding,
              .priority = priority,
              .message = tag.name + ": " + std::move(message),
              .subject = tag.subject,
              .channel = tag.name,
              .network = tag.network_name});
}

}  // namespace mlcca
