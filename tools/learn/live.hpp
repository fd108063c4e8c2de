// SPDX-License-Identifier: BSD-2-Clause
// Listens to interfaces. CAN needs no privilege, because every user may read a CAN bus; Ethernet
// needs CAP_NET_RAW.
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

/// What the kernel states about a CAN interface; 0: not stated.
struct Rates {
  std::uint32_t bitrate = 0;  ///< bit/s; a virtual interface has none
  std::uint32_t data_bitrate = 0;
  std::uint32_t queue_length = 0;  ///< frames
};
[[nodiscard]] Rates rates_of(const std::string& interface);

/// The number of frames that the driver has received on an interface; 0 if it is not known.
[[nodiscard]] std::uint64_t received_on(const std::string& interface);

/// Whether there is an interface of that name.
[[nodiscard]] bool is_interface(const std::string& name);
/// The medium of an interface. An error if it does not exist or is of a kind that is not learned.
Result<Medium> medium_of(const std::string& interface);
/// Whether the interface exists and is up.
[[nodiscard]] bool is_up(const std::string& interface);

/// An open set of sockets on interfaces.
class Listener {
 public:
  /// Opens the sockets. An error if an interface does not exist or is of another kind, or if the
  /// process may not listen to it.
  static Result<std::unique_ptr<Listener>> open(const std::vector<std::string>& interfaces,
                                                Interfaces& numbers);
  Listener() = default;
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  Listener(Listener&&) = delete;
  Listener& operator=(Listener&&) = delete;
  virtual ~Listener() = default;

  /// Passes frames to `on_frame` in order of time until `ns` have passed or `stop` returns true,
  /// which is called ten times a second.
  virtual Result<void> listen(std::uint64_t ns, const std::function<bool()>& stop,
                              const OnFrame& on_frame) = 0;
  /// The number of frames that were lost because they came too fast.
  [[nodiscard]] virtual std::uint64_t lost() const = 0;
};

}  // namespace mlcca::learn
