// SPDX-License-Identifier: BSD-2-Clause
// Computes the frames that can-gw rules forward to other buses. A socket on the other bus does not
// receive them unless the rule has the option `-e` of cangw, so learn computes them from the rules.
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

/// The can-gw rules between the observed interfaces.
class KernelCopies {
 public:
  /// Returns the name of the interface with that kernel index; empty: there is none.
  using NameOf = std::function<std::string(int index)>;

  KernelCopies() = default;
  /// `rules` are those of the kernel. `listened` are the names of the observed interfaces, whose
  /// numbers are in `numbers`.
  KernelCopies(std::span<const net::CanRuleThere> rules, const std::vector<std::string>& listened,
               Interfaces& numbers, const NameOf& name_of);

  /// Calls `on_copy` for each copy of `frame` that the kernel makes invisibly, with the time of the
  /// frame. `origin` is the interface on which the frame was seen before, if any: the kernel
  /// forwards a frame only once.
  void copies_of(const Frame& frame, std::optional<std::uint32_t> origin,
                 const OnFrame& on_copy) const;
  /// Rules whose copies cannot be computed, each with what to do about it.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

 private:
  /// A rule of can-gw.
  struct Rule {
    std::uint32_t from = 0;  ///< number of the interface
    std::uint32_t to = 0;    ///< number of the interface
    std::uint32_t id = 0;    ///< as in struct can_filter
    std::uint32_t mask = 0;
    bool fd = false;    ///< for CAN FD frames; otherwise for classic ones
    bool seen = false;  ///< sockets see its copies

    [[nodiscard]] bool carries(const Frame& frame) const;
  };
  std::vector<Rule> rules_;
  std::vector<std::string> notes_;
};

}  // namespace mlcca::learn
