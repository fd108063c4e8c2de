// SPDX-License-Identifier: BSD-2-Clause
#include "tests/tools/sources/proto_server.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include <array>
#include <cstdlib>

namespace mlcca::test {

Server::Server(sd_event* loop, std::string greeting, bool closes, Answer answer)
    : loop_(loop),
      greeting_(std::move(greeting)),
      closes_(closes),
      answer_(std::move(answer)),
      listening_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  sd_event_source* raw = nullptr;
  if (::bind(listening_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) < 0 ||
      ::listen(listening_.get(), 8) < 0 ||
      sd_event_add_io(loop_, &raw, listening_.get(), EPOLLIN, on_connection, this) < 0)
    std::abort();
  source_.reset(raw);
}

std::string Server::endpoint() const {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  ::getsockname(listening_.get(), reinterpret_cast<sockaddr*>(&address), &size);
  return "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
}

void Server::send_all(const std::string& text) {
  for (const auto& [fd, client] : clients_) ::send(fd, text.data(), text.size(), MSG_NOSIGNAL);
}

int Server::on_connection(sd_event_source*, int listening, std::uint32_t, void* self) {
  auto& server = *static_cast<Server*>(self);
  Fd socket(::accept4(listening, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  const int fd = socket.get();
  sd_event_source* raw = nullptr;
  sd_event_add_io(server.loop_, &raw, fd, EPOLLIN, on_input, self);
  ::send(fd, server.greeting_.data(), server.greeting_.size(), MSG_NOSIGNAL);
  server.clients_.insert_or_assign(fd, Client{std::move(socket), Source(raw), {}});
  return 0;
}

int Server::on_input(sd_event_source*, int fd, std::uint32_t, void* self) {
  auto& server = *static_cast<Server*>(self);
  auto& client = server.clients_.at(fd);
  std::array<char, 4096> chunk{};
  const auto size = ::recv(fd, chunk.data(), chunk.size(), 0);
  bool over = size <= 0;
  if (!over) client.input.append(chunk.data(), static_cast<std::size_t>(size));
  for (auto end = client.input.find('\n'); !over && end != std::string::npos;
       end = client.input.find('\n')) {
    const std::string answer = server.answer_(client.input.substr(0, end));
    client.input.erase(0, end + 1);
    ::send(fd, answer.data(), answer.size(), MSG_NOSIGNAL);
    over = answer.empty() || server.closes_;
  }
  if (over) server.clients_.erase(fd);
  return 0;
}

}  // namespace mlcca::test
