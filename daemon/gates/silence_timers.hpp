// SPDX-License-Identifier: BSD-2-Clause
// The kernel timers that notice when a watched slot of one interface becomes silent.
#pragma once
#include <cstdint>
#include <string>
#include <utility>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "bpf/ether.h"
#include "daemon/gates/pins.hpp"

namespace mlcca::gates {

/// The maps of gate and gateway that the timers use. The descriptors stay with the caller.
struct WatchedMaps {
  int table = -1;
  int control = -1;
  int events = -1;
  // For an Ethernet gate, which has these in separate maps:
  int slots = -1;
  int watches = -1;
};

/// Loads the program of the timers of one interface, and arms them.
class SilenceTimers {
 public:
  /// `take_over`: takes the timers that are pinned, which continue with their present program until
  /// they are armed. Otherwise, or if there are none, makes new ones. The caller pins them.
  static Result<SilenceTimers> of_can(std::uint32_t ifindex, const WatchedMaps& maps,
                                      const std::string& pin_path, bool take_over);
  static Result<SilenceTimers> of_ethernet(std::uint32_t ifindex, const WatchedMaps& maps,
                                           const std::string& pin_path, bool take_over);

  /// Starts the timer of a watch that supervises silence. It ends by itself when the slot does not
  /// pass any more, or silence is no longer supervised. If events are missing already, that is
  /// reported once more.
  [[nodiscard]] Result<void> arm(std::uint32_t watch) const;
  /// The map of the timers. They end with its last descriptor or pin.
  [[nodiscard]] Pin pin() const { return {timers_.get(), pin_path_}; }

 private:
  template <class Skeleton>
  static Result<SilenceTimers> load(std::uint32_t ifindex, const WatchedMaps& maps,
                                    const std::string& pin_path, bool take_over);
  SilenceTimers(Fd program, Fd timers, std::string pin_path)
      : program_(std::move(program)), timers_(std::move(timers)), pin_path_(std::move(pin_path)) {}
  Fd program_;  ///< holds the other maps
  Fd timers_;
  std::string pin_path_;
};

}  // namespace mlcca::gates
