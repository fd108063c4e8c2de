// SPDX-License-Identifier: BSD-2-Clause
// The data plane in C, between two of a process, as two programs on a gateway.
#pragma once
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "control/codec.hpp"
#include "mlcca/client/events.h"

namespace mlcca::client {

inline constexpr std::uint64_t kStop = 0x73746f7000000000;

struct Free {
  void operator()(mlcca_events* events) const { mlcca_events_free(events); }
};
using Events = std::unique_ptr<mlcca_events, Free>;

inline std::string reply_with(const std::vector<control::Endpoint>& endpoints) {
  control::Channels channels;
  channels.channels.emplace_back().subject = kStop;
  channels.endpoints = endpoints;
  return encode(control::Reply{.id = 1, .body = std::move(channels)});
}

inline control::Endpoint to_program(const std::string& address, std::uint32_t user = ::getuid()) {
  control::Endpoint out;
  out.local = address;
  out.local_user = user;
  return out;
}
inline control::Endpoint from_programs_of(std::uint32_t user) {
  control::Endpoint out;
  out.user = user;
  return out;
}

/// What is wrong; empty: nothing.
inline std::string use(const Events& events, std::uint64_t end, mlcca_role role,
                       const std::string& reply, std::size_t room = 200) {
  std::string why(room, '?');
  const int done =
      mlcca_events_use(events.get(), end, role, reply.data(), reply.size(), why.data(), room);
  why.resize(room == 0 ? 0 : std::char_traits<char>::length(why.c_str()));
  EXPECT_EQ(done, why.empty() && room != 0 ? 0 : -1);
  return why;
}

struct Came {
  std::vector<std::string> all;
  std::vector<std::uint64_t> times;
  static void take(void* context, std::uint64_t end, const void* data, std::size_t size,
                   const char* network, std::uint64_t unix_ns) {
    EXPECT_STREQ(network, "");
    EXPECT_GT(unix_ns, 1'600'000'000'000'000'000U);
    static_cast<Came*>(context)->times.push_back(unix_ns);
    static_cast<Came*>(context)->all.push_back(std::to_string(end) + " " +
                                               std::string(static_cast<const char*>(data), size));
  }
};

/// What a digit of an address stands for.
inline unsigned digit(char c) { return c <= '9' ? c - '0' : c - 'a' + 10; }

/// The name of the socket in an address, and its key as datagrams have it.
inline std::string name_in(const std::string& address) { return address.substr(0, 5); }
inline std::string key_in(const std::string& address) {
  std::string out;
  for (std::size_t at = 5; at + 1 < address.size(); at += 2)
    out += static_cast<char>(digit(address[at]) << 4U | digit(address[at + 1]));
  return out;
}

/// A program of another user, where this one may become it, sends each of them, many times.
inline void send_as_another_user(const std::string& name,
                                 const std::vector<std::string>& datagrams) {
  const pid_t child = ::fork();
  if (child == 0) {
    constexpr uid_t nobody = 65'534;
    if (::geteuid() == 0 && ::setresuid(nobody, nobody, nobody) != 0) ::_exit(2);
    const int socket = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (socket < 0) ::_exit(3);
    sockaddr_un to{};
    to.sun_family = AF_UNIX;
    name.copy(&to.sun_path[1], name.size());
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
    for (int i = 0; i < 600; ++i)  // more than any queue has: net.unix.max_dgram_qlen
      for (const std::string& one : datagrams)
        static_cast<void>(::sendto(socket, one.data(), one.size(), MSG_DONTWAIT,
                                   reinterpret_cast<sockaddr*>(&to), size));
    ::_exit(0);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_EQ(status, 0);
}

class EventsInC : public ::testing::Test {
 protected:
  std::vector<std::string> came() {
    Came out;
    mlcca_events_process(subscriber_.get(), Came::take, &out);
    return out.all;
  }
  bool is_readable() {
    pollfd waits{.fd = mlcca_events_fd(subscriber_.get()), .events = POLLIN, .revents = 0};
    return ::poll(&waits, 1, 0) == 1;
  }
  mlcca_published publish(const std::string& text) {
    return mlcca_events_publish(publisher_.get(), 7, text.data(), text.size());
  }

  Events publisher_{mlcca_events_new()};
  Events subscriber_{mlcca_events_new()};
  const std::string address_ = mlcca_events_address(subscriber_.get(), 3);
};

}  // namespace mlcca::client
