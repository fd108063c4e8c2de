// SPDX-License-Identifier: BSD-2-Clause
#include "relay/famouso/subscription.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "base/big_endian.hpp"
#include "base/text.hpp"
#include "mlcca/der_decode.hpp"
#include "mlcca/der_encode.hpp"

namespace mlcca::relay {
namespace {

using Kind = Subscription::Kind;

constexpr std::size_t kSubjectSize = 8;
constexpr std::size_t kNumberAt = 10;
constexpr std::size_t kLeaseAt = 14;
constexpr std::size_t kHopsAt = 16;
constexpr std::size_t kHeader = 17;

/// The text with each character replaced that a log cannot show.
std::string printable_reason(Octets text) {
  std::string out(text.begin(), text.end());
  std::ranges::replace_if(out, [](unsigned char c) { return c < ' ' || c >= 127; }, '?');
  return out;
}

bool read_requirement(Octets event, Subscription& to) {
  der::Decoded decoded;
  if (!der::decode(event.data(), event.size(), &decoded).ok()) return false;
  if (decoded.role != der::Role::subscriber) return false;
  to.subject = decoded.subject;
  to.required = decoded.attributes;
  to.has_user_attributes = !decoded.user.empty();
  return true;
}

}  // namespace

std::optional<Subscription> parse_subscription(Octets event) {
  if (event.size() < kSubjectSize) return std::nullopt;
  Subscription out;
  out.subject = from_big_endian(event.first(kSubjectSize));
  if (out.subject != kSubscriptionSubject)
    return out.subject != 0 ? std::optional(out) : std::nullopt;
  if (event.size() <= kHeader || event[kSubjectSize] != kSubscriptionVersion) return std::nullopt;
  out.kind = static_cast<Kind>(event[kSubjectSize + 1]);
  out.number =
      static_cast<std::uint32_t>(from_big_endian(event.subspan(kNumberAt, sizeof out.number)));
  out.lease_s =
      static_cast<std::uint16_t>(from_big_endian(event.subspan(kLeaseAt, sizeof out.lease_s)));
  out.hops = event[kHopsAt];
  const Octets rest = event.subspan(kHeader);
  if (out.kind == Kind::subscribe)
    return read_requirement(rest, out) ? std::optional(out) : std::nullopt;
  const bool is_known =
      out.kind == Kind::end || out.kind == Kind::granted || out.kind == Kind::refused;
  if (!is_known || rest.size() < kSubjectSize) return std::nullopt;
  out.subject = from_big_endian(rest.first(kSubjectSize));
  const Octets text = rest.subspan(kSubjectSize);
  if (out.kind == Kind::refused) out.reason = printable_reason(text);
  if (out.subject == 0 || text.size() > (out.kind == Kind::refused ? kLongestReason : 0))
    return std::nullopt;
  return out;
}

std::size_t longest_at(const control::Endpoint& endpoint) {
  return endpoint.wpan ? std::min<std::size_t>(endpoint.frame_bytes, kLongestSubscription)
                       : kLongestSubscription;
}

std::vector<std::uint8_t> encode(const Subscription& subscription, std::size_t longest) {
  std::vector<std::uint8_t> out;
  const auto put = [&](std::uint64_t value, std::size_t size) {
    for (std::size_t i = size; i-- > 0;)
      out.push_back(static_cast<std::uint8_t>(value >> 8U * static_cast<unsigned>(i)));
  };
  if (subscription.kind == Kind::plain) {
    put(subscription.subject, kSubjectSize);
    return out;
  }
  put(kSubscriptionSubject, kSubjectSize);
  put(kSubscriptionVersion, 1);
  put(static_cast<std::uint8_t>(subscription.kind), 1);
  put(subscription.number, sizeof subscription.number);
  put(subscription.lease_s, sizeof subscription.lease_s);
  put(subscription.hops, 1);
  if (subscription.kind == Kind::subscribe) {
    std::array<std::uint8_t, der::kMaxPlainSize> blob{};
    const std::size_t size = der::encode(
        der::Channel(der::Role::subscriber, subscription.subject, subscription.required),
        blob.data(), blob.size());
    out.insert(out.end(), blob.begin(), blob.begin() + static_cast<std::ptrdiff_t>(size));
    return out;
  }
  put(subscription.subject, kSubjectSize);
  if (subscription.kind == Kind::refused) {
    const std::size_t room = longest > out.size() ? longest - out.size() : 0;
    const std::string_view reason = cut(subscription.reason, std::min(room, kLongestReason));
    out.insert(out.end(), reason.begin(), reason.end());
  }
  return out;
}

}  // namespace mlcca::relay
