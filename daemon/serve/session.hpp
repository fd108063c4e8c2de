// SPDX-License-Identifier: BSD-2-Clause
// One client of the control socket: bytes in, requests answered in order, bytes out.
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "control/buffer.hpp"
#include "control/messages.hpp"
#include "core/handle.hpp"
#include "daemon/serve/server.hpp"

namespace mlcca::serve {

class Session {
 public:
  /// Bytes that may wait for a client that does not read; no request of its is read meanwhile.
  static constexpr std::size_t kBusy = std::size_t{1} << 20;

  /// Answers that wait for the disk; no request is read meanwhile.
  static constexpr std::size_t kMostHeld = 256;

  /// Requests that are answered before others get their turn.
  static constexpr int kTurn = 16;

  static std::unique_ptr<Session> open(Server& server, Fd socket, Peer peer);

  [[nodiscard]] const Peer& peer() const { return peer_; }
  [[nodiscard]] bool wants(const control::Event& event) const;
  void send_event(const std::string& encoded);
  /// Sends what was held, or an error for each answer that must not be given.
  void release(const Result<void>& done);
  /// Sends an error under id 0 and closes once it is out.
  void refuse(std::string text);

 private:
  Session(Server& server, Fd socket, Peer peer);
  static int on_io(sd_event_source*, int fd, std::uint32_t events, void* userdata) noexcept;

  /// False when the session is over.
  bool receive();
  bool answer_pending();
  bool flush();
  void watch();
  void take(Answer answer);

  using Source = std::unique_ptr<sd_event_source, FreeWith<sd_event_source_unref>>;
  Server& server_;
  Fd socket_;
  Peer peer_;
  Source source_;
  control::Buffer in_;
  std::string out_;
  std::size_t sent_ = 0;
  /// Answers from the first held one on: they are sent in the order of the requests.
  std::vector<Answer> held_;
  std::vector<std::uint64_t> owned_;  // admissions
  bool monitoring_ = false;
  bool closing_ = false;
  bool more_ = false;  ///< the turn ended before the requests did
  std::uint64_t lost_events_ = 0;
};

}  // namespace mlcca::serve
