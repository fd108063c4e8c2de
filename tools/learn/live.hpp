// SPDX-License-Identifier: BSD-2-Clause
// Listening to interfaces. CAN needs no privileges: every user may read a CAN bus. Ethernet needs
// CAP_NET_RAW.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "tools/learn/frame.hpp"
#include "tools/learn/recording.hpp"

namespace mlcca::learn {

/// What the kernel says of an interface of CAN; 0: nothing.
struct Rates {
  std::uint32_t bitrate = 0;  ///< bit/s; a virtual one has none
  std::uint32_t data_bitrate = 0;
  std::uint32_t queue_length = 0;  ///< frames
};
[[nodiscard]] Rates rates_of(const std::string& interface);

/// There is an interface of that name.
[[nodiscard]] bool is_interface(const std::string& name);
/// It is there, and up.
[[nodiscard]] bool is_up(const std::string& interface);

class Listener {
 public:
  /// Error: there is no such interface, it is of another kind, or the process may not listen to it.
  static Result<std::unique_ptr<Listener>> open(const std::vector<std::string>& interfaces,
                                                Interfaces& numbers);
  Listener() = default;
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  Listener(Listener&&) = delete;
  Listener& operator=(Listener&&) = delete;
  virtual ~Listener() = default;

  /// Hands over what comes, in the order of time, until `ns` are over or `stop` says so, which is
  /// asked ten times a second.
  virtual Result<void> listen(std::uint64_t ns, const std::function<bool()>& stop,
                              const OnFrame& on_frame) = 0;
  /// Frames that came too fast to be read.
  [[nodiscard]] virtual std::uint64_t lost() const = 0;
};

}  // namespace mlcca::learn
