// SPDX-License-Identifier: BSD-2-Clause
// The control socket: accepts clients, knows who they are, keeps their requests in order.
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

/// Who is at the other end, as the kernel says.
struct Peer {
  pid_t pid = 0;
  uid_t uid = 0;
  bool may_change = false;                      ///< root, or in the control group
  std::uint64_t session = 0;                    ///< number of the connection, never used twice
  std::shared_ptr<const Process> process = {};  ///< nullptr: not known
};

/// A part of a reply, see Reply.more in control.proto.
struct Slice {
  decltype(control::Reply::body) body;
  bool more = false;
  /// In place of `body`: what control::encode_body() gives, which is sent as it is. It must be all
  /// of the reply where the reply may not come in slices.
  std::string encoded{};
  std::uint64_t owned = 0;  ///< an admission whose events go to this connection from now on
};

/// Makes the next slice, in no more time than kSlice or one row takes. Nothing: it cannot be made
/// yet, and Server::resume() follows when it can.
using NextSlice = std::function<std::optional<Slice>()>;

/// What is answered, and what follows from it for the connection.
struct Answer {
  control::Reply reply;
  /// Not sent before release(): what it says is not on disk yet. If that fails, an error is sent in
  /// its place.
  bool held = false;
  std::uint64_t owned = 0;  ///< an admission whose events go to this connection from now on
  std::optional<std::uint64_t> follows{};  ///< a subject of which the same holds
  /// Where the reply comes in slices: makes them, and `reply` gives no more than the id.
  NextSlice slices{};
  std::size_t least_bytes = 0;  ///< that all slices have together, as far as that is known
};

class Session;

class Server {
 public:
  using AnswerTo = std::function<Answer(const control::Request&, const Peer&)>;
  using Closed = std::function<void(std::uint64_t session)>;

  /// A connection without a complete request for so long is closed, ns.
  static constexpr std::uint64_t kMostIdle = 60'000'000'000;

  /// Connections that wait to be accepted: as many as are accepted in one or two turns. Who comes
  /// when there are more waits for one of them, and not behind thousands. As in mlccad.socket.
  static constexpr int kBacklog = 256;

  /// Clients get so much time before the loop does something else, ns.
  static constexpr std::uint64_t kTurn = 5'000'000;
  /// One user gets so much of it before the next one has his turn, ns.
  static constexpr std::uint64_t kShare = 1'000'000;
  /// So much before that is for those who connect, ns.
  static constexpr std::uint64_t kArrivals = 2'000'000;
  /// What a slice of a reply may take, ns, and may have in bytes.
  static constexpr std::uint64_t kSlice = 500'000;
  static constexpr std::size_t kSliceBytes = std::size_t{64} << 10;

  /// Requests and slices of one user.
  static constexpr Rate kMembersRate{20'000, 20'000};
  static constexpr Rate kOthersRate{2'000, 1'000};
  /// Connections that one user begins.
  static constexpr Rate kMembersArrivals{5'000, 2'500};
  static constexpr Rate kOthersArrivals{500, 250};

  /// `group`: whose members may change; -1: root only.
  static Result<std::unique_ptr<Server>> open(sd_event* loop, Fd listening, gid_t group,
                                              AnswerTo answer);
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  Server(Server&&) = delete;
  Server& operator=(Server&&) = delete;
  ~Server();

  /// To every client that monitors, to those that own an admission of the event, and to those that
  /// follow its subject. One that does not read loses events and gets their number.
  void publish(const control::Event& event);

  /// Sends what was held, or the error in its place.
  void release(const Result<void>& done);
  /// A reply to this session that had to wait goes on.
  void resume(std::uint64_t session);
  /// The client has hung up, whether the loop has noticed it or not.
  [[nodiscard]] bool is_gone(std::uint64_t session) const;
  /// Closes connections that have been of no use for long, and forgets users who have none and have
  /// asked for nothing lately. The server does it by itself every few seconds.
  void sweep(std::uint64_t now);
  /// Called for every connection that ends.
  void on_close(Closed closed) { closed_ = std::move(closed); }

  [[nodiscard]] std::size_t sessions() const { return sessions_.size(); }
  /// Users of whom it is remembered how much they have asked for lately.
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
  /// There is something to do for a session: at once where no other session waits, or in its turn.
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
  AnswerTo answer_;
  Closed closed_;
  std::uint64_t last_session_ = 0;
  Source source_;
  Arrivals arrivals_{kMembersArrivals, kOthersArrivals};
  Turns turns_{kMembersRate, kOthersRate};
  std::uint64_t accepted_ = 0;  ///< when accepting was tried last
  bool taking_turns_ = false;
  Fd always_;    ///< can always be read: in line with the sockets when there is work left over
  Source work_;  ///< of always_
  Source timer_;
  Source sweep_;
  std::unordered_map<int, std::unique_ptr<Session>> sessions_;
};

}  // namespace mlcca::serve
