// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/local_ends.hpp"

#include <algorithm>
#include <utility>

#include "control/local_address.hpp"

namespace mlcca {
Result<void> LocalEnds::add(const core::EventChannel& channel, uid_t user, std::uint64_t session,
                            const std::string& address) {
  // The address is not repeated in the error: it may be almost a key.
  if (!control::local_address_in(address))
    return fail(
        "local is the name of a socket that was bound without one (unix(7)) and its key: 5 and 16 "
        "hexadecimal digits in lower case");
  Ends& ends = ends_[channel.subject];
  const auto known = ends.by_session.find(session);
  if (known != ends.by_session.end() && known->second.address == address) return {};
  if (known == ends.by_session.end())
    if (auto why = refusal(channel.name, ends, user)) return fail(std::move(*why));
  ends.channel = channel.name;
  ends.by_session[session] = {user, address};
  report(channel.subject, channel.name);
  return {};
}

std::optional<std::string> LocalEnds::refusal(const std::string& channel, const Ends& ends,
                                              uid_t user) {
  if (ends.by_session.size() >= kMostOfChannel)
    return channel + " has " + std::to_string(kMostOfChannel) +
           " subscribers on this gateway, which is the most";
  const auto of_user = std::ranges::count_if(
      ends.by_session, [user](const auto& one) { return one.second.user == user; });
  if (user != 0 && static_cast<std::size_t>(of_user) >= kMostOfUser)
    return "user " + std::to_string(user) + " has " + std::to_string(of_user) + " of the " +
           std::to_string(kMostOfChannel) + " places of " + channel +
           " for subscribers on this gateway, which is the most of one user";
  return std::nullopt;
}

void LocalEnds::session_closed(std::uint64_t session) {
  for (auto it = ends_.begin(); it != ends_.end();) {
    if (it->second.by_session.erase(session) != 0) report(it->first, it->second.channel);
    it = it->second.by_session.empty() ? ends_.erase(it) : std::next(it);
  }
}

std::vector<LocalEnds::End> LocalEnds::all(core::Subject subject) const {
  std::vector<End> out;
  const auto known = ends_.find(subject);
  if (known == ends_.end()) return out;
  for (const auto& [session, end] : known->second.by_session)
    if (std::ranges::find(out, end) == out.end()) out.push_back(end);
  return out;
}

void LocalEnds::report(core::Subject subject, const std::string& channel) {
  control::Event event;
  event.kind = "local";
  event.subject = subject;
  event.channel = channel;
  event.message = "the subscribers of " + channel + " on this gateway are others";
  log_.notify_clients(std::move(event));
}

}  // namespace mlcca
