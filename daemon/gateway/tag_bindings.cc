// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/tag_bindings.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace mlcca {

/// Takes up what a gate has learned under an earlier daemon.
void TagBindings::take_up(std::size_t port, const gates::FoundBinding& found) {
  Tag* const tag = tags_.find(gates_.network_number(port), found.subject);
  if (tag == nullptr) return;
  // A tag that was stated before was not dealt by the broker.
  if (tag->dynamic && tag->etag == 0 && (found.contradicted || found.dealt == found.etag))
    tag->etag = found.etag;
  if (tag->dynamic && found.dealt != tag->etag) tag->dealt = found.dealt;
  tag->is_confirmed = tag->etag != 0 && tag->etag == found.etag;
  if (tag->is_confirmed && found.contradicted && tag->contradiction.empty()) {
    tag->contradiction = contradiction_words(*tag, found);
    report(*tag, 3, tag->contradiction);
  }
}

void TagBindings::take_up(Known known) {
  scene_.state->unlist_unused();
  tags_.describe(scene_.state->system(), scene_.self);
  for (std::size_t p = 0; p < gates_.size(); ++p) {
    const auto bindings = gates_.bindings(p);
    if (!bindings) continue;
    for (const gates::FoundBinding& found : bindings->found()) take_up(p, found);
  }
  report_rivals(tags_.hold_apart());
  if (known == Known::by_gates_and_disk)
    for (const Tag* const tag : tags_.recall(recorder_.contents()))
      report(*tag, 3, tag->contradiction);
  for (Tag& tag : tags_.all()) {
    if (!tag.dynamic) continue;
    // The next poll assigns any other tag that is due.
    if (tag.due() == 0) {
      tag.etag = 0;
      tag.contradiction.clear();
    }
    put(tag);
  }
  polled_.clear();
  state();
  note();
}

void TagBindings::add_to(std::vector<core::Condition>& conditions) const {
  for (std::size_t n = 0; n < conditions.size(); ++n)
    conditions[n].contradicted = tags_.contradicted(n);
}

void TagBindings::put(const Tag& tag) const {
  if (tag.channel)
    scene_.state->set_tag(tag.network, *tag.channel, tag.etag);
  else
    scene_.state->set_subscribe_tag(tag.network, tag.etag);
}

void TagBindings::claim() {
  tags_.describe(scene_.state->system(), scene_.self);
  state();
  poll(true);
  turn_.observe();  // a contradiction may have ended with its channel
  note();
  static_cast<void>(turn_.settle());
}

void TagBindings::leave_unused() {
  if (scene_.state->unlist_unused()) claim();
}

void TagBindings::state() {
  for (std::size_t p = 0; p < gates_.size(); ++p)
    if (auto bindings = gates_.bindings(p)) bindings->state(tags_.stated(gates_.network_number(p)));
}

void TagBindings::report_rivals(const std::vector<Tag*>& changed) {
  for (const Tag* tag : changed)
    if (!tag->rival.empty() && tag->contradiction.empty())
      report(*tag, 4, tag->rival + ": nothing passes by it");
}

void TagBindings::take(std::size_t port, const gates::FoundBinding& found, Poll& poll) {
  Tag* const tag = tags_.find(gates_.network_number(port), found.subject);
  if (tag == nullptr || tag->etag != found.etag) return;
  poll.seen.emplace(tag, found);
  if (tag->dynamic) tag->dealt = found.dealt != tag->etag ? found.dealt : std::uint16_t{0};
  if (!found.contradicted || tag->etag == 0) return;
  if (tag->contradiction.empty()) {
    tag->contradiction = contradiction_words(*tag, found);
    report(*tag, 3, tag->contradiction + ": its frames are dropped");
    poll.changed = true;
  }
  // At first only half of the other subject may have been known.
  if (found.halves == 3)
    if (auto whole = contradiction_words(*tag, found); whole != tag->contradiction) {
      tag->contradiction = std::move(whole);
      poll.changed = true;
    }
  if (found.confirmed) poll.confirmed.push_back(tag);
}

