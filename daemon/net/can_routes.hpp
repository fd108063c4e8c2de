// SPDX-License-Identifier: BSD-2-Clause
// The rules of can-gw (rtnetlink, family AF_CAN): how ours are written and known again, and what is
// there.
#pragma once
#include <linux/netlink.h>

#include <compare>
#include <cstdint>
#include <vector>

#include "base/result.hpp"
#include "daemon/net/rtnl.hpp"

namespace mlcca::net {

/// Frames that are carried from one CAN interface to another.
struct CanRule {
  int from = 0;          ///< ifindex
  int to = 0;            ///< ifindex
  std::uint32_t id = 0;  ///< those with (can_id & mask) == id, as struct can_filter has it
  std::uint32_t mask = 0;
  bool fd = false;           ///< CAN FD frames; else classic ones
  std::uint32_t keep = ~0U;  ///< they leave with the identifier (can_id & keep) | set
  std::uint32_t set = 0;

  auto operator<=>(const CanRule&) const = default;
  [[nodiscard]] bool translates() const { return keep != ~0U || set != 0; }
};

/// Rules of ours carry such a number and no other rule has the same. can-gw takes a number only
/// with a change of the frame: ours change the identifier, perhaps to what it was.
inline constexpr std::uint32_t kFirstUid = 0x4d4c0001;  // "ML"
inline constexpr std::uint32_t kLastUid = 0x4d4cffff;

/// A rule as the kernel has it.
struct CanRuleThere {
  CanRule rule;
  std::uint32_t uid = 0;  ///< 0: none
  std::uint16_t flags = 0;
  bool changes_more = false;  ///< of the frames than CanRule can say
  std::uint8_t hops = 0;      ///< limit of its own, 0: none
  std::uint64_t handled = 0;  ///< frames
  std::uint64_t dropped = 0;
  std::uint64_t deleted = 0;  ///< for too many hops

  [[nodiscard]] bool is_ours() const { return uid >= kFirstUid && uid <= kLastUid; }
  bool operator==(const CanRuleThere&) const = default;
};

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
