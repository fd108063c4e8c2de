// SPDX-License-Identifier: BSD-2-Clause
// Tests of the server of mlcca-exporter while no descriptor is left for a connection.
#include "tools/exporter/http.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <array>
#include <chrono>
#include <string>
#include <string_view>
#include <vector>

namespace mlcca::exporter {
namespace {

sockaddr_in loopback() {
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return at;
}

bool is_ready(const Http& http, int milliseconds) {
  pollfd waits{.fd = http.fd(), .events = POLLIN, .revents = 0};
  return ::poll(&waits, 1, milliseconds) > 0;
}

TEST(ExporterHttp, WithoutDescriptorsItRestsAndAnswersOnceThereAreSome) {
  constexpr int most = 1000;
  sockaddr_in at = loopback();
  socklen_t size = sizeof at;
  auto* const generic = reinterpret_cast<sockaddr*>(&at);
  const Fd listening(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  ASSERT_EQ(::bind(listening.get(), generic, size), 0);
  ASSERT_EQ(::listen(listening.get(), 4), 0);
  ASSERT_EQ(::getsockname(listening.get(), generic, &size), 0);
  const auto http = Http::serve(listening, [] { return std::string("figures\n"); });
  ASSERT_TRUE(http) << http.error().text;
  const Fd client(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  ASSERT_EQ(::connect(client.get(), generic, size), 0);
  constexpr std::string_view request = "GET /metrics HTTP/1.1\r\nHost: here\r\n\r\n";
  ASSERT_EQ(::send(client.get(), request.data(), request.size(), MSG_NOSIGNAL),
            static_cast<ssize_t>(request.size()));

  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit none{3, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  int turns = 0;
  for (; turns < most && is_ready(**http, 0); ++turns) (*http)->turn();
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_LT(turns, most) << "the loop turns without end";

  std::string answer;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (answer.find("figures") == std::string::npos && std::chrono::steady_clock::now() < end) {
    is_ready(**http, (*http)->patience());
    (*http)->turn();
    std::array<char, 4096> octets{};
    const ssize_t n = ::recv(client.get(), octets.data(), octets.size(), MSG_DONTWAIT);
    if (n > 0) answer.append(octets.data(), static_cast<std::size_t>(n));
  }
  EXPECT_NE(answer.find("figures"), std::string::npos) << answer;
}

/// Who connects and says nothing does not keep others out.
TEST(ExporterHttp, ConnectionsThatAskNothingMakeRoomForOneThatAsks) {
  constexpr std::size_t connections = 40;
  sockaddr_in at = loopback();
  socklen_t size = sizeof at;
  auto* const generic = reinterpret_cast<sockaddr*>(&at);
  const Fd listening(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  ASSERT_EQ(::bind(listening.get(), generic, size), 0);
  ASSERT_EQ(::listen(listening.get(), connections), 0);
  ASSERT_EQ(::getsockname(listening.get(), generic, &size), 0);
  const auto http = Http::serve(listening, [] { return std::string("figures\n"); });
  ASSERT_TRUE(http) << http.error().text;
  std::vector<Fd> idle;
  for (std::size_t i = 0; i < 16; ++i) {
    idle.emplace_back(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    ASSERT_EQ(::connect(idle.back().get(), generic, size), 0);
    (*http)->turn();
  }
  const Fd client(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  ASSERT_EQ(::connect(client.get(), generic, size), 0);
  constexpr std::string_view request = "GET /metrics HTTP/1.1\r\nHost: here\r\n\r\n";
  ASSERT_EQ(::send(client.get(), request.data(), request.size(), MSG_NOSIGNAL),
            static_cast<ssize_t>(request.size()));
  std::string answer;
  // Fewer than the seconds that libmicrohttpd gives a quiet connection.
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(8);
  while (answer.find("figures") == std::string::npos && std::chrono::steady_clock::now() < end) {
    is_ready(**http, (*http)->patience());
    (*http)->turn();
    std::array<char, 4096> octets{};
    const ssize_t n = ::recv(client.get(), octets.data(), octets.size(), MSG_DONTWAIT);
    if (n > 0) answer.append(octets.data(), static_cast<std::size_t>(n));
  }
  EXPECT_NE(answer.find("figures"), std::string::npos) << answer;
}

}  // namespace
}  // namespace mlcca::exporter
