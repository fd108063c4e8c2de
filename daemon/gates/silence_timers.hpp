// SPDX-License-Identifier: BSD-2-Clause
// The timers that notice when a watched slot of one interface falls silent.
#pragma once
#include <cstdint>
#include <string>
#include <utility>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "bpf/ether.h"
#include "daemon/gates/pins.hpp"

namespace mlcca::enforce {

/// Maps of the gate and the gateway that timers read and write; they stay the caller's.
struct WatchedMaps {
  int table = -1;
  int control = -1;
  int events = -1;
  // Of an Ethernet gate, which has these apart:
  int slots = -1;
  int watches = -1;
};

class SilenceTimers {
 public:
  /// `take_over`: the timers that are pinned there, which go on by the program that they have until
  /// they are armed; otherwise, and where there are none, new ones. The caller pins them.
  static Result<SilenceTimers> of_can(std::uint32_t ifindex, const WatchedMaps& maps,
                                      const std::string& pin_path, bool take_over);
  static Result<SilenceTimers> of_ethernet(std::uint32_t ifindex, const WatchedMaps& maps,
                                           const std::string& pin_path, bool take_over);

  /// The timer of a watch that says what silence is. It ends by itself when the slot does not pass
  /// any more, or silence is not supervised. What is missing already is reported once more.
  [[nodiscard]] Result<void> arm(std::uint32_t watch) const;
  /// They end with the last descriptor or pin of their map.
  [[nodiscard]] Pin pin() const { return {timers_.get(), pin_path_}; }

 private:
  template <class Skeleton>
  static Result<SilenceTimers> load(std::uint32_t ifindex, const WatchedMaps& maps,
                                    const std::string& pin_path, bool take_over);
  SilenceTimers(Fd program, Fd timers, std::string pin_path)
      : program_(std::move(program)), timers_(std::move(timers)), pin_path_(std::move(pin_path)) {}
  Fd program_;  ///< it holds the other maps
  Fd timers_;
  std::string pin_path_;
};

}  // namespace mlcca::enforce
