// SPDX-License-Identifier: BSD-2-Clause
#include "cluster/daemon_server.hpp"

#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "base/system_error.hpp"

namespace mlcca::cluster {
namespace {

constexpr int kTurn = 64;  // most messages that are received or sent in one turn of the loop
constexpr std::uint64_t kAcceptAgain = 1'000'000;  // µs

/// The users that own the file of the socket, root, and the user of this process.
std::set<uid_t> owners_of(int socket) {
  std::set<uid_t> owners{0, ::geteuid()};
  sockaddr_un address{};
  socklen_t size = sizeof address;
  struct stat file{};
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  if (::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size) == 0 &&
      address.sun_path[0] == '/' && ::lstat(&address.sun_path[0], &file) == 0)
    owners.insert(file.st_uid);
  return owners;
}

}  // namespace

DaemonServer::DaemonServer(sd_event* loop, Fd listening, Bridge& bridge, Log log)
    : loop_(loop),
      listening_(std::move(listening)),
      bridge_(bridge),
      log_(std::move(log)),
      trusted_(owners_of(listening_.get())) {
  bridge_.on_output([this] { send(); });
}

Result<void> DaemonServer::start() {
  sd_event_source* raw = nullptr;
  if (const int e = sd_event_add_io(loop_, &raw, listening_.get(), EPOLLIN, on_connection, this);
      e < 0)
    return system_error("watching the socket", -e);
  connections_.reset(raw);
  // Arms the timer now, because its descriptor could not be created when there are none left.
  return accept_again_.start(
      loop_, [this] { sd_event_source_set_enabled(connections_.get(), SD_EVENT_ON); });
}

int DaemonServer::on_connection(sd_event_source*, int, std::uint32_t, void* self) noexcept {
  static_cast<DaemonServer*>(self)->accept();
  return 0;
}

void DaemonServer::accept() {
  Fd socket(::accept4(listening_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (!socket) {
    if (errno != EAGAIN && errno != EINTR && errno != ECONNABORTED) rest(errno);
    return;
  }
  rests_ = false;
  ucred peer{};
  socklen_t size = sizeof peer;
  if (::getsockopt(socket.get(), SOL_SOCKET, SO_PEERCRED, &peer, &size) < 0 ||
      !trusted_.contains(peer.uid)) {
    log_("a connection of uid " + std::to_string(peer.uid) + " is refused");
    return;
  }
  if (io_) end("another connection takes its place");
  sd_event_source* raw = nullptr;
  if (sd_event_add_io(loop_, &raw, socket.get(), EPOLLIN, on_io, this) < 0) return;
  io_.reset(raw);
  socket_ = std::move(socket);
  reader_ = {};
  full_ = false;
}

/// Stops accepting for a while: otherwise the socket would stay readable, and the loop would spin.
void DaemonServer::rest(int error) {
  if (!std::exchange(rests_, true))
    log_("no connection can be taken: " + system_error("accept", error).error().text);
  sd_event_source_set_enabled(connections_.get(), SD_EVENT_OFF);
  accept_again_.set(kAcceptAgain);
}

int DaemonServer::on_io(sd_event_source*, int, std::uint32_t events, void* self) noexcept {
  auto& server = *static_cast<DaemonServer*>(self);
  if ((events & EPOLLOUT) != 0) {
    server.full_ = false;
    server.send();
  }
  // While the bridge is busy and nothing is read, the end of the connection is reported all the
  // same.
  if ((events & (EPOLLHUP | EPOLLERR)) != 0 && server.bridge_.is_busy())
    server.end({});
  else if ((events & ~EPOLLOUT) != 0)
    server.receive();
  return 0;
}

void DaemonServer::receive() {
  for (int i = 0; i < kTurn && io_; ++i) {
    if (bridge_.is_busy()) {
      listen_for(full_);
      return;
    }
    const auto size = ::recv(socket_.get(), buffer_.data(), buffer_.size(), MSG_TRUNC);
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (size <= 0) {
      end({});
      return;
    }
    if (!take(static_cast<std::size_t>(size))) return;
  }
}

bool DaemonServer::take(std::size_t size) {
  auto read = size > buffer_.size() ? fail("it sent a message that is too long")
                                    : reader_.take({buffer_.data(), size});
  if (!read) {
    end("mlccad is not understood: " + read.error().text);
    return false;
  }
  if (*read) bridge_.take(std::move(**read));
  return true;
}

/// An error of the socket is reported to the loop as well, which ends the connection.
void DaemonServer::send() {
  if (!io_ || full_) return;
  for (const wire::Message* next = bridge_.outbox().next(); next != nullptr;
       next = bridge_.outbox().next()) {
    if (::send(socket_.get(), next->data(), next->size(), MSG_DONTWAIT | MSG_NOSIGNAL) < 0) {
      full_ = true;
      break;
    }
    bridge_.outbox().take();
  }
  listen_for(full_);
  bridge_.sent();
}

void DaemonServer::listen_for(bool output) {
  std::uint32_t events = bridge_.is_busy() ? 0U : std::uint32_t{EPOLLIN};
  if (output) events |= EPOLLOUT;
  sd_event_source_set_io_events(io_.get(), events);
}

void DaemonServer::end(const std::string& why) {
  if (!why.empty()) log_(why);
  io_.reset();
  socket_.reset();
  bridge_.end_session();
  sd_event_source_set_enabled(connections_.get(), SD_EVENT_ON);
}

}  // namespace mlcca::cluster
