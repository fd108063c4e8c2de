// SPDX-License-Identifier: BSD-2-Clause
// One client of the control socket: bytes in, requests answered in order, bytes out.
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "control/buffer.hpp"
#include "control/messages.hpp"
#include "daemon/serve/places.hpp"
#include "daemon/serve/server.hpp"

namespace mlcca::serve {

class Session {
 public:
  /// Bytes that may wait for a client that does not read; nothing is read of it or made for it
  /// meanwhile.
  static constexpr std::size_t kBusy = std::size_t{256} << 10;

  /// Subjects that one client follows.
  static constexpr std::size_t kMostFollowed = 4096;

  /// Answers that wait for the disk; no request is read meanwhile.
  static constexpr std::size_t kMostHeld = 256;

  static std::unique_ptr<Session> open(Server& server, Fd socket, Peer peer);

  [[nodiscard]] const Peer& peer() const { return peer_; }
  [[nodiscard]] int fd() const { return socket_.get(); }
  [[nodiscard]] bool wants(const control::Event& event) const;
  [[nodiscard]] bool wants_exact_kinds() const { return exact_kinds_; }
  void send_event(const std::string& encoded);
  /// Sends what was held, or an error for each answer that must not be given.
  void release(const Result<void>& done);
  /// Sends an error under id 0 and closes once it is out.
  void refuse(std::string text);
  /// Sends an error under id 0 as far as the socket takes it. The session must end then.
  void say_goodbye(const std::string& text);
  [[nodiscard]] Use use() const;
  /// When a complete request came, or the client last took something, ns.
  [[nodiscard]] std::uint64_t active() const { return active_; }
  /// Its client waits for the daemon, for events, or owns an admission.
  [[nodiscard]] bool is_needed() const {
    return monitoring_ || announcing_ || use() == Use::owns || can_step() || parked_ ||
           !held_.empty();
  }

  // For the server, which says whose turn it is.

  /// There may be something to do that waits neither for the client nor for the disk.
  [[nodiscard]] bool can_step() const {
    return has_work_ && !closing_ && !parked_ && waiting() < kBusy &&
           (rest_ ? held_.empty() : held_.size() < kMostHeld);
  }
  /// One request, or one slice of a reply.
  void step();
  /// The next slice can be made now.
  void resume() { parked_ = false; }
  /// Takes what has come, where it reads. False when the session is over.
  bool receive();
  /// Sends what the socket takes. False when the session is over.
  bool flush();
  /// Waits for what can go on without a turn.
  void watch();
  [[nodiscard]] bool in_line() const { return in_line_; }
  void set_in_line(bool in_line) { in_line_ = in_line; }

 private:
  Session(Server& server, Fd socket, Peer peer);
  static int on_io(sd_event_source*, int fd, std::uint32_t events, void* userdata) noexcept;
  [[nodiscard]] std::size_t waiting() const { return out_.size() - sent_; }
  /// What is received is answered before more is received.
  [[nodiscard]] bool reads() const {
    return !has_work_ && !closing_ && waiting() < kBusy && held_.size() < kMostHeld;
  }

  void step_slice();
  void pass_on(const Slice& slice);
  void take(Answer answer, bool may_slice);
  [[nodiscard]] bool follow(std::uint64_t subject);

  /// A reply that is being made.
  struct Rest {
    NextSlice next;
    std::uint64_t id = 0;
    bool may_slice = false;
    std::size_t bytes = 0;  ///< where it may not
    std::optional<control::Reply> whole{};
    bool take(control::Reply slice);
  };

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
  std::optional<Rest> rest_;          ///< behind what is held; no request is answered meanwhile
  std::set<std::uint64_t> owned_;     // admissions
  std::set<std::uint64_t> followed_;  // subjects
  std::uint64_t active_;
  bool monitoring_ = false;
  bool exact_kinds_ = false;
  bool announcing_ = false;  ///< it has announced a channel, perhaps in vain
  bool closing_ = false;
  bool in_line_ = false;
  bool has_work_ = false;  ///< received or begun, and not done as far as one knows
  bool parked_ = false;    ///< until resume()
  std::uint64_t lost_events_ = 0;
};

}  // namespace mlcca::serve
