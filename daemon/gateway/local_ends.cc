// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/local_ends.hpp"

#include <algorithm>
#include <ranges>
#include <utility>

namespace mlcca {
std::optional<std::string> LocalEnds::add(const core::EventChannel& channel, const Program& program,
                                          const std::string& address) {
  Ends& ends = ends_[channel.subject];
  const auto known = ends.by_session.find(program.session);
  if (known == ends.by_session.end()) {
    if (auto why = refusal(channel.name, ends, program)) return why;
  } else {
    known->second.standing = std::max(known->second.standing, program.standing);
    if (known->second.end.address == address) return std::nullopt;
    if (!may_change(known->second))
      return "its address for " + channel.name + " was changed " + std::to_string(kChangesAtOnce) +
             " times in a few seconds, and may be once a second";
  }
  ends.channel = channel.name;
  Place& place = ends.by_session[program.session];
  place.end = {program.user, address};
  place.standing = std::max(place.standing, program.standing);
  report(channel.subject, channel.name);
  return std::nullopt;
}

/// Each change makes all programs of the channel announce it again.
bool LocalEnds::may_change(Place& place) const {
  const std::uint64_t now = clock_.monotonic_ns();
  const std::uint64_t until = std::max(place.changes_until, now) + kChange;
  if (until > now + kChangesAtOnce * kChange) return false;
  place.changes_until = until;
  return true;
}

std::optional<std::string> LocalEnds::refusal(const std::string& channel, const Ends& ends,
                                              const Program& program) {
  const auto places = ends.by_session | std::views::values;
  const std::string of_channel = " places of " + channel + " for subscribers on this gateway";
  // Programs of a user without a group or unit take no place from those that state one.
  const auto of_user = std::ranges::count_if(places, [&](const Place& one) {
    return one.end.user == program.user && one.standing == program.standing;
  });
  if (program.user != 0 && static_cast<std::size_t>(of_user) >= kMostOfUser)
    return "user " + std::to_string(program.user) + " has " + std::to_string(of_user) + " of the " +
           std::to_string(kMostOfChannel) + of_channel + ", which is the most of one user";
  // Those of a higher standing do not count, so that they take no place from the others.
  const Standing standing = program.standing;
  const auto taken = static_cast<std::size_t>(std::ranges::count_if(
      places, [standing](const Place& one) { return one.standing <= standing; }));
  if (taken < most_up_to(standing) && ends.by_session.size() < kMostOfChannel) return std::nullopt;
  if (standing == Standing::trusted || ends.by_session.size() >= kMostOfChannel)
    return "the " + std::to_string(kMostOfChannel) + of_channel + " are taken";
  return "the " + std::to_string(most_up_to(standing)) + of_channel + " are taken that " +
         (standing == Standing::anyone ? "every program can have"
                                       : "programs of other users than root and members can have");
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
  for (const Place& place : known->second.by_session | std::views::values)
    if (std::ranges::find(out, place.end) == out.end()) out.push_back(place.end);
  return out;
}

/// Reports the change at once, unless one was reported shortly before.
void LocalEnds::report(core::Subject subject, const std::string& channel) {
  const auto [at, fresh] = reports_.try_emplace(subject);
  if (!fresh) {
    at->second = {channel, true};
    return;
  }
  due_.emplace_back(clock_.monotonic_ns() + kReport, subject);
  report_now(subject, channel);
}

void LocalEnds::report_waiting() {
  const std::uint64_t now = clock_.monotonic_ns();
  while (!due_.empty() && due_.front().first <= now) {
    const core::Subject subject = due_.front().second;
    due_.pop_front();
    auto node = reports_.extract(subject);
    if (!node.empty() && node.mapped().waits) report(subject, node.mapped().channel);
  }
}

std::optional<std::uint64_t> LocalEnds::due() const {
  return due_.empty() ? std::nullopt : std::optional(due_.front().first);
}

void LocalEnds::report_now(core::Subject subject, const std::string& channel) {
  control::Event event;
  event.kind = "local";
  event.subject = subject;
  event.channel = channel;
  event.message = "the subscribers of " + channel + " on this gateway are others";
  log_.notify_clients(std::move(event));
}

}  // namespace mlcca
