// SPDX-License-Identifier: BSD-2-Clause
// The rules of can-gw (rtnetlink, family AF_CAN): how ours are written and known again, and what is
// there.
#pragma once
#include <linux/netlink.h>

#include <cstdint>
#include <vector>

#include "base/result.hpp"
#include "daemon/net/can_rule.hpp"
#include "daemon/net/rtnl.hpp"

namespace mlcca::net {

/// As we make it.
[[nodiscard]] CanRuleThere ours(const CanRule& rule, std::uint32_t uid);

// --- messages: no I/O ----------------------------------------------------------------------------

/// Both of a rule of ours: the kernel finds it by all that it was made with. To remove interface 0
/// would mean all rules there are: refused.
[[nodiscard]] Result<Message> message_to_add(const CanRuleThere& rule);
[[nodiscard]] Result<Message> message_to_remove(const CanRuleThere& rule);
/// Appends the rule of a message; anything else is passed over.
void read_rule(const nlmsghdr& message, std::vector<CanRuleThere>& to);

// --- the kernel ----------------------------------------------------------------------------------

/// What carries frames between CAN interfaces. A test has its own.
class CanRules {
 public:
  CanRules() = default;
  CanRules(const CanRules&) = delete;
  CanRules& operator=(const CanRules&) = delete;
  virtual ~CanRules() = default;

  /// All rules of this network namespace; none where the kernel has no can-gw.
  [[nodiscard]] virtual Result<std::vector<CanRuleThere>> read() = 0;
  virtual Result<void> add(const CanRuleThere& rule) = 0;
  virtual Result<void> remove(const CanRuleThere& rule) = 0;
};

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
