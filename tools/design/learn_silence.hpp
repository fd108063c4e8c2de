// SPDX-License-Identifier: BSD-2-Clause
// The progress of listening on an interface, and the reason if no frame arrived.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "control/messages.hpp"

namespace mlcca::tools::design {

/// The status of the daemon; nullopt if none answers or the caller has no permission.
[[nodiscard]] std::optional<control::Status> status_of_daemon(const std::string& socket);

/// Counts the frames that CAN interfaces receive while they are listened to. (Of Ethernet only
/// datagrams are listened to.)
class Received {
 public:
  void begin(const std::vector<std::string>& interfaces);
  /// Since begin(); 0 if it is not known.
  [[nodiscard]] std::uint64_t unseen_on(const std::string& interface) const;

 private:
  std::map<std::string, std::uint64_t> before_;
};

/// The reason why no frame arrived. `is_up` is the state of the interface, `received` the number of
/// frames that the driver received meanwhile and that no socket saw, and `status` the status of a
/// daemon that may gate the interface.
[[nodiscard]] std::string reason_of_silence(const std::string& interface, bool is_up,
                                            std::uint64_t received,
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
