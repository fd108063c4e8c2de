// SPDX-License-Identifier: BSD-2-Clause
// The control socket: accepts clients, identifies them, and answers their requests in order.
#pragma once
#include <sys/types.h>
#include <systemd/sd-event.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "control/messages.hpp"
#include "daemon/serve/arrivals.hpp"
#include "daemon/serve/process.hpp"
#include "daemon/serve/turns.hpp"

namespace mlcca::serve {

/// The process at the other end of a connection, as the kernel identifies it.
struct Peer {
  pid_t pid = 0;
  uid_t uid = 0;
  bool may_change = false;                      ///< root, or a member of the control group
  std::uint64_t session = 0;                    ///< number of the connection, never used twice
  std::shared_ptr<const Process> process = {};  ///< nullptr: unknown
  /// It has connected from another network namespace than that of the daemon. False as well if the
  /// kernel does not say that (before Linux 5.14).
  bool is_in_other_network = false;
};

/// A part of a reply; see Reply.more in control.proto.
struct Slice {
  decltype(control::Reply::body) body;
  bool more = false;
  /// Instead of `body`: the output of control::encode_body(), which is sent unchanged. If the reply
  /// may not come in slices it must be the complete reply.
  std::string encoded{};
  std::uint64_t owned = 0;  ///< an admission whose events go to this connection from now on
};

/// Makes the next slice, within kSlice or the time of one row. nullopt: it cannot be made yet, and
/// Server::resume() will follow.
using NextSlice = std::function<std::optional<Slice>()>;

/// The answer to a request, and what it means for the connection.
struct Answer {
  control::Reply reply;
  /// Not sent before release(), because what it says is not on disk yet. If writing to disk fails,
  /// an error is sent instead.
  bool held = false;
  std::uint64_t owned = 0;  ///< an admission whose events go to this connection from now on
  std::optional<std::uint64_t> follows{};  ///< a subject; its events go there from now on
  /// Makes the slices of a reply that comes in slices; then only the id of `reply` is used.
  NextSlice slices{};
  std::size_t least_bytes = 0;  ///< the least size of all slices together, as far as known
};

class Session;

/// Serves the clients of the control socket on the loop. Users take turns with a budget of time and
/// a rate of requests, so no client can delay others or the heart-beat.
class Server {
 public:
  using AnswerTo = std::function<Answer(const control::Request&, const Peer&)>;
  using Closed = std::function<void(std::uint64_t session)>;

  /// ns after which a connection without a complete request is closed.
  static constexpr std::uint64_t kMostIdle = 60'000'000'000;

  /// The most connections that wait to be accepted: as many as are accepted in one or two turns. A
  /// client that comes when the queue is full waits for one place, not behind thousands. As in
  /// mlccad.socket.
  static constexpr int kBacklog = 256;

  /// ns that clients get in one turn of the loop.
  static constexpr std::uint64_t kTurn = 5'000'000;
  /// ns of these that one user gets before the next one has a turn.
  static constexpr std::uint64_t kShare = 1'000'000;
  /// ns before that for accepting connections.
  static constexpr std::uint64_t kArrivals = 2'000'000;
  /// What a slice of a reply may take: ns, and bytes.
  static constexpr std::uint64_t kSlice = 500'000;
  static constexpr std::size_t kSliceBytes = std::size_t{64} << 10;

  /// The rate of requests and slices of one user.
  static constexpr Rate kMembersRate{20'000, 20'000};
  static constexpr Rate kOthersRate{2'000, 1'000};
  /// The rate of connections that one user makes.
  static constexpr Rate kMembersArrivals{5'000, 2'500};
  static constexpr Rate kOthersArrivals{500, 250};

  /// `group` is the control group, whose members may change things; -1: only root may.
  static Result<std::unique_ptr<Server>> open(sd_event* loop, Fd listening, gid_t group,
                                              AnswerTo answer);
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  Server(Server&&) = delete;
  Server& operator=(Server&&) = delete;
  ~Server();

  /// Sends an event to every client that monitors, to those that own an admission of the event, and
  /// to those that follow its subject. A client that does not read loses events, and gets their
  /// number.
  void publish(const control::Event& event);

  /// Sends the answers that were held, or errors instead.
  void release(const Result<void>& done);
  /// Continues a reply to this session that had to wait.
  void resume(std::uint64_t session);
  /// Whether the client has hung up, even if the loop has not noticed it yet.
  [[nodiscard]] bool is_gone(std::uint64_t session) const;
  /// Closes connections that have not been used for long, and forgets users without connections and
  /// recent requests. The server calls it itself every few seconds.
  void sweep(std::uint64_t now);
  /// Sets the function that is called for every connection that ends.
  void on_close(Closed closed) { closed_ = std::move(closed); }

  [[nodiscard]] std::size_t sessions() const { return sessions_.size(); }
  /// The number of users whose recent requests are remembered.
  [[nodiscard]] std::size_t users() const { return turns_.users(); }

 private:
  friend class Session;
  Server(sd_event* loop, Fd listening, gid_t group, AnswerTo answer);
  void accept_some();
  bool accept_one();
  static void refuse(int fd, const std::string& why);
  void drop(int fd);
  [[nodiscard]] Result<void> make_place_for(const Peer& peer);
  void dismiss(int fd, const std::string& why);
  /// A session has work: it is done at once if no other session waits, or else in its turn.
  void ready(Session& session);
  void ready_later(Session& session);
  void line_up(Session& session);
  static Turns::User user_of(const Peer& peer) { return {peer.uid, peer.may_change}; }
  void take_turns();
  void serve(Session& session, std::uint64_t now);
  Result<void> add_sources();
  void wake_when_due();
  [[nodiscard]] Result<Peer> identify(int fd) const;

  using Source = std::unique_ptr<sd_event_source, FreeWith<sd_event_source_unref>>;
  sd_event* loop_;
  Fd listening_;
  gid_t group_;
  std::optional<std::uint64_t> namespace_;  ///< network namespace of the daemon; nullopt: unknown
  AnswerTo answer_;
  Closed closed_;
  std::uint64_t last_session_ = 0;
  Source source_;
  Arrivals arrivals_{kMembersArrivals, kOthersArrivals};
  Turns turns_{kMembersRate, kOthersRate};
  std::uint64_t accepted_ = 0;  ///< when accepting was last tried
  bool taking_turns_ = false;
  Fd always_;    ///< always readable: queues behind the sockets while there is work left
  Source work_;  ///< the event source of always_
  Source timer_;
  Source sweep_;
  std::unordered_map<int, std::unique_ptr<Session>> sessions_;
};

}  // namespace mlcca::serve
