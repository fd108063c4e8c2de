// SPDX-License-Identifier: BSD-2-Clause
// The progress of listening on an interface, and the reason if no frame arrived.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "control/messages.hpp"

namespace mlcca::tools::design {

/// The status of the daemon; nullopt if none answers or the caller has no permission.
[[nodiscard]] std::optional<control::Status> status_of_daemon(const std::string& socket);

/// The reason why no frame arrived. `is_up` is the state of the interface; `status` is that of a
/// daemon that may gate it.
[[nodiscard]] std::string reason_of_silence(const std::string& interface, bool is_up,
                                            const std::optional<control::Status>& status);

/// Shows a line with the progress on standard error, updated once a second, if that is a terminal.
class Listening {
 public:
  explicit Listening(std::uint64_t ns);
  ~Listening();
  Listening(const Listening&) = delete;
  Listening& operator=(const Listening&) = delete;
  Listening(Listening&&) = delete;
  Listening& operator=(Listening&&) = delete;

  void count() { ++frames_; }
  /// Updates the line if it is due; to be called often.
  void show();

  [[nodiscard]] static std::string line(std::uint64_t frames, std::uint64_t left_ns);

 private:
  bool shows_;
  std::uint64_t end_;
  std::uint64_t next_ = 0;
  std::uint64_t frames_ = 0;
};

}  // namespace mlcca::tools::design
