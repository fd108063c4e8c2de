// SPDX-License-Identifier: BSD-2-Clause
// Keeps can-gw in line with what was granted. The gates do not depend on it: without a rule a frame
// stays where it is.
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

class Forwarder {
 public:
  using Report = std::function<void(const std::string& line, bool problem)>;

  Forwarder(std::unique_ptr<net::CanRules> kernel, Report report)
      : kernel_(std::move(kernel)), report_(std::move(report)) {}

  /// What the channel needs from now on, in the place of what it needed; act() brings it about.
  void want(std::size_t channel, std::vector<net::CanRule> rules);
  /// No channel needs a rule any more, and what the kernel has is read again.
  void forget();

  /// Once a turn: the changes, if any.
  void act();
  /// Once a second: what another program removed or added, and what failed before.
  void poll();
  /// No rule of ours is left.
  void stop();

  /// What is wrong now; empty: nothing.
  [[nodiscard]] const std::string& problem() const { return problem_; }
  /// Wanted rules that rules of another program are in the way of.
  [[nodiscard]] const std::vector<net::CanRule>& in_way() const { return in_way_; }
  /// One of those that need it.
  [[nodiscard]] std::optional<std::size_t> channel_of(const net::CanRule& rule) const;
  /// Rules that are wanted, and those that the kernel was last seen to have.
  [[nodiscard]] std::size_t rules() const { return wanted_.size() + (there_ ? there_->size() : 0); }
  /// What the kernel has now, ours and those of others.
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
  std::map<net::CanRule, std::set<std::size_t>> channels_;  ///< that need it
  Wanted wanted_;
  std::optional<std::vector<net::CanRuleThere>> there_;  ///< none: to be read
  std::vector<net::CanRule> in_way_;
  std::string problem_;
  bool changed_ = true;
  bool had_any_ = true;  ///< of ours, when last seen, or wanted: a former daemon may have left some
};

}  // namespace mlcca
