// SPDX-License-Identifier: BSD-2-Clause
// Events of the subject SUBSCRIB. A node of FAMOUSO sends the 8 octets of a subject, once, and that
// is all. Ours have what it requires, and are answered. They begin with SUBSCRIB itself, which
// FAMOUSO's own gateways take for the sign of another gateway, and ignore:
//
//   octets  0 to 7   "SUBSCRIB"
//           8        version: 1
//           9        kind: 1 subscribe, 2 end, 3 granted, 4 refused
//          10 to 13  number of the subscription, chosen by who subscribes; answers repeat it
//          14, 15    lease in seconds, of 1; else 0
//          16        gateways that may still pass it on, of 1; else 0
//          17 …      of 1: subject and requirement as the run-time representation has them
//                    (proto/mlcca.asn1), as a compile-time specification gives them, too;
//                    else the subject, and of 4 why, in ASCII
//
// For example 53554253435249 42 01 02 00000007 0000 00 44697374616e6365 ends number 7 of
// "Distance".
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mlcca/attribute.hpp"
#include "relay/layers/layer.hpp"

namespace mlcca::relay {

inline constexpr std::uint64_t kSubscriptionSubject = 0x5355425343524942;  ///< "SUBSCRIB"
/// Of the messages that begin with SUBSCRIB itself.
inline constexpr std::uint8_t kSubscriptionVersion = 1;
inline constexpr std::size_t kLongestSubscription = 256;  ///< octets

struct Subscription {
  enum class Kind : std::uint8_t {
    plain = 0,  ///< of a node of FAMOUSO: the subject alone
    subscribe = 1,
    end = 2,
    granted = 3,
    refused = 4,
  };
  Kind kind = Kind::plain;
  std::uint64_t subject = 0;
  std::uint32_t number = 0;
  std::uint16_t lease_s = 0;
  std::uint8_t hops = 0;
  AttributeSet required{};
  bool has_user_attributes = false;  ///< beside these, which are not read
  std::string reason{};              ///< printable, kLongestReason at most
  bool operator==(const Subscription&) const = default;
};

inline constexpr std::size_t kLongestReason = 200;  ///< octets

/// What a message may have where it is sent: on IEEE 802.15.4 it has to fit a frame.
[[nodiscard]] std::size_t longest_at(const control::Endpoint& endpoint);

/// Nothing: it is none, or one of a version or kind that is not known.
[[nodiscard]] std::optional<Subscription> parse_subscription(Octets event);
/// A reason is cut off where the message would have more than `longest` octets; what is required is
/// not.
[[nodiscard]] std::vector<std::uint8_t> encode(const Subscription& subscription,
                                               std::size_t longest = kLongestSubscription);

}  // namespace mlcca::relay
