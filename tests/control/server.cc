// SPDX-License-Identifier: BSD-2-Clause
// The fake daemon uses the real codec, so what it receives is what mlccad would see.
#include "tests/control/server.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <utility>

#include "control/codec.hpp"

namespace mlcca::test {

TempDir::TempDir() {
  std::string pattern = ::testing::TempDir() + "mlcca-XXXXXX";
  directory_ = ::mkdtemp(pattern.data());
}

TempDir::~TempDir() {
  std::error_code ignored;
  std::filesystem::remove_all(directory_, ignored);
}

Fd listen_at(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::ranges::copy(path, std::begin(address.sun_path));
  Fd socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  EXPECT_EQ(::bind(socket.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  EXPECT_EQ(::listen(socket.get(), 8), 0);
  return socket;
}

Server::Server(Handler handler)
    : listener_(listen_at(path())), handler_(std::move(handler)), thread_([this] { run(); }) {}

Server::~Server() {
  hang(false);
  ::shutdown(listener_.get(), SHUT_RDWR);  // wakes accept()
  thread_.join();
}

std::vector<control::Request> Server::requests() {
  const std::scoped_lock lock(mutex_);
  return requests_;
}

void Server::run() {
  for (;;) {
    const Fd connection(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
    if (!connection) return;
    serve(connection.get());
  }
}

void Server::serve(int connection) {
  control::Buffer buffer;
  for (;;) {
    const auto room = buffer.space();
    const auto n = ::recv(connection, room.data(), room.size(), 0);
    if (n <= 0) return;
    buffer.commit(static_cast<std::size_t>(n));
    for (;;) {
      auto request = control::decode_request(buffer);
      if (!request || !*request) break;
      hangs_.wait(true);
      if (std::holds_alternative<control::PingRequest>((*request)->body)) {
        const auto bytes = control::encode(control::Reply{(*request)->id, control::Done{}});
        ::send(connection, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        continue;
      }
      {
        const std::scoped_lock lock(mutex_);
        requests_.push_back({(*request)->id, (*request)->body});
      }
      auto answer = handler_(**request);
      for (auto& reply : answer.replies) {
        if (!std::holds_alternative<control::Event>(reply.body) && reply.id == 0)
          reply.id = (*request)->id;
        const auto bytes = control::encode(reply);
        ::send(connection, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      }
      if (answer.hang_up) return;
    }
  }
}

}  // namespace mlcca::test
