// SPDX-License-Identifier: BSD-2-Clause
// The connection that babel and olsr share, and the conversation with babeld, against a server of
// ours.
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/un.h>

#include "tests/tools/sources/proto_loop.hpp"
#include "tests/tools/sources/proto_server.hpp"
#include "tools/sources/line_client.hpp"

namespace mlcca::net {
namespace {

using core::mesh::Source;
using core::mesh::SourceKind;

class Conversation : public ::testing::Test {
 protected:
  Conversation() {
    sd_event* raw = nullptr;
    if (sd_event_new(&raw) < 0) std::abort();
    loop_.reset(raw);
  }
  [[nodiscard]] sd_event* loop() const { return loop_.get(); }

  static Source source(SourceKind kind, const std::string& endpoint) {
    Source out;
    out.kind = kind;
    out.endpoint = endpoint;
    return out;
  }

 private:
  std::unique_ptr<sd_event, FreeWith<sd_event_unref>> loop_;
};

const char* const kGreeting = "BABEL 1.0\nversion babeld-1.12.1\nhost vm\nmy-id 1\nok\n";
const char* const kTable =
    "add interface mesh0 up true ipv6 fe80::1\n"
    "add neighbour 1 address fe80::2 if mesh0 reach ffff ureach 0000 rxcost 256 txcost 256 cost "
    "256\n"
    "ok\n";

TEST(Endpoint, NumericHostsWithPortAndPathsAreEndpoints) {
  const auto v4 = parse_endpoint("127.0.0.1:2009");
  ASSERT_TRUE(v4);
  EXPECT_EQ(v4->address.ss_family, AF_INET);
  EXPECT_EQ(v4->size, sizeof(sockaddr_in));
  for (const char* text : {"[::1]:33123", "::1:33123"}) {
    const auto v6 = parse_endpoint(text);
    ASSERT_TRUE(v6) << text;
    EXPECT_EQ(v6->address.ss_family, AF_INET6);
  }
  const auto path = parse_endpoint("/run/babeld.sock");
  ASSERT_TRUE(path);
  EXPECT_EQ(path->address.ss_family, AF_UNIX);
  EXPECT_FALSE(parse_endpoint("/" + std::string(200, 'x')));
}

/// Listens at this port of the loopback, 0: at a free one.
Fd listening_at(std::uint16_t port) {
  Fd socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const int on = 1;
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(port);
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on), 0);
  EXPECT_EQ(::bind(socket.get(), reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
  EXPECT_EQ(::listen(socket.get(), 8), 0);
  return socket;
}

TEST_F(Conversation, IsOverWhereAnotherSocketListensThanBeforeTheConnection) {
  Fd server = listening_at(0);
  sockaddr_in at{};
  socklen_t size = sizeof at;
  ASSERT_EQ(::getsockname(server.get(), reinterpret_cast<sockaddr*>(&at), &size), 0);
  const std::uint16_t port = ntohs(at.sin_port);
  std::string why;
  int connected = 0;
  constexpr std::uint64_t patience = 60'000'000;  // µs
  LineClient client(*parse_endpoint("127.0.0.1:" + std::to_string(port)), patience, patience,
                    {.connected = [&] { ++connected; },
                     .line = [](std::string_view) {},
                     .ended = [&](const std::string& text) { why = text; }});
  ASSERT_TRUE(client.start(loop()));
  // The first turn connects; whoever listened then has gone when the client notices that it is
  // connected.
  ASSERT_GT(sd_event_run(loop(), patience), 0);
  const Fd accepted(::accept4(server.get(), nullptr, nullptr, SOCK_CLOEXEC));
  ASSERT_TRUE(accepted);
  server.reset();
  server = listening_at(port);
  while (why.empty() && connected == 0) ASSERT_GT(sd_event_run(loop(), patience), 0);
  EXPECT_EQ(why, "another socket listens there than a moment ago");
  EXPECT_EQ(connected, 0);
}

TEST_F(Conversation, MonitorsThenAsksForEverythingAgainAndAgain) {
  std::vector<std::string> asked;
  test::Server server(loop(), kGreeting, false, [&](const std::string& line) {
    asked.push_back(line);
    return kTable;
  });
  test::Watched watched(source(SourceKind::babel, server.endpoint()), {}, loop());
  const auto first = watched.await([](const auto& s) { return s.links.size() == 2; });
  ASSERT_TRUE(first) << watched.last();
  const auto fresh = watched.await([&](const auto& s) {
    return s.links.size() == 2 && s.links[0].taken > first->links[0].taken;
  });
  ASSERT_TRUE(fresh) << watched.last();
  ASSERT_GE(asked.size(), 2U);
  EXPECT_EQ(asked[0], "monitor");
  EXPECT_EQ(asked[1], "dump");
}

TEST_F(Conversation, AChangeIsReportedAtOnce) {
  test::Server server(loop(), kGreeting, false, [](const std::string&) { return kTable; });
  test::Watched watched(source(SourceKind::babel, server.endpoint()), {}, loop());
  ASSERT_TRUE(watched.await([](const auto& s) { return s.links.size() == 2; })) << watched.last();
  server.send_all("flush neighbour 1 address fe80::2 if mesh0\n");
  EXPECT_TRUE(watched.await([](const auto& s) { return s.links.empty() && s.problem.empty(); }))
      << watched.last();
}

TEST_F(Conversation, AConnectionThatBreaksIsReportedAndMadeAgain) {
  test::Server server(loop(), kGreeting, false, [](const std::string&) { return kTable; });
  test::Watched watched(source(SourceKind::babel, server.endpoint()), {}, loop());
  ASSERT_TRUE(watched.await([](const auto& s) { return s.links.size() == 2; })) << watched.last();
  server.drop_all();
  const auto lost = watched.await([](const auto& s) { return !s.problem.empty(); });
  ASSERT_TRUE(lost) << watched.last();
  EXPECT_TRUE(lost->links.empty());
  EXPECT_TRUE(watched.await([](const auto& s) { return s.links.size() == 2; })) << watched.last();
}

TEST_F(Conversation, ARefusalIsReported) {
  test::Server server(loop(), kGreeting, false, [](const std::string&) { return "bad\n"; });
  test::Watched watched(source(SourceKind::babel, server.endpoint()), {}, loop());
  const auto reported = watched.await([](const auto& s) { return !s.problem.empty(); });
  ASSERT_TRUE(reported);
  EXPECT_NE(reported->problem.find("refuses"), std::string::npos) << reported->problem;
}

TEST_F(Conversation, AServerThatSaysNothingIsLeftAndTriedAgain) {
  test::Server server(loop(), "", false, [](const std::string&) { return ""; });
  int connected = 0;
  std::string why;
  LineClient client(*parse_endpoint(server.endpoint()), 1000, 100'000,
                    {.connected = [&] { ++connected; },
                     .line = [](std::string_view) {},
                     .ended = [&](const std::string& reason) { why = reason; }});
  ASSERT_TRUE(client.start(loop()));
  while (connected < 2) ASSERT_GT(sd_event_run(loop(), 30'000'000), 0);
  EXPECT_NE(why.find("no complete answer"), std::string::npos) << why;
}

TEST_F(Conversation, AServerThatSendsNoLinesIsLeft) {
  test::Server server(loop(), std::string(2 * LineClient::kLongestLine, 'x'), false,
                      [](const std::string&) { return ""; });
  test::Watched watched(source(SourceKind::babel, server.endpoint()), {}, loop());
  const auto reported = watched.await([](const auto& s) { return !s.problem.empty(); });
  ASSERT_TRUE(reported);
  EXPECT_NE(reported->problem.find("longer than 65536 bytes"), std::string::npos)
      << reported->problem;
}

}  // namespace
}  // namespace mlcca::net
