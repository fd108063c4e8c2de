// SPDX-License-Identifier: BSD-2-Clause
// The message by which a gateway announces itself to others, an event of the subject SUBSCRIB that
// begins with SUBSCRIB itself, as subscriptions do (relay/famouso/subscription.hpp):
//
//   octets  0 to 7   "SUBSCRIB"
//           8        version: 1
//           9        kind: 5
//          10 to 17  for how long it is there, ns; 2^64-1: for ever
//          18        1: it forwards, 0: it leaves that to others
//          19 …      its name, then those of gateways of which it receives nothing, as far as there
//                    is room: each as its length, 1 to 63, and as many characters
//
// For example 5355425343524942 01 05 000000009502f900 01 04 6d61696e is of "main", which is there
// for 2.5 s and forwards.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "relay/famouso/subscription.hpp"
#include "relay/layers/layer.hpp"

namespace mlcca::relay {

struct Announcement {
  std::string gateway;
  std::uint64_t lasts_ns = 0;
  bool forwards = false;
  std::vector<std::string> not_received{};
  bool operator==(const Announcement&) const = default;
};

/// Nothing: it is none. Names are of letters, digits, dots, underscores and hyphens.
[[nodiscard]] std::optional<Announcement> parse_announcement(Octets event);
/// At most `longest` octets: names that do not fit are left out.
[[nodiscard]] std::vector<std::uint8_t> encode(const Announcement& announcement,
                                               std::size_t longest = kLongestSubscription);

}  // namespace mlcca::relay
