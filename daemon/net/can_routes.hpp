// SPDX-License-Identifier: BSD-2-Clause
// The rules of can-gw (rtnetlink, family AF_CAN): how our rules are made and recognised, and which
// rules exist.
#pragma once
#include <linux/netlink.h>

#include <cstdint>
#include <vector>

#include "base/result.hpp"
#include "daemon/net/can_rule.hpp"
#include "daemon/net/rtnl.hpp"

namespace mlcca::net {

/// A rule as we make it.
[[nodiscard]] CanRuleThere ours(const CanRule& rule, std::uint32_t uid);

// --- messages: no I/O ----------------------------------------------------------------------------

/// Both messages are for a rule of ours: the kernel finds a rule by everything that it was made
/// with. Interface index 0 is refused, because it would remove all rules.
[[nodiscard]] Result<Message> message_to_add(const CanRuleThere& rule);
[[nodiscard]] Result<Message> message_to_remove(const CanRuleThere& rule);
/// Appends the rule of a message. Messages of other kinds are skipped.
void read_rule(const nlmsghdr& message, std::vector<CanRuleThere>& to);

// --- the kernel ----------------------------------------------------------------------------------

/// The interface to can-gw, which carries frames between CAN interfaces. Tests have a fake.
class CanRules {
 public:
  CanRules() = default;
  CanRules(const CanRules&) = delete;
  CanRules& operator=(const CanRules&) = delete;
  virtual ~CanRules() = default;

  /// All rules of this network namespace; empty if the kernel has no can-gw.
  [[nodiscard]] virtual Result<std::vector<CanRuleThere>> read() = 0;
  virtual Result<void> add(const CanRuleThere& rule) = 0;
  virtual Result<void> remove(const CanRuleThere& rule) = 0;
};

/// can-gw of the kernel.
class KernelCanRules : public CanRules {
 public:
  [[nodiscard]] Result<std::vector<CanRuleThere>> read() override;
  Result<void> add(const CanRuleThere& rule) override;
  Result<void> remove(const CanRuleThere& rule) override;

 private:
  Result<void> send(const Result<Message>& message);
  Rtnl rtnl_;
};

}  // namespace mlcca::net
