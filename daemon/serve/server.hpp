// SPDX-License-Identifier: BSD-2-Clause
// The control socket: accepts clients, knows who they are, keeps their requests in order.
#pragma once
#include <sys/types.h>
#include <systemd/sd-event.h>

#include <functional>
#include <memory>
#include <string>
#include <unordered_map>

#include "control/messages.hpp"
#include "core/handle.hpp"
#include "core/result.hpp"

namespace mlcca::serve {

/// Who is at the other end, as the kernel says.
struct Peer {
  pid_t pid = 0;
  uid_t uid = 0;
  bool may_change = false;  ///< root, or in the control group
};

/// Listens at `path` (mode 0666: everybody may ask); a stale socket is replaced.
[[nodiscard]] Result<Fd> listen_at(const std::string& path);

class Session;

class Server {
 public:
  using Answer = std::function<control::Reply(const control::Request&, const Peer&)>;

  /// Clients at once; a further one is told so and closed.
  static constexpr std::size_t kMaxSessions = 256;
  /// Of these, kept free for those who may change something.
  static constexpr std::size_t kReservedSessions = 32;
  /// For one user without the right to change anything.
  static constexpr std::size_t kMaxSessionsPerUser = 32;

  /// `group`: whose members may change; -1: root only.
  static Result<std::unique_ptr<Server>> open(sd_event* loop, Fd listening, gid_t group,
                                              Answer answer);
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  Server(Server&&) = delete;
  Server& operator=(Server&&) = delete;
  ~Server();

  /// To every client that monitors. One that does not read loses events and is told how many.
  void publish(const control::Event& event);

  [[nodiscard]] std::size_t sessions() const { return sessions_.size(); }

 private:
  friend class Session;
  Server(sd_event* loop, Fd listening, gid_t group, Answer answer);
  void accept_one();
  void drop(int fd);
  [[nodiscard]] Result<Peer> identify(int fd) const;
  [[nodiscard]] std::size_t sessions_of(uid_t uid) const;

  using Source = std::unique_ptr<sd_event_source, FreeWith<sd_event_source_unref>>;
  sd_event* loop_;
  Fd listening_;
  gid_t group_;
  Answer answer_;
  Source source_;
  std::unordered_map<int, std::unique_ptr<Session>> sessions_;
};

}  // namespace mlcca::serve
