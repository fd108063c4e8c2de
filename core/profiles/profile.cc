// SPDX-License-Identifier: BSD-2-Clause
#include "core/profiles/profile.hpp"

#include <algorithm>
#include <array>

#include "core/model/words.hpp"
#include "core/profiles/definition.hpp"

namespace mlcca::core {
namespace {

constexpr std::array kProfiles = {
#define PROFILE(word, NAME) &profiles::word,
#include "core/profiles/list.inc"
};
static_assert(kProfiles.size() == kProfileCount);

}  // namespace

namespace profiles {

FrameIdentity with_priority(const Publisher& p, const Binding& b) {
  FrameIdentity f{.id = b.id << kNumberShift | *p.node, .mask = kExtendedBits};
  if (b.priority)
    f.id |= static_cast<std::uint32_t>(*b.priority) << kPriorityShift;
  else
    f.mask &= ~kPriorityBits;
  return f;
}

}  // namespace profiles

const ProfileTraits& traits_of(Profile profile) {
  return *kProfiles.at(static_cast<std::size_t>(profile));
}

const Fragmentation& transport_protocol() {
  const auto* const found = std::ranges::find_if(kProfiles, [](const ProfileTraits* traits) {
    return traits->fragmentation != nullptr && traits->fragmentation->carriers != nullptr;
  });
  return *(*found)->fragmentation;
}

const ProfileTraits* profile_with_element(std::string_view element) {
  const auto* const found = std::ranges::find_if(kProfiles, [&](const ProfileTraits* traits) {
    return traits->element.substr(traits->element.find(' ') + 1) == element;
  });
  return found == kProfiles.end() ? nullptr : *found;
}

namespace {

using Names = std::vector<std::string_view>;

Names words_of(bool (*has)(const ProfileTraits&)) {
  Names out;
  for (std::size_t i = 0; i < kProfiles.size(); ++i)
    if (has(*kProfiles[i])) out.push_back(words::kProfiles[i]);
  return out;
}

std::string listed(const Names& all, std::string_view last) {
  std::string out;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i > 0) out.append(i + 1 == all.size() ? last : ", ");
    out.append(all[i]);
  }
  return out;
}

}  // namespace

std::string profiles_with(bool (*has)(const ProfileTraits&), std::string_view last) {
  return listed(words_of(has), last);
}

std::string for_profiles_with(bool (*has)(const ProfileTraits&)) {
  return (words_of(has).size() == 1 ? "profile " : "profiles ") + profiles_with(has);
}

std::string elements_with(bool (*has)(const ProfileTraits&)) {
  Names all;
  for (const ProfileTraits* const traits : kProfiles)
    if (has(*traits)) all.push_back(traits->element);
  return listed(all, " and ");
}

bool Network::carries_subjects() const {
  return kind != NetworkKind::can && traits_of(profile).datagrams != nullptr;
}

bool has_subscriptions(const Network& network) {
  const ProfileTraits& traits = traits_of(network.profile);
  if (network.kind == NetworkKind::can)
    return std::ranges::any_of(traits.control, &ControlKind::is_tagged);
  return network.carries_subjects() &&
         std::ranges::any_of(traits.datagram_control, &ControlKind::is_tagged);
}

bool can_send(const Publisher& publisher, const Network& network) {
  if (!has_nodes(network.profile)) return true;
  return publisher.node && *publisher.node <= traits_of(network.profile).last_node;
}

std::optional<Sender> sender_of(const System& system, const Publisher& publisher) {
  const Sender local{.channel = publisher.channel,
                     .place = publisher.place,
                     .node = publisher.node,
                     .uid = publisher.uid};
  if (publisher.place.kind == Place::Kind::gateway)
    return publisher.uid ? std::optional(local) : std::nullopt;
  const Network& network = system.networks[publisher.place.index];
  if (!names_channels(network.profile)) return std::nullopt;
  if (has_nodes(network.profile)) return publisher.node ? std::optional(local) : std::nullopt;
  // No frame there contains a node; a stated one applies to networks further on.
  Sender anonymous = local;
  anonymous.node = std::nullopt;
  return anonymous;
}

std::string_view way_to_differ(const Publisher& publisher) {
  if (publisher.place.kind == Place::Kind::gateway)
    return "give it another user, or a node of its own";
  return publisher.node ? "give it a node of its own"
                        : "an identifier has one sender on a bus: describe one of them, or give "
                          "its events a channel of their own";
}

std::optional<FrameIdentity> identity_of(const Publisher& publisher, const Network& network,
                                         const Binding& binding, bool fragmented) {
  if (!names_channels(network.profile) || !can_send(publisher, network)) return std::nullopt;
  FrameIdentity f = traits_of(network.profile).identity(publisher, binding, fragmented);
  if (binding.extended) f.id |= kExtendedFlag;
  f.mask |= kExtendedFlag;
  return f;
}

bool clash(Profile profile, const Binding& a, const Binding& b) {
  return a.extended == b.extended && traits_of(profile).overlap(a, b);
}

}  // namespace mlcca::core
