// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/forwarder.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "core/model/progress.hpp"

namespace mlcca {

void Forwarder::want(std::size_t channel, std::vector<net::CanRule> rules) {
  const auto known = needs_.find(channel);
  if (known == needs_.end() ? rules.empty() : known->second == rules) return;
  if (known != needs_.end())
    for (const net::CanRule& rule : known->second) release(rule, channel);
  for (const net::CanRule& rule : rules) {
    channels_[rule].insert(channel);
    wanted_.emplace(rule, channel);
  }
  if (rules.empty())
    needs_.erase(channel);
  else
    needs_[channel] = std::move(rules);
  changed_ = true;
}

/// Channels whose messages have the same frames share a rule.
void Forwarder::release(const net::CanRule& rule, std::size_t channel) {
  const auto users = channels_.find(rule);
  if (users == channels_.end()) return;  // several publishers of one channel may share a rule
  users->second.erase(channel);
  if (!users->second.empty()) {
    wanted_[rule] = *users->second.begin();
    return;
  }
  channels_.erase(users);
  wanted_.erase(rule);
}

void Forwarder::forget() {
  needs_.clear();
  channels_.clear();
  wanted_.clear();
  there_.reset();
  changed_ = true;
}

std::optional<std::size_t> Forwarder::channel_of(const net::CanRule& rule) const {
  const auto known = wanted_.find(rule);
  return known == wanted_.end() ? std::nullopt : std::optional(known->second);
}

void Forwarder::act() {
  if (!std::exchange(changed_, false)) return;
  align();
}

void Forwarder::poll() {
  if (wanted_.empty() && !had_any_) return;
  const auto former = std::exchange(there_, std::nullopt);
  if (!read_again()) return;
  const auto is_ours = [](const net::CanRuleThere& t) { return t.is_ours(); };
  const auto before = former ? std::ranges::count_if(*former, is_ours) : 0;
  const auto now = std::ranges::count_if(*there_, is_ours);
  if (now < before)
    report_(fmt::format("another program removed {} of our can-gw rules: they are added again",
                        before - now),
            true);
  align();
}

void Forwarder::stop() {
  forget();
  align();
}

bool Forwarder::read_again() {
  auto read = kernel_->read();
  if (!read) {
    settle_problem("granted frames are not carried from bus to bus: " + read.error().text);
    return false;
  }
  there_ = std::move(*read);
  return true;
}

void Forwarder::align() {
  if (!there_ && !read_again()) return;
  const RuleChanges changes = rule_changes_between(wanted_, *there_);
  in_way_ = changes.in_way;
  apply(changes);
  had_any_ = !there_ ||
             std::ranges::any_of(*there_, [](const net::CanRuleThere& t) { return t.is_ours(); });
}

/// Removes what is not wanted before it adds rules.
void Forwarder::apply(const RuleChanges& changes) {
  std::string failed;
  bool unsure = false;
  for (const net::CanRuleThere& rule : changes.remove) {
    core::Progress::made();
    // A rule whose interface is gone is gone as well: the next poll shows it.
    if (kernel_->remove(rule))
      std::erase(*there_, rule);
    else
      unsure = true;
  }
  for (const net::CanRuleThere& rule : changes.add) {
    core::Progress::made();
    const auto done = kernel_->add(rule);
    if (done)
      there_->push_back(rule);
    else
      unsure = true;  // the rule may exist: perhaps only the answer was lost
    if (!done && failed.empty())
      failed = "granted frames are not carried from bus to bus: " + done.error().text;
  }
  if (failed.empty() && !in_way_.empty())
    failed =
        "can-gw rules of another program carry granted frames a second time, or changed (mlccactl "
        "routes names the channels): take them away, or state forward=\"none\" of the gateway";
  if (unsure) there_.reset();
  settle_problem(std::move(failed));
}

void Forwarder::settle_problem(std::string now) {
  if (now == problem_) return;
  if (now.empty())
    report_("can-gw carries what was granted again, and nothing else", false);
  else
    report_(now, true);
  problem_ = std::move(now);
}

}  // namespace mlcca
