// SPDX-License-Identifier: BSD-2-Clause
#include "relay/famouso/announcement.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "base/ascii.hpp"
#include "base/big_endian.hpp"
#include "mlcca/der_decode.hpp"

namespace mlcca::relay {
namespace {

constexpr std::uint8_t kAnnouncementKind = 5;
constexpr std::size_t kLastsAt = 10;
constexpr std::size_t kForwardsAt = 18;
constexpr std::size_t kNamesAt = 19;

/// The names in the octets; nullopt if one of them is malformed.
std::optional<std::vector<std::string>> names_in(Octets rest) {
  std::vector<std::string> names;
  while (!rest.empty()) {
    const std::size_t size = rest.front();
    if (size == 0 || size > der::kMaxName || size >= rest.size()) return std::nullopt;
    const Octets name = rest.subspan(1, size);
    if (!std::ranges::all_of(name, [](std::uint8_t c) { return is_of_name(static_cast<char>(c)); }))
      return std::nullopt;
    names.emplace_back(name.begin(), name.end());
    rest = rest.subspan(1 + size);
  }
  return names;
}

void put_number(std::uint64_t number, std::vector<std::uint8_t>& to) {
  const std::array<std::uint8_t, sizeof number> octets = big_endian(number);
  to.insert(to.end(), octets.begin(), octets.end());
}

}  // namespace

std::optional<Announcement> parse_announcement(Octets event) {
  constexpr std::size_t number = sizeof(std::uint64_t);
  if (event.size() <= kNamesAt || event.size() > kLongestSubscription ||
      from_big_endian(event.first(number)) != kSubscriptionSubject ||
      event[number] != kSubscriptionVersion || event[number + 1] != kAnnouncementKind ||
      event[kForwardsAt] > 1)
    return std::nullopt;
  auto names = names_in(event.subspan(kNamesAt));
  if (!names) return std::nullopt;
  Announcement out{.gateway = std::move(names->front()),
                   .lasts_ns = from_big_endian(event.subspan(kLastsAt, number)),
                   .forwards = event[kForwardsAt] == 1};
  out.not_received.assign(std::make_move_iterator(names->begin() + 1),
                          std::make_move_iterator(names->end()));
  return out;
}

std::vector<std::uint8_t> encode(const Announcement& announcement, std::size_t longest) {
  std::vector<std::uint8_t> out;
  put_number(kSubscriptionSubject, out);
  out.push_back(kSubscriptionVersion);
  out.push_back(kAnnouncementKind);
  put_number(announcement.lasts_ns, out);
  out.push_back(announcement.forwards ? 1 : 0);
  const auto put = [&out, longest](const std::string& name) {
    if (out.size() + 1 + name.size() > longest) return;
    out.push_back(static_cast<std::uint8_t>(name.size()));
    out.insert(out.end(), name.begin(), name.end());
  };
  put(announcement.gateway);
  for (const std::string& name : announcement.not_received) put(name);
  return out;
}

}  // namespace mlcca::relay
