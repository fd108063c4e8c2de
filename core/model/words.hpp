// SPDX-License-Identifier: BSD-2-Clause
// The texts of enumerators as they appear in descriptions, files of links and outputs.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "core/mesh/graph.hpp"
#include "core/mesh/mesh.hpp"
#include "core/model/system.hpp"

namespace mlcca::core {

/// One text per enumerator, in the order of the enumeration. The first is the default of a
/// description that states nothing.
template <class Enum, std::size_t N>
struct Words : std::array<std::string_view, N> {
  [[nodiscard]] constexpr std::string_view of(Enum value) const {
    return (*this)[static_cast<std::size_t>(value)];
  }
  /// The enumerator with that text; nullopt if there is none.
  [[nodiscard]] constexpr std::optional<Enum> find(std::string_view word) const {
    const auto at = std::ranges::find(*this, word);
    if (at == this->end()) return std::nullopt;
    return static_cast<Enum>(at - this->begin());
  }
  [[nodiscard]] constexpr Enum or_first(std::string_view word) const {
    return find(word).value_or(Enum{});
  }
};

namespace words {

inline constexpr Words<NetworkKind, 6> kNetworkKinds{
    {"can", "udp-multicast", "udp-broadcast", "mesh", "ieee802154", "other"}};
inline constexpr Words<Profile, kProfileCount> kProfiles{{
#define PROFILE(word, NAME) #word,
#include "core/profiles/list.inc"
}};
inline constexpr Words<FrameFormat, 4> kFrameFormats{{"classic", "fd", "any", "xl"}};
inline constexpr Words<SafeSide, 3> kSafeSides{{"", "drop", "deliver"}};
inline constexpr Words<Arrival, 2> kArrivals{{"periodic", "sporadic"}};
inline constexpr Words<Queueing, 2> kQueueings{{"fifo", "priority"}};
inline constexpr Words<Excess, 2> kExcesses{{"drop", "pass"}};
inline constexpr Words<Refused, 2> kRefusals{{"error", "silent"}};
inline constexpr Words<Subscribing, 4> kSubscribings{{"", "gateways", "attributes", "all"}};
inline constexpr Words<Forwarder, 3> kForwarders{{"relay", "can-gw", "none"}};
inline constexpr Words<Better, 2> kBetters{{"smaller", "larger"}};
inline constexpr Words<mesh::Interference, 4> kInterferences{
    {"single-domain", "k-hop", "channel", "explicit"}};
inline constexpr Words<mesh::RateKind, 3> kRateKinds{{"phy", "effective", "derived"}};
inline constexpr Words<mesh::Lack, 4> kLacks{{"gone", "absent", "rate unknown", "must last"}};
inline constexpr Words<mesh::SourceKind, 8> kSourceKinds{
    {"description", "file", "nl80211", "batman", "awds", "babel", "olsr", "wire"}};
inline constexpr Words<mesh::AwdsMetric, 4> kAwdsMetrics{
    {"etx", "hops", "packet-pair", "transmission-time"}};

}  // namespace words
}  // namespace mlcca::core
