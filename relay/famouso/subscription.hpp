// SPDX-License-Identifier: BSD-2-Clause
// Events of the subject SUBSCRIB. A node of FAMOUSO sends once the 8 octets of the subject that it
// subscribes to. Gateways state what they require as well, and get an answer. Their messages begin
// with SUBSCRIB itself, which FAMOUSO's own gateways take as a sign of another gateway and ignore:
//
//   octets  0 to 7   "SUBSCRIB"
//           8        version: 1
//           9        kind: 1 subscribe, 2 end, 3 granted, 4 refused
//          10 to 13  number of the subscription, chosen by the subscriber; answers repeat it
//          14, 15    kind 1: lease in seconds; otherwise 0
//          16        kind 1: gateways that may still pass it on; otherwise 0
//          17 …      kind 1: subject and requirement in the run-time representation
//                    (proto/mlcca.asn1), which a compile-time specification yields as well;
//                    otherwise the subject, and for kind 4 the reason in ASCII
//
// For example, 53554253435249 42 01 02 00000007 0000 00 44697374616e6365 ends number 7 of
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
/// Version of the messages that begin with SUBSCRIB itself.
inline constexpr std::uint8_t kSubscriptionVersion = 1;
inline constexpr std::size_t kLongestSubscription = 256;  ///< octets

/// A message of the subject SUBSCRIB.
struct Subscription {
  /// The kind of message, with its number in octet 9.
  enum class Kind : std::uint8_t {
    plain = 0,  ///< from a node of FAMOUSO: the subject alone
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
  bool has_user_attributes = false;  ///< it has user-defined attributes as well, which are not
                                     ///< decoded
  std::string reason{};              ///< printable, at most kLongestReason octets
  bool operator==(const Subscription&) const = default;
};

inline constexpr std::size_t kLongestReason = 200;  ///< octets

/// Largest message at an endpoint in octets; on IEEE 802.15.4 it has to fit one frame.
[[nodiscard]] std::size_t longest_at(const control::Endpoint& endpoint);

/// Nullopt if the event is no such message, or if its version or kind is unknown.
[[nodiscard]] std::optional<Subscription> parse_subscription(Octets event);
/// Encodes a message. If it had more than `longest` octets, the reason is cut; the requirement is
/// not.
[[nodiscard]] std::vector<std::uint8_t> encode(const Subscription& subscription,
                                               std::size_t longest = kLongestSubscription);

}  // namespace mlcca::relay
