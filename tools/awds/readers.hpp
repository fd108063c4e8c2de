// SPDX-License-Identifier: BSD-2-Clause
// Distributes the packets to readers: connections to a local socket, on which each packet is one
// message.
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca::awds {

/// The listening socket and its connections.
class Readers {
 public:
  static constexpr std::size_t kMost = 16;  ///< further readers are refused

  Readers(sd_event* loop, Fd listening) : loop_(loop), listening_(std::move(listening)) {}
  Readers(const Readers&) = delete;
  Readers& operator=(const Readers&) = delete;
  Readers(Readers&&) = delete;
  Readers& operator=(Readers&&) = delete;
  ~Readers() = default;

  [[nodiscard]] Result<void> start();
  /// Sends a packet to all readers. A reader that does not keep up misses packets: AWDS repeats its
  /// topology.
  void send(std::span<const std::uint8_t> packet) const;

 private:
  using Source = std::unique_ptr<sd_event_source, FreeWith<sd_event_source_disable_unref>>;
  struct Reader {
    Fd socket;
    Source source;
  };
  static int on_connection(sd_event_source*, int, std::uint32_t, void* self) noexcept;
  static int on_hangup(sd_event_source*, int fd, std::uint32_t, void* self) noexcept;

  sd_event* loop_;
  Fd listening_;
  Source source_;
  std::map<int, Reader> readers_;  ///< by file descriptor
};

}  // namespace mlcca::awds
