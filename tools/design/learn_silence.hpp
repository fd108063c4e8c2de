// SPDX-License-Identifier: BSD-2-Clause
// Why nothing was seen on an interface that was listened to, and how far listening is.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "control/messages.hpp"

namespace mlcca::tools::design {

/// What mlccad says of itself; nothing: there is none that answers, or the caller may not ask.
[[nodiscard]] std::optional<control::Status> status_of_daemon(const std::string& socket);

/// In words. `is_up`: as the kernel says it. `status`: of a daemon that may gate the interface.
[[nodiscard]] std::string reason_of_silence(const std::string& interface, bool is_up,
                                            const std::optional<control::Status>& status);

/// A line on standard error that is written over once a second, if that is a terminal.
class Listening {
 public:
  explicit Listening(std::uint64_t ns);
  ~Listening();
  Listening(const Listening&) = delete;
  Listening& operator=(const Listening&) = delete;
  Listening(Listening&&) = delete;
  Listening& operator=(Listening&&) = delete;

  void count() { ++frames_; }
  /// To be called often.
  void show();

  [[nodiscard]] static std::string line(std::uint64_t frames, std::uint64_t left_ns);

 private:
  bool shows_;
  std::uint64_t end_;
  std::uint64_t next_ = 0;
  std::uint64_t frames_ = 0;
};

}  // namespace mlcca::tools::design
