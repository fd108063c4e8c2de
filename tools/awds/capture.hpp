// SPDX-License-Identifier: BSD-2-Clause
// Topology packets of AWDS as they come off one interface, also one that vanishes and comes back.
#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca::awds {

class Capture {
 public:
  /// Needs CAP_NET_RAW; nothing later does. Receives nothing before follow().
  static Result<Capture> open(std::string interface);

  /// Readable when a packet is there. The kernel lets nothing else through than floods of the kind
  /// topology that can hold one (type and length): data on the air does not wake this program.
  [[nodiscard]] int fd() const { return socket_.get(); }

  /// Listens to the interface if there is one of that name now. To be called again and again:
  /// whoever comes back under the name is another interface.
  Result<void> follow();

  /// The next packet as it follows the Ethernet header, empty when there is none left.
  [[nodiscard]] std::span<const std::uint8_t> next(std::span<std::uint8_t> buffer) const;

 private:
  Capture(std::string interface, Fd socket)
      : interface_(std::move(interface)), socket_(std::move(socket)) {}

  std::string interface_;
  Fd socket_;
};

}  // namespace mlcca::awds
