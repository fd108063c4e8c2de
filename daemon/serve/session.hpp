// SPDX-License-Identifier: BSD-2-Clause
// One client of the control socket: receives bytes, answers requests in order, and sends bytes.
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

/// The state of one connection. The server decides when it may step().
class Session {
 public:
  /// Bytes that may wait for a client that does not read. Above that nothing is read from it or
  /// made for it.
  static constexpr std::size_t kBusy = std::size_t{256} << 10;

  /// The most subjects that one client follows.
  static constexpr std::size_t kMostFollowed = 4096;

  /// The most answers that wait for the disk. Above that no request is read.
  static constexpr std::size_t kMostHeld = 256;

  static std::unique_ptr<Session> open(Server& server, Fd socket, Peer peer);

  [[nodiscard]] const Peer& peer() const { return peer_; }
  [[nodiscard]] int fd() const { return socket_.get(); }
  [[nodiscard]] bool wants(const control::Event& event) const;
  [[nodiscard]] bool wants_exact_kinds() const { return exact_kinds_; }
  void send_event(const std::string& encoded);
  /// Sends the answers that were held; after a failed write, an error for each that must not be
  /// given.
  void release(const Result<void>& done);
  /// Sends an error with id 0, and closes the connection when it is sent.
  void refuse(std::string text);
  /// Sends an error with id 0, as much as the socket takes at once. The session must end then.
  void say_goodbye(const std::string& text);
  [[nodiscard]] Use use() const;
  /// When a complete request came, or the client last read something; ns.
  [[nodiscard]] std::uint64_t active() const { return active_; }
  /// Whether the client waits for the daemon or for events, or owns an admission.
  [[nodiscard]] bool is_needed() const {
    return monitoring_ || announcing_ || use() == Use::owns || can_step() || parked_ ||
           !held_.empty();
  }

  // Calls of the server, which decides whose turn it is.

  /// Whether there may be work that waits neither for the client nor for the disk.
  [[nodiscard]] bool can_step() const {
    return has_work_ && !closing_ && !parked_ && waiting() < kBusy &&
           (rest_ ? held_.empty() : held_.size() < kMostHeld);
  }
  /// Answers one request, or makes one slice of a reply.
  void step();
  /// The next slice can be made now.
  void resume() { parked_ = false; }
  /// Reads what has come, if the session reads at present. False if the session has ended.
  bool receive();
  /// Sends what the socket takes. False if the session has ended.
  bool flush();
  /// Sets which events of the socket the session waits for.
  void watch();
  [[nodiscard]] bool in_line() const { return in_line_; }
  void set_in_line(bool in_line) { in_line_ = in_line; }

 private:
  Session(Server& server, Fd socket, Peer peer);
  static int on_io(sd_event_source*, int fd, std::uint32_t events, void* userdata) noexcept;
  [[nodiscard]] std::size_t waiting() const { return out_.size() - sent_; }
  /// What was received is answered before more is read.
  [[nodiscard]] bool reads() const {
    return !has_work_ && !closing_ && waiting() < kBusy && held_.size() < kMostHeld;
  }

  void step_slice();
  void pass_on(const Slice& slice);
  void take(Answer answer, bool may_slice);
  [[nodiscard]] bool follow(std::uint64_t subject);

  /// A reply that is being made in slices.
  struct Rest {
    NextSlice next;
    std::uint64_t id = 0;
    bool may_slice = false;
    std::size_t bytes = 0;  ///< the size so far, if the client gets no slices
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
  /// The answers from the first held one on. They are sent in the order of the requests.
  std::vector<Answer> held_;
  std::optional<Rest> rest_;          ///< follows what is held; no request is answered meanwhile
  std::set<std::uint64_t> owned_;     // admissions
  std::set<std::uint64_t> followed_;  // subjects
  std::uint64_t active_;
  bool monitoring_ = false;
  bool exact_kinds_ = false;
  bool announcing_ = false;  ///< the client has announced a channel, perhaps without success
  bool closing_ = false;
  bool in_line_ = false;
  bool has_work_ = false;  ///< received or begun, and not known to be done
  bool parked_ = false;    ///< waits for resume()
  std::uint64_t lost_events_ = 0;
};

}  // namespace mlcca::serve
