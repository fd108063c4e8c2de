// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/tags.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <tuple>
#include <utility>

#include "base/big_endian.hpp"
#include "core/gates/control_traffic.hpp"
#include "core/model/text.hpp"
#include "core/profiles/profile.hpp"

namespace mlcca {
namespace {

constexpr std::uint32_t kRequestId = 0x1f400002;  // priority 0x7d, etag 2
constexpr unsigned kNodeShift = 14;
constexpr unsigned kHalfBits = 32;

auto place_of(const Tag& tag) { return std::tuple(tag.network, tag.subject); }

void add_tags_of(const core::System& system, std::size_t n, std::vector<Tag>& to) {
  const core::Network& network = system.networks[n];
  const std::size_t first = to.size();
  const bool is_channel = std::ranges::find(system.channels, core::kSubscribeSubject,
                                            &core::EventChannel::subject) != system.channels.end();
  const auto add = [&](core::Subject subject, std::string name) -> Tag& {
    Tag& tag = to.emplace_back();
    tag.network = n;
    tag.network_name = network.name;
    tag.subject = subject;
    tag.name = std::move(name);
    return tag;
  };
  if (!is_channel) {
    Tag& own = add(core::kSubscribeSubject, "SUBSCRIB");
    own.dynamic = !network.states_subscribe_tag;
    own.etag = static_cast<std::uint16_t>(own.dynamic ? 0 : network.subscribe_tag);
  }
  for (const core::Binding& b : network.bindings) {
    Tag& tag = add(system.channels[b.channel].subject, system.channels[b.channel].name);
    tag.channel = b.channel;
    tag.dynamic = b.dynamic;
    tag.etag = static_cast<std::uint16_t>(b.dynamic ? 0 : b.id);
    tag.is_in_gates = to.size() - first <= GATE_BINDINGS;
  }
  std::ranges::sort(std::span(to).subspan(first), {}, place_of);
}

}  // namespace

void Tags::describe(const core::System& system, std::size_t gateway) {
  std::vector<Tag> next;
  for (std::size_t n = 0; n < system.networks.size(); ++n)
    if (core::has_broker(system.networks[n]) && system.gateways[gateway].port_on(n) != nullptr)
      add_tags_of(system, n, next);
  for (Tag& tag : next) {
    const auto known = std::ranges::find_if(tags_, [&](const Tag& t) {
      return t.network_name == tag.network_name && t.subject == tag.subject &&
             t.dynamic == tag.dynamic && (t.dynamic || t.etag == tag.etag);
    });
    if (known == tags_.end()) continue;
    tag.etag = known->etag;
    tag.dealt = known->dealt;
    tag.contradiction = known->contradiction;
    tag.rival = known->rival;
    tag.asked = known->asked;
    tag.wait = known->wait;
  }
  tags_ = std::move(next);
}

namespace {

std::uint16_t claim_of(const Tag& tag) { return tag.dealt != 0 ? tag.dealt : tag.etag; }

std::string rival_words(const Tag& tag, const Tag& other) {
  if (tag.dealt == 0)
    return fmt::format("the broker has dealt its tag {:#x} on {} to {}", tag.etag, tag.network_name,
                       subject_words(other.subject));
  return fmt::format("the broker has dealt it tag {:#x} on {}, which is that of {}", tag.dealt,
                     tag.network_name, other.name);
}

/// Of several subjects that claim one tag at most one keeps it, closed. The others give theirs up.
void give_up(std::span<Tag*> claimants) {
  const bool stated = !std::ranges::all_of(claimants, &Tag::dynamic);
  const auto holders = std::ranges::count_if(claimants, [](Tag* t) { return t->dealt == 0; });
  for (Tag* const tag : claimants)
    if (tag->dynamic && tag->dealt == 0 && (stated || holders > 1)) tag->dealt = tag->etag;
}

}  // namespace

std::vector<Tag*> Tags::hold_apart() {
  std::map<std::pair<std::size_t, std::uint16_t>, std::vector<Tag*>> claims;
  for (Tag& tag : tags_)
    if (claim_of(tag) != 0) claims[{tag.network, claim_of(tag)}].push_back(&tag);
  std::map<const Tag*, std::string> rivals;
  for (auto& [tag, claimants] : claims) {
    if (claimants.size() == 1) continue;
    give_up(claimants);
    for (const Tag* const one : claimants)
      rivals.emplace(one, rival_words(*one, *(one == claimants[0] ? claimants[1] : claimants[0])));
  }
  std::vector<Tag*> changed;
  for (Tag& tag : tags_) {
    std::string rival = std::move(rivals[&tag]);
    if (!tag.is_in_gates)
      rival = fmt::format("no gate holds more than {} tags of {} against the broker", GATE_BINDINGS,
                          tag.network_name);
    if (rival == tag.rival) continue;
    tag.rival = std::move(rival);
    changed.push_back(&tag);
  }
  return changed;
}

Tag* Tags::find(std::size_t network, core::Subject subject) {
  const auto it = std::ranges::lower_bound(tags_, std::tuple(network, subject), {}, place_of);
  return it != tags_.end() && place_of(*it) == std::tuple(network, subject) ? &*it : nullptr;
}

std::vector<gates::StatedBinding> Tags::stated(std::size_t network) const {
  std::vector<gates::StatedBinding> out;
  for (const Tag& tag : tags_)
    if (tag.network == network && tag.is_in_gates)
      out.push_back({.subject = tag.subject,
                     .etag = tag.etag,
                     .contradicted = !tag.contradiction.empty(),
                     .dealt = tag.dealt != 0 || !tag.dynamic ? tag.dealt : tag.etag});
  return out;
}

std::vector<core::Contradicted> Tags::contradicted(std::size_t network) const {
  std::vector<core::Contradicted> out;
  for (const Tag& tag : tags_)
    if (tag.network == network && tag.channel && !tag.problem().empty())
      out.push_back({*tag.channel, tag.problem()});
  std::ranges::sort(out, {}, &core::Contradicted::channel);
  return out;
}

std::vector<store::Contradicted> Tags::to_keep() const {
  std::vector<store::Contradicted> out;
  for (const Tag& tag : tags_)
    if (!tag.dynamic && tag.is_in_gates && !tag.problem().empty())
      out.push_back({tag.network_name, tag.subject, tag.etag, tag.problem()});
  return out;
}

std::vector<Tag*> Tags::recall(const store::Contents& kept) {
  std::vector<Tag*> closed;
  for (const auto& [key, entry] : kept.contradicted)
    for (Tag& tag : tags_) {
      if (tag.subject != entry.subject || tag.network_name != entry.network || tag.dynamic ||
          tag.etag != entry.etag || tag.is_confirmed || !tag.problem().empty())
        continue;
      tag.contradiction = entry.how;
      closed.push_back(&tag);
    }
  return closed;
}

Tag* Tags::to_ask_for(std::size_t network, std::uint64_t now) {
  Tag* next = nullptr;
  for (Tag& tag : tags_) {
    if (tag.network != network || !tag.is_wanted() ||
        (tag.asked != 0 && now < tag.asked + tag.wait))
      continue;
    if (next == nullptr || tag.asked < next->asked) next = &tag;
  }
  return next;
}

std::string subject_words(core::Subject subject) {
  std::string text;
  for (int shift = 56; shift >= 0; shift -= 8) {
    const auto c = static_cast<char>(subject >> shift & 0xff);
    if (c == 0 && !text.empty()) continue;  // short subjects end in NULs
    if (c < ' ' || c > '~') return core::format_subject(subject);
    text += c;
  }
  return fmt::format("{} ({})", core::format_subject(subject), text);
}

std::string contradiction_words(const Tag& tag, const gates::FoundBinding& found) {
  if (found.halves == 0)
    return found.dealt != 0 && found.dealt != tag.etag
               ? fmt::format("the broker has dealt it tag {:#x} on {}, and not {:#x}", found.dealt,
                             tag.network_name, tag.etag)
               : fmt::format("another tag than its {:#x} was dealt to it on {}", tag.etag,
                             tag.network_name);
  const std::string what =
      fmt::format("the broker has dealt its tag {:#x} on {} to ", tag.etag, tag.network_name);
  if (found.halves == 1)
    return what + fmt::format("a subject that begins with {:#010x}", found.other >> kHalfBits);
  if (found.halves == 2)
    return what + fmt::format("a subject that ends in {:#010x}", found.other & 0xffffffffU);
  return what + subject_words(found.other);
}

can_frame request_for_tag(std::uint8_t node, core::Subject subject) {
  can_frame frame{};
  frame.can_id = CAN_EFF_FLAG | kRequestId | std::uint32_t{node} << kNodeShift;
  frame.can_dlc = CAN_MAX_DLEN;
  const auto octets = big_endian(subject);
  std::ranges::copy(octets, std::begin(frame.data));
  return frame;
}

}  // namespace mlcca
