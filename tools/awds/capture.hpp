// SPDX-License-Identifier: BSD-2-Clause
// Receives the topology packets of AWDS from one network interface, which may disappear and come
// back.
#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca::awds {

/// A packet socket with a kernel filter for topology packets.
class Capture {
 public:
  /// Creates the socket, which needs CAP_NET_RAW; nothing later does. It receives nothing before
  /// follow().
  static Result<Capture> open(std::string interface);

  /// Readable when a packet has arrived. The socket filter passes only flood packets of type
  /// topology with a plausible length, so that data on the air does not wake this program.
  [[nodiscard]] int fd() const { return socket_.get(); }

  /// Binds to the interface of that name if there is one now. To be called repeatedly: an interface
  /// that comes back under the name has another index.
  Result<void> follow();

  /// The next packet without its Ethernet header, in `buffer`; empty if there is none.
  [[nodiscard]] std::span<const std::uint8_t> next(std::span<std::uint8_t> buffer) const;

 private:
  Capture(std::string interface, Fd socket)
      : interface_(std::move(interface)), socket_(std::move(socket)) {}

  std::string interface_;
  Fd socket_;
};

}  // namespace mlcca::awds
