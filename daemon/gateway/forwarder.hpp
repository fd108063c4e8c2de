// SPDX-License-Identifier: BSD-2-Clause
// Keeps the rules of can-gw as they were granted. The gates do not depend on it: without a rule a
// frame does not leave its bus.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "daemon/gateway/forwarding.hpp"
#include "daemon/net/can_routes.hpp"

namespace mlcca {

/// Compares the rules that channels need with those that the kernel has, and makes the changes.
class Forwarder {
 public:
  using Report = std::function<void(const std::string& line, bool problem)>;

  Forwarder(std::unique_ptr<net::CanRules> kernel, Report report)
      : kernel_(std::move(kernel)), report_(std::move(report)) {}

  /// Replaces the rules that a channel needs. act() makes the change.
  void want(std::size_t channel, std::vector<net::CanRule> rules);
  /// Forgets the needs of all channels; the rules of the kernel are read again.
  void forget();

  /// To be called once a turn: makes the changes, if any.
  void act();
  /// To be called once a second: corrects what another program has changed, and retries what
  /// failed.
  void poll();
  /// Removes all our rules from the kernel.
  void stop();

  /// The current problem; empty if there is none.
  [[nodiscard]] const std::string& problem() const { return problem_; }
  /// Wanted rules that conflict with rules of another program.
  [[nodiscard]] const std::vector<net::CanRule>& in_way() const { return in_way_; }
  /// One of the channels that need this rule; nullopt if none does.
  [[nodiscard]] std::optional<std::size_t> channel_of(const net::CanRule& rule) const;
  /// The number of wanted rules plus the number of rules that the kernel was last seen to have.
  [[nodiscard]] std::size_t rules() const { return wanted_.size() + (there_ ? there_->size() : 0); }
  /// The rules that the kernel has now, ours and those of other programs.
  [[nodiscard]] Result<std::vector<net::CanRuleThere>> read() { return kernel_->read(); }

 private:
  void release(const net::CanRule& rule, std::size_t channel);
  void align();
  bool read_again();
  void apply(const RuleChanges& changes);
  void settle_problem(std::string now);

  std::unique_ptr<net::CanRules> kernel_;
  Report report_;
  std::map<std::size_t, std::vector<net::CanRule>> needs_;  ///< by channel
  std::map<net::CanRule, std::set<std::size_t>> channels_;  ///< the channels that need a rule
  Wanted wanted_;
  std::optional<std::vector<net::CanRuleThere>> there_;  ///< nullopt: to be read
  std::vector<net::CanRule> in_way_;
  std::string problem_;
  bool changed_ = true;
  bool had_any_ = true;  ///< rules of ours were last seen or wanted; true at the start
};

}  // namespace mlcca
