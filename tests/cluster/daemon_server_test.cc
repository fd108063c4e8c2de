// SPDX-License-Identifier: BSD-2-Clause
// Tests of the control socket of mlcca-cluster, with a store that does not answer.
#include "cluster/daemon_server.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <array>

#include "base/unix_address.hpp"
#include "cluster/etcd.hpp"
#include "tests/cluster/fake_channel.hpp"
#include "tests/cluster/gateway.hpp"
#include "tests/support/require.hpp"

namespace mlcca::cluster {
namespace {

class ClusterServer : public ::testing::Test {
 protected:
  ClusterServer()
      : bridge_(loop_.get(),
                {.endpoints = {"https://a:1"},
                 .ca = {},
                 .certificate = {},
                 .key = {},
                 .timeout_ms = 10'000},
                {.open = [this](const std::string&) -> Result<std::unique_ptr<Channel>> {
                   return std::make_unique<test::FakeChannel>(calls_);
                 },
                 .log = [this](const std::string& text) { log_ += text + '\n'; }}),
        server_(loop_.get(), listening(), bridge_,
                [this](const auto& text) { log_ += text + '\n'; }) {
    EXPECT_TRUE(bridge_.start().has_value() && server_.start().has_value());
  }

  Fd listening() {
    Fd out(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    const auto address = unix_address(folder_ / "socket");
    test::require(
        ::bind(out.get(), generic(*address), sizeof *address) == 0 && ::listen(out.get(), 4) == 0,
        "listen");
    return out;
  }
  [[nodiscard]] Fd connected() const {
    Fd out(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    const auto address = unix_address(folder_ / "socket");
    test::require(::connect(out.get(), generic(*address), sizeof *address) == 0, "connect");
    return out;
  }
  static bool say(const Fd& to, const wire::Message& message) {
    return ::send(to.get(), message.data(), message.size(), MSG_NOSIGNAL) > 0;
  }
  /// Whether the server closes the connection.
  [[nodiscard]] bool ends(const Fd& socket) const {
    return loop_.until([&] {
      std::array<char, wire::kMaxMessage> buffer{};
      return ::recv(socket.get(), buffer.data(), buffer.size(), 0) == 0;
    });
  }
  [[nodiscard]] std::size_t under_way() const {
    std::size_t count = 0;
    for (const auto& call : calls_)
      if (!call->dropped && call->request.method == etcd::kTxn) ++count;
    return count;
  }

  test::Loop loop_;
  test::WorkFolder folder_;
  test::FakeChannel::Calls calls_;
  std::string log_;
  Bridge bridge_;
  DaemonServer server_;
};

TEST_F(ClusterServer, TakesNoMoreTransactionsThanItCarriesOutAndNoticesWhenMlccadGoes) {
  Fd socket = connected();
  ASSERT_TRUE(say(socket, wire::message_of(wire::Hello{"t", "gw"})));
  for (std::uint64_t id = 0; id < 100; ++id) {
    const auto message = wire::messages_of(test::creation(id, {"/t/a"}))[0];
    ASSERT_TRUE(loop_.until([&] { return say(socket, message); }));
  }
  ASSERT_TRUE(loop_.until([&] { return under_way() == 64; }));
  loop_.until([] { return false; }, std::chrono::milliseconds(20));
  EXPECT_EQ(under_way(), 64U);
  socket.reset();
  EXPECT_TRUE(loop_.until([&] { return under_way() == 0; }));
  EXPECT_FALSE(bridge_.is_busy());
}

TEST_F(ClusterServer, WhatIsNotUnderstoodEndsTheConnection) {
  for (const wire::Message& wrong : {wire::Message("x"), wire::message_of(ClusterSynced{1})}) {
    const Fd socket = connected();
    ASSERT_TRUE(say(socket, wrong));
    EXPECT_TRUE(ends(socket)) << log_;
  }
}

TEST_F(ClusterServer, ANewConnectionEndsTheFormer) {
  const Fd first = connected();
  ASSERT_TRUE(say(first, wire::message_of(wire::Hello{"t", "first"})));
  ASSERT_TRUE(loop_.until([&] { return log_.find("first") != std::string::npos; }));
  const Fd second = connected();
  EXPECT_TRUE(ends(first));
  ASSERT_TRUE(say(second, wire::message_of(wire::Hello{"t", "second"})));
  EXPECT_TRUE(loop_.until([&] { return log_.find("second") != std::string::npos; }));
}

/// The number of turns that the loop makes without waiting while no descriptor is left, at most
/// `most`.
int turns_without_descriptors(sd_event* loop, int most) {
  rlimit before{};
  test::require(::getrlimit(RLIMIT_NOFILE, &before) == 0, "getrlimit");
  const rlimit none{0, before.rlim_max};
  test::require(::setrlimit(RLIMIT_NOFILE, &none) == 0, "setrlimit");
  int turns = 0;
  while (turns < most && sd_event_run(loop, 0) > 0) ++turns;
  test::require(::setrlimit(RLIMIT_NOFILE, &before) == 0, "setrlimit");
  return turns;
}

TEST_F(ClusterServer, WithoutDescriptorsTheLoopRestsAndTriesAgain) {
  constexpr int most = 1000;
  const Fd first = connected();
  EXPECT_LT(turns_without_descriptors(loop_.get(), most), most) << "the loop turns without end";
  EXPECT_NE(log_.find("no connection can be taken: accept: "), std::string::npos) << log_;
  ASSERT_TRUE(say(first, wire::message_of(wire::Hello{"t", "first"})));
  EXPECT_TRUE(loop_.until([&] { return log_.find("first") != std::string::npos; }));
}

TEST_F(ClusterServer, WithoutDescriptorsItTriesAgainWhenTheFormerConnectionEnds) {
  constexpr int most = 1000;
  Fd first = connected();
  ASSERT_TRUE(say(first, wire::message_of(wire::Hello{"t", "first"})));
  ASSERT_TRUE(loop_.until([&] { return log_.find("first") != std::string::npos; }));
  const Fd second = connected();
  EXPECT_LT(turns_without_descriptors(loop_.get(), most), most) << "the loop turns without end";
  first.reset();
  ASSERT_TRUE(say(second, wire::message_of(wire::Hello{"t", "second"})));
  EXPECT_TRUE(loop_.until([&] { return log_.find("second") != std::string::npos; }));
}

}  // namespace
}  // namespace mlcca::cluster
