// SPDX-License-Identifier: BSD-2-Clause
// The client against a daemon that behaves, and against several that do not.
#include "control/client.hpp"

#include <gtest/gtest.h>
#include <sys/fsuid.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <array>

#include "control/codec.hpp"
#include "tests/control/messages.hpp"
#include "tests/control/server.hpp"

namespace mlcca::control {
namespace {

using namespace std::chrono_literals;
using test::Server;

/// Drops root's right to ignore file permissions.
class AsNobody {
 public:
  AsNobody() : before_(static_cast<uid_t>(::setfsuid(65534))) {}
  ~AsNobody() { ::setfsuid(before_); }
  AsNobody(const AsNobody&) = delete;
  AsNobody& operator=(const AsNobody&) = delete;

 private:
  uid_t before_;
};

std::pair<Fd, Fd> pair_of(int type) {
  std::array<int, 2> fds{};
  EXPECT_EQ(::socketpair(AF_UNIX, type, 0, fds.data()), 0);
  return {Fd(fds[0]), Fd(fds[1])};
}

void send_all(const Fd& socket, const std::string& bytes) {
  EXPECT_EQ(::send(socket.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL),
            static_cast<ssize_t>(bytes.size()));
}

TEST(ClientTest, GetsTheReplyToItsRequest) {
  Server server([](const Request&) { return Server::Answer{{{0, test::full_status()}}}; });
  auto client = Client::connect(server.path());
  ASSERT_TRUE(client) << client.error().text;
  for (int i = 0; i < 3; ++i) {
    const auto reply = client->call({0, StatusRequest{}});
    ASSERT_TRUE(reply) << reply.error().text;
    EXPECT_EQ(std::get<Status>(reply->body), test::full_status());
  }
}

TEST(ClientTest, ReceivesAReplyOfManyPieces) {
  const Reply large{0, Done{std::string(5'000'000, 'a')}};
  Server server([&](const Request&) { return Server::Answer{{large}}; });
  auto client = Client::connect(server.path());
  ASSERT_TRUE(client);
  const auto reply = client->call({0, ReloadRequest{}});
  ASSERT_TRUE(reply) << reply.error().text;
  EXPECT_EQ(reply->body, large.body);
}

TEST(ClientTest, KeepsEventsThatComeBeforeTheReply) {
  auto second = test::full_event();
  second.message = "second";
  Server server([&](const Request&) {
    return Server::Answer{{{0, test::full_event()}, {0, Done{"x"}}, {0, second}}, true};
  });
  auto client = Client::connect(server.path());
  ASSERT_TRUE(client);
  const auto reply = client->call({0, MonitorRequest{}});
  ASSERT_TRUE(reply) << reply.error().text;
  EXPECT_EQ(std::get<Done>(reply->body).message, "x");
  EXPECT_EQ(client->next_event(), test::full_event());
  EXPECT_EQ(client->next_event(), second);
  const auto end = client->next_event();
  ASSERT_FALSE(end);
  EXPECT_EQ(end.error().text, "mlccad closed the connection");
}

TEST(ClientTest, PutsTheSlicesOfAReplyTogether) {
  const auto all = test::full_networks();
  ASSERT_GE(all.networks.size(), 2U);
  std::vector<Reply> slices;
  for (const Network& network : all.networks) {
    slices.push_back({0, Networks{{network}}, true});
    slices.push_back({0, test::full_event()});
  }
  slices.push_back({0, Networks{}});
  Server server([&](const Request& request) {
    EXPECT_TRUE(request.slices);
    return Server::Answer{slices};
  });
  auto client = Client::connect(server.path());
  ASSERT_TRUE(client);
  const auto reply = client->call({0, NetworksRequest{}});
  ASSERT_TRUE(reply) << reply.error().text;
  EXPECT_EQ(std::get<Networks>(reply->body), all);
  EXPECT_FALSE(reply->more);
  EXPECT_EQ(client->next_event(), test::full_event());
}

TEST(ClientTest, SendsARequestInOnePiece) {
  auto [near, far] = pair_of(SOCK_SEQPACKET);
  send_all(far, encode(Reply{1, Done{}}));
  Client client(std::move(near));
  ASSERT_TRUE(client.call({0, Query{test::full_channel_request()}}));
  std::array<char, 4096> packet{};
  const auto n = ::recv(far.get(), packet.data(), packet.size(), 0);
  EXPECT_EQ(std::string(packet.data(), static_cast<std::size_t>(n)),
            encode(Request{1, Query{test::full_channel_request()}, true}));
}

TEST(ClientTest, SaysThatThereIsNoDaemon) {
  const test::TempDir directory;
  const auto path = directory.path("none.sock");
  const auto client = Client::connect(path);
  ASSERT_FALSE(client);
  EXPECT_EQ(client.error().text, "no daemon: " + path + ": No such file or directory");
}

TEST(ClientTest, SaysThatNoProcessListens) {
  const test::TempDir directory;
  const auto path = directory.path("left.sock");
  test::listen_at(path).reset();
  const auto client = Client::connect(path);
  ASSERT_FALSE(client);
  EXPECT_EQ(client.error().text, "no daemon listens: " + path + ": Connection refused");
}

TEST(ClientTest, SaysThatPermissionIsMissing) {
  const test::TempDir directory;
  const auto path = directory.path("closed.sock");
  const auto listener = test::listen_at(path);
  ASSERT_EQ(::chmod(path.c_str(), 0), 0);
  const AsNobody nobody;
  const auto client = Client::connect(path);
  ASSERT_FALSE(client);
  EXPECT_EQ(client.error().text,
            "not permitted to ask the daemon: " + path + ": Permission denied");
}

TEST(ClientTest, TakesPathsThatFitAnAddressAndNoOthers) {
  const auto longest = Client::connect("/" + std::string(106, 'x'));
  ASSERT_FALSE(longest);
  EXPECT_TRUE(longest.error().text.starts_with("no daemon: ")) << longest.error().text;
  for (const std::string& path : {std::string(), "/" + std::string(107, 'x')}) {
    const auto client = Client::connect(path);
    ASSERT_FALSE(client);
    EXPECT_NE(client.error().text.find("must have 1 to 107 bytes"), std::string::npos);
  }
}

TEST(ClientTest, GivesUpOnADaemonThatDoesNotAnswer) {
  const test::TempDir directory;
  const auto listener = test::listen_at(directory.path("mute.sock"));
  auto client = Client::connect(directory.path("mute.sock"), 20ms);
  ASSERT_TRUE(client);
  const auto reply = client->call({0, StatusRequest{}});
  ASSERT_FALSE(reply);
  EXPECT_EQ(reply.error().text, "no answer from mlccad within 20 ms");
}

TEST(ClientTest, WaitsForAnEventOnlyUntilTheOtherEndIsReadable) {
  auto [near, far] = pair_of(SOCK_STREAM);
  auto [input, other] = pair_of(SOCK_STREAM);
  Client client(std::move(near), 20ms);
  send_all(other, "x");
  const auto interrupted = client.next_event_unless(input.get());
  ASSERT_TRUE(interrupted) << interrupted.error().text;
  EXPECT_EQ(*interrupted, std::nullopt);
  other.reset();
  EXPECT_EQ(*client.next_event_unless(input.get()), std::nullopt);
}

TEST(ClientTest, PrefersTheEventsThatAreThere) {
  auto [near, far] = pair_of(SOCK_STREAM);
  auto [input, other] = pair_of(SOCK_STREAM);
  Client client(std::move(near));
  other.reset();
  const auto bytes = encode(Reply{0, test::full_event()});
  send_all(far, bytes + bytes + bytes.substr(0, 9));
  EXPECT_EQ(*client.next_event_unless(input.get()), test::full_event());
  EXPECT_EQ(*client.next_event_unless(input.get()), test::full_event());
  EXPECT_EQ(*client.next_event_unless(input.get()), std::nullopt);
  send_all(far, bytes.substr(9));
  EXPECT_EQ(*client.next_event_unless(input.get()), test::full_event());
  far.reset();
  const auto end = client.next_event_unless(input.get());
  ASSERT_FALSE(end);
  EXPECT_EQ(end.error().text, "mlccad closed the connection");
}

TEST(ClientTest, GivesUpOnADaemonThatDoesNotAccept) {
  const test::TempDir directory;
  const auto path = directory.path("full.sock");
  const auto listener = test::listen_at(path);
  std::vector<Client> waiting;
  for (;;) {
    auto client = Client::connect(path, 20ms);
    if (!client) {
      EXPECT_EQ(client.error().text, "the daemon does not answer: " + path);
      break;
    }
    waiting.push_back(std::move(*client));
    ASSERT_LT(waiting.size(), 100U);
  }
}

TEST(ClientTest, ReportsADaemonThatGoesAwayInAReply) {
  auto [near, far] = pair_of(SOCK_STREAM);
  send_all(far, encode(Reply{1, Done{"half"}}).substr(0, 5));
  far.reset();
  Client client(std::move(near));
  const auto reply = client.call({0, StatusRequest{}});
  ASSERT_FALSE(reply);
}

TEST(ClientTest, SaysThatItCouldNotSend) {
  auto [near, far] = pair_of(SOCK_STREAM);
  far.reset();
  Client client(std::move(near));
  const auto reply = client.call({0, StatusRequest{}});
  ASSERT_FALSE(reply);
  EXPECT_EQ(reply.error().text, "send to mlccad: Broken pipe");
}

TEST(ClientTest, ReadsTheRefusalOfADaemonThatHasHungUp) {
  auto [near, far] = pair_of(SOCK_STREAM);
  send_all(far, encode(Reply{0, Error{ErrorKind::invalid, "unknown request", {}}}));
  far.reset();
  Client client(std::move(near));
  const auto reply = client.call({0, StatusRequest{}});
  ASSERT_TRUE(reply) << reply.error().text;
  EXPECT_EQ(std::get<Error>(reply->body).message, "unknown request");
}

TEST(ClientTest, DoesNotTakeAReplyToSomethingElse) {
  auto [near, far] = pair_of(SOCK_STREAM);
  send_all(far, encode(Reply{2, Done{"other"}}));
  Client client(std::move(near));
  const auto reply = client.call({0, StatusRequest{}});
  ASSERT_FALSE(reply);
  EXPECT_EQ(reply.error().text, "mlccad answered request 2 instead of 1");
}

TEST(ClientTest, DoesNotSendWhatTheDaemonWouldRefuse) {
  auto [near, far] = pair_of(SOCK_STREAM);
  Client client(std::move(near));
  const auto reply = client.call({0, ExplainRequest{std::string(Request::kMaxBytes, 'a')}});
  ASSERT_FALSE(reply);
  EXPECT_NE(reply.error().text.find("at most 65536"), std::string::npos);
}

}  // namespace
}  // namespace mlcca::control
