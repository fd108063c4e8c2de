// SPDX-License-Identifier: BSD-2-Clause
// The message by which a gateway announces its presence to others. It is an event of the subject
// SUBSCRIB that begins with that subject, like subscriptions (relay/famouso/subscription.hpp):
//
//   octets  0 to 7   "SUBSCRIB"
//           8        version: 1
//           9        kind: 5
//          10 to 17  how long the announcement is valid, ns; 2^64-1: without limit
//          18        1: the gateway forwards; 0: it leaves that to others
//          19 …      its name, then those of the gateways that it does not receive, as far as
//                    they fit: each as its length, 1 to 63, and as many characters
//
// For example, 5355425343524942 01 05 000000009502f900 01 04 6d61696e announces "main" as present
// for 2.5 s and as forwarding.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "relay/famouso/subscription.hpp"
#include "relay/layers/layer.hpp"

namespace mlcca::relay {

/// The content of an announcement.
struct Announcement {
  std::string gateway;
  std::uint64_t lasts_ns = 0;
  bool forwards = false;
  std::vector<std::string> not_received{};
  bool operator==(const Announcement&) const = default;
};

/// Nullopt if the event is no announcement. Names may have letters, digits, dots, underscores and
/// hyphens.
[[nodiscard]] std::optional<Announcement> parse_announcement(Octets event);
/// The message in at most `longest` octets; names of `not_received` that do not fit are left out.
[[nodiscard]] std::vector<std::uint8_t> encode(const Announcement& announcement,
                                               std::size_t longest = kLongestSubscription);

}  // namespace mlcca::relay
