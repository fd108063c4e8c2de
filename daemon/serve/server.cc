// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/serve/server.hpp"

#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "control/codec.hpp"
#include "daemon/serve/session.hpp"

namespace mlcca::serve {
namespace {

std::unexpected<Error> system_error(const std::string& call) {
  return fail(call + ": " + std::strerror(errno));  // NOLINT(concurrency-mt-unsafe)
}

bool in_group(int fd, gid_t primary, gid_t group) {
  if (primary == group) return true;
  std::vector<gid_t> groups(64);
  auto size = static_cast<socklen_t>(groups.size() * sizeof(gid_t));
  if (::getsockopt(fd, SOL_SOCKET, SO_PEERGROUPS, groups.data(), &size) < 0) {
    if (errno != ERANGE) return false;
    groups.resize(size / sizeof(gid_t));
    if (::getsockopt(fd, SOL_SOCKET, SO_PEERGROUPS, groups.data(), &size) < 0) return false;
  }
  groups.resize(size / sizeof(gid_t));
  return std::ranges::find(groups, group) != groups.end();
}

}  // namespace

Server::Server(sd_event* loop, Fd listening, gid_t group, AnswerTo answer)
    : loop_(loop), listening_(std::move(listening)), group_(group), answer_(std::move(answer)) {}
Server::~Server() = default;

Result<std::unique_ptr<Server>> Server::open(sd_event* loop, Fd listening, gid_t group,
                                             AnswerTo answer) {
  std::unique_ptr<Server> server(new Server(loop, std::move(listening), group, std::move(answer)));
  sd_event_source* raw = nullptr;
  const auto on_connection = [](sd_event_source*, int, std::uint32_t, void* self) noexcept {
    static_cast<Server*>(self)->accept_one();
    return 0;
  };
  if (const int e = sd_event_add_io(loop, &raw, server->listening_.get(), EPOLLIN, on_connection,
                                    server.get());
      e < 0)
    return fail(std::string("control socket: ") +
                std::strerror(-e));  // NOLINT(concurrency-mt-unsafe)
  server->source_.reset(raw);
  return server;
}

Result<Peer> Server::identify(int fd) const {
  ucred who{};
  socklen_t size = sizeof who;
  if (::getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &who, &size) < 0)
    return system_error("SO_PEERCRED");
  Peer peer{who.pid, who.uid, who.uid == 0, 0};
  if (!peer.may_change && group_ != static_cast<gid_t>(-1))
    peer.may_change = in_group(fd, who.gid, group_);
  return peer;
}

std::size_t Server::sessions_of(uid_t uid) const {
  return static_cast<std::size_t>(std::ranges::count_if(
      sessions_, [uid](const auto& s) { return s.second->peer().uid == uid; }));
}

void Server::accept_one() {
  Fd socket(::accept4(listening_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (!socket) return;  // gone again, or out of descriptors: the client sees it
  auto peer = identify(socket.get());
  if (!peer) return;
  peer->session = ++last_session_;
  const bool full = peer->may_change ? sessions_.size() >= kMaxSessions
                                     : sessions_.size() >= kMaxSessions - kReservedSessions ||
                                           sessions_of(peer->uid) >= kMaxSessionsPerUser;
  if (full) {
    const std::string text = control::encode(control::Reply{
        0, control::Error{control::ErrorKind::world, "too many clients are connected", {}}});
    // NOLINTNEXTLINE(bugprone-unused-return-value): it is told on the way out, if it can be
    (void)::send(socket.get(), text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    return;
  }
  const int fd = socket.get();
  if (auto session = Session::open(*this, std::move(socket), *peer))
    sessions_.emplace(fd, std::move(session));
}

void Server::drop(int fd) {
  const auto it = sessions_.find(fd);
  if (it == sessions_.end()) return;
  const std::uint64_t session = it->second->peer().session;
  sessions_.erase(it);
  if (closed_) closed_(session);
}

void Server::publish(const control::Event& event) {
  if (sessions_.empty()) return;
  const std::string encoded = control::encode(control::Reply{0, event});
  for (auto& [fd, session] : sessions_)
    if (session->wants(event)) session->send_event(encoded);
}

void Server::release(const Result<void>& done) {
  for (auto& [fd, session] : sessions_) session->release(done);
}

}  // namespace mlcca::serve
