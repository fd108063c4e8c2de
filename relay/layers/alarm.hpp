// SPDX-License-Identifier: BSD-2-Clause
// One descriptor for a socket and a time: it can be read when the socket can, or when the time has
// come. So a layer sends later what it may not send now, and nobody else needs to know.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca::relay {

class Alarm {
 public:
  /// Error: no descriptors are left.
  [[nodiscard]] static Result<std::unique_ptr<Alarm>> beside(int socket);

  [[nodiscard]] int fd() const { return epoll_.get(); }
  /// CLOCK_MONOTONIC, ns; nothing: never. What was set before is over.
  void set(std::optional<std::uint64_t> at);

 private:
  Alarm(Fd epoll, Fd timer) : epoll_(std::move(epoll)), timer_(std::move(timer)) {}

  Fd epoll_;
  Fd timer_;
};

}  // namespace mlcca::relay