void TagBindings::poll(bool anyway) {
  Poll poll;
  for (std::size_t p = 0; p < gates_.size(); ++p) {
    const auto bindings = gates_.bindings(p);
    if (!bindings) continue;
    const int ifindex = gates_.gated_interface(p);
    const std::uint32_t now = bindings->news();
    const auto polled = polled_.find(ifindex);
    if (!anyway && polled != polled_.end() && polled->second == now) continue;
    polled_[ifindex] = now;
    for (const gates::FoundBinding& found : bindings->found()) take(p, found, poll);
  }
  if (poll.seen.empty() && !anyway) return;
  const auto rivals = tags_.hold_apart();
  report_rivals(rivals);
  if (poll.changed || !rivals.empty()) {
    turn_.observe();
    static_cast<void>(turn_.settle());
    note();
  }
  core::FormerRules left;
  if (!move(poll, left) && poll.confirmed.empty()) return;
  state();
  for (Tag* const tag : poll.confirmed) {
    if (tag->contradiction.empty() || !gates_agree_on(*tag)) continue;
    tag->contradiction.clear();
    report(*tag, 5,
           fmt::format("the broker deals it tag {:#x} on {} again", tag->etag, tag->network_name));
  }
  note();
  turn_.observe();
  static_cast<void>(turn_.settle(left));
  static_cast<void>(turn_.enforce());  // control traffic has moved as well
}

/// Moves tags to what is due; true if any has moved. A new tag needs a gate that has seen it;
/// without one a tag is only given up.
bool TagBindings::move(const Poll& poll, core::FormerRules& left) {
  bool moved = false;
  for (Tag& tag : tags_.all()) {
    const std::uint16_t etag = tag.due();
    const auto seen = poll.seen.find(&tag);
    if (!tag.dynamic || etag == tag.etag || (etag != 0 && seen == poll.seen.end())) continue;
    tag.etag = etag;
    move(tag, left);
    moved = true;
    if (seen == poll.seen.end()) continue;
    for (std::size_t p = 0; p < gates_.size(); ++p)
      if (auto bindings = gates_.bindings(p); bindings && gates_.network_number(p) == tag.network)
        bindings->move(seen->second, etag);
  }
  return moved;
}

/// Moves one tag. Nothing is granted by it any more: see poll().
void TagBindings::move(Tag& tag, core::FormerRules& left) {
  if (tag.channel)
    left.try_emplace(*tag.channel, scene_.state->gate_state(scene_.self, *tag.channel));
  put(tag);
  if (tag.etag != 0) {
    report(tag, 5, fmt::format("it has tag {:#x} on {} now", tag.etag, tag.network_name));
    tag.dealt = 0;
  }
  tag.contradiction.clear();
  tag.asked = tag.wait = 0;
}

/// Whether every gate of the network has seen that the tag is dealt as stated, after all
/// contradictions.
bool TagBindings::gates_agree_on(const Tag& tag) {
  bool agree = true;
  for (std::size_t p = 0; p < gates_.size(); ++p) {
    auto bindings = gates_.bindings(p);
    if (!bindings || gates_.network_number(p) != tag.network) continue;
    for (const gates::FoundBinding& found : bindings->found())
      if (found.subject == tag.subject && found.contradicted)
        agree = agree && found.confirmed && bindings->end_contradictions(tag.subject);
  }
  return agree;
}

void TagBindings::ask() {
  const std::uint64_t now = clock_.monotonic_ns();
  for (std::size_t p = 0; p < gates_.size(); ++p) {
    const auto node = gates_.described(p).node;
    if (!gates_.bindings(p) || !node || !gates_.problem(p).empty()) continue;
    Tag* const tag = tags_.to_ask_for(gates_.network_number(p), now);
    if (tag == nullptr) continue;
    const auto ifindex = static_cast<std::uint32_t>(gates_.gated_interface(p));
    if (!can_.send(ifindex, request_for_tag(*node, tag->subject))) continue;
    tag->asked = now;
    tag->wait = tag->wait == 0 ? kFirstTagWait : std::min(2 * tag->wait, kLongestTagWait);
  }
  std::string why = problem();
  if (why == reported_) return;
  if (why.empty())
    log_.notice(Kind::gateway, "brokers can be asked for tags again");
  else
    log_.warning(Kind::gateway, why);
  reported_ = std::move(why);
}

std::string TagBindings::problem() const {
  if (can_.problem().empty() || std::ranges::none_of(tags_.all(), &Tag::is_wanted)) return {};
  return "no broker can be asked for a tag (systemctl status mlcca-can.socket): " + can_.problem();
}

void TagBindings::report(const Tag& tag, int priority, std::string message) {
  log_.write({.kind = Kind::binding,
              .priority = priority,
              .message = tag.name + ": " + std::move(message),
              .subject = tag.subject,
              .channel = tag.name,
              .network = tag.network_name});
}

}  // namespace mlcca
