// SPDX-License-Identifier: BSD-2-Clause
// What rules of can-gw carry from one bus to another. A socket on the other bus does not see such
// frames unless the rule has the option `-e` of cangw, so they are made of the rules here.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/net/can_rule.hpp"
#include "tools/learn/recording.hpp"

namespace mlcca::learn {

class KernelCopies {
 public:
  /// The name of an interface by its index in the kernel; empty: there is none.
  using NameOf = std::function<std::string(int index)>;

  KernelCopies() = default;
  /// `rules`: as the kernel has them. `listened`: names of the interfaces that are listened to,
  /// whose numbers are those of `numbers`.
  KernelCopies(std::span<const net::CanRuleThere> rules, const std::vector<std::string>& listened,
               Interfaces& numbers, const NameOf& name_of);

  /// Hands over, at the time of the frame, each copy that the kernel makes of it unseen. `origin`:
  /// the interface that the frame was seen on before. The kernel carries a frame once.
  void copies_of(const Frame& frame, std::optional<std::uint32_t> origin,
                 const OnFrame& on_copy) const;
  /// Rules whose copies are not known, each with what to do about it.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

 private:
  struct Rule {
    std::uint32_t from = 0;  ///< number of the interface
    std::uint32_t to = 0;    ///< number of the interface
    std::uint32_t id = 0;    ///< as struct can_filter has it
    std::uint32_t mask = 0;
    bool fd = false;    ///< carries CAN FD frames; else classic ones
    bool seen = false;  ///< sockets see its copies

    [[nodiscard]] bool carries(const Frame& frame) const;
  };
  std::vector<Rule> rules_;
  std::vector<std::string> notes_;
};

}  // namespace mlcca::learn
