// SPDX-License-Identifier: BSD-2-Clause
// An epoll descriptor that combines a socket with a timer.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>

#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca::relay {

/// A descriptor that is readable when a socket is readable or a time has come. With it a layer
/// sends delayed frames without any help of its user.
class Alarm {
 public:
  /// Fails if no descriptors are left.
  [[nodiscard]] static Result<std::unique_ptr<Alarm>> beside(int socket);

  [[nodiscard]] int fd() const { return epoll_.get(); }
  /// Sets the time, CLOCK_MONOTONIC in ns, and replaces the former one; nullopt: never.
  void set(std::optional<std::uint64_t> at);

 private:
  Alarm(Fd epoll, Fd timer) : epoll_(std::move(epoll)), timer_(std::move(timer)) {}

  Fd epoll_;
  Fd timer_;
};

}  // namespace mlcca::relay
