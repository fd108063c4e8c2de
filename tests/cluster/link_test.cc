// SPDX-License-Identifier: BSD-2-Clause
// mlccad's end of the socket, with a program at the other end that does what a test says.
#include "daemon/cluster/link.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <optional>

#include "base/unix_address.hpp"
#include "tests/cluster/gateway.hpp"
#include "tests/support/require.hpp"

namespace mlcca::cluster {
namespace {

using core::cluster::Batch;
using core::cluster::Outcome;
using core::cluster::TxnResult;

class ClusterLinkTest : public ::testing::Test {
 protected:
  ClusterLinkTest() { listen(); }

  void listen() {
    listening_ = Fd(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    const auto address = unix_address(path());
    ::unlink(path().c_str());
    test::require(::bind(listening_.get(), generic(*address), sizeof *address) == 0 &&
                      ::listen(listening_.get(), 4) == 0,
                  "listen");
  }
  [[nodiscard]] std::string path() const { return folder_ / "socket"; }
  [[nodiscard]] bool accepts() {
    return loop_.until([this] {
      other_.reset(::accept4(listening_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
      reader_ = {};
      return static_cast<bool>(other_);
    });
  }
  /// The next thing that the link says, if it is of that kind.
  template <class Kind>
  std::optional<Kind> next() {
    std::optional<wire::ToStore> found;
    loop_.until([&] {
      std::array<char, wire::kMaxMessage> buffer{};
      const ssize_t n = ::recv(other_.get(), buffer.data(), buffer.size(), 0);
      if (n > 0)
        if (auto read = reader_.take({buffer.data(), static_cast<std::size_t>(n)}); read && *read)
          found = std::move(**read);
      return found || n == 0;
    });
    if (!found || !std::holds_alternative<Kind>(*found)) return std::nullopt;
    return std::get<Kind>(std::move(*found));
  }
  void say(const wire::Message& message) const {
    EXPECT_EQ(::send(other_.get(), message.data(), message.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(message.size()));
  }

  test::Loop loop_;
  test::WorkFolder folder_;
  Fd listening_;
  Fd other_;
  wire::ReaderOfGateway reader_;
};

TEST_F(ClusterLinkTest, SaysWhoItIsWhatItFollowsAndHowMuchItTakes) {
  test::Gateway gateway(loop_.get(), path(), {"/t/"});
  ASSERT_TRUE(accepts());
  EXPECT_EQ(next<wire::Hello>(), (wire::Hello{"t", "gw"}));
  EXPECT_EQ(next<wire::Follow>()->prefixes, (std::vector<std::string>{"/t/"}));
  EXPECT_EQ(next<wire::Credit>()->entries, 4096U);
  gateway.link.follow({"/u/"});
  EXPECT_EQ(next<wire::Follow>()->prefixes, (std::vector<std::string>{"/u/"}));
}

TEST_F(ClusterLinkTest, GivesCreditForWhatItHasTaken) {
  test::Gateway gateway(loop_.get(), path());
  ASSERT_TRUE(accepts());
  ASSERT_TRUE(next<wire::Hello>() && next<wire::Credit>());
  const Batch batch{
      .revision = 3,
      .entries = std::vector<core::cluster::Entry>(300, {.key = "/t/k", .value = {}})};
  std::size_t at = 0;
  say(wire::message_of(batch, at, 1000, true));
  EXPECT_EQ(next<wire::Credit>()->entries, 300U) << "also while the revision is not whole";
  EXPECT_EQ(gateway.revision, 0);
}

TEST_F(ClusterLinkTest, EachTransactionHasOneAnswerWhateverTheOtherEndSays) {
  test::Gateway gateway(loop_.get(), path());
  ASSERT_TRUE(accepts());
  int answers = 0;
  gateway.link.on_message([&](const ClusterMessage& message) {
    if (std::holds_alternative<TxnResult>(message)) ++answers;
    gateway.take(message);
  });
  ASSERT_TRUE(next<wire::Hello>() && next<wire::Credit>());
  gateway.link.send(test::creation(5, {"/t/a"}));
  EXPECT_EQ(next<core::cluster::Txn>()->id, 5U);
  const TxnResult result{
      .id = 5, .outcome = Outcome::committed, .revision = 9, .read = {}, .why = {}};
  TxnResult never = result;
  never.id = 6;
  for (const auto& said : {never, result, result}) say(wire::messages_of(said)[0]);
  say(wire::message_of(ClusterSynced{1}));
  ASSERT_TRUE(loop_.until([&] { return gateway.synced == 1; }));
  EXPECT_EQ(answers, 1);
  EXPECT_EQ(gateway.results[5].revision, 9);
}

TEST_F(ClusterLinkTest, WhenTheOtherEndGoesWhatWasSentIsUnsureAndTheRestUnavailable) {
  test::Gateway gateway(loop_.get(), path());
  gateway.link.send(test::creation(1, {"/t/a"}));
  EXPECT_TRUE(gateway.results.empty()) << "never within the call";
  ASSERT_TRUE(loop_.until([&] { return gateway.results.contains(1); }));
  EXPECT_EQ(gateway.results[1].outcome, Outcome::unavailable);
  ASSERT_TRUE(accepts());
  ASSERT_TRUE(next<wire::Hello>() && next<wire::Credit>());
  gateway.link.send(test::creation(2, {"/t/a"}));
  ASSERT_TRUE(next<core::cluster::Txn>());
  other_.reset();
  ASSERT_TRUE(loop_.until([&] { return gateway.results.contains(2); }));
  EXPECT_EQ(gateway.results[2].outcome, Outcome::unsure);
  EXPECT_FALSE(gateway.state.reachable);
  EXPECT_NE(gateway.state.problem, "");
  ASSERT_TRUE(accepts()) << "it connects again";
  EXPECT_TRUE(next<wire::Hello>());
}

TEST_F(ClusterLinkTest, WhoSaysWhatIsNotUnderstoodIsLeft) {
  test::Gateway gateway(loop_.get(), path());
  for (const wire::Message& wrong :
       {wire::Message("x"), wire::message_of(wire::Credit{1}), wire::Message(70'000, 'x')}) {
    ASSERT_TRUE(accepts());
    ASSERT_TRUE(next<wire::Hello>() && next<wire::Credit>());
    say(wrong);
    ASSERT_TRUE(loop_.until(
        [&] { return gateway.state.problem.find("not to be believed") != std::string::npos; }));
    gateway.state = {};
  }
}

TEST_F(ClusterLinkTest, WhoSaysNothingIsLeftAndWhatWasAskedIsUnsure) {
  test::Gateway gateway(loop_.get(), folder_ / "none");
  SocketLink link(
      loop_.get(),
      {.socket = path(), .hello = {"t", "gw"}, .timeout = 2'000'000'000, .pause = 50'000});
  link.on_message([&](ClusterMessage message) { gateway.take(std::move(message)); });
  ASSERT_TRUE(link.start().has_value());
  ASSERT_TRUE(accepts());
  ASSERT_TRUE(next<wire::Hello>() && next<wire::Credit>());
  auto txn = test::creation(1, {"/t/a"});
  txn.patience_ns = 1;
  link.send(txn);
  ASSERT_TRUE(loop_.until([&] { return gateway.results.contains(1); }));
  EXPECT_EQ(gateway.results[1].outcome, Outcome::unsure);
  EXPECT_TRUE(loop_.until([&] { return gateway.state.problem == "mlcca-cluster says nothing"; }));
}

TEST_F(ClusterLinkTest, MoreThanItMayKeepIsRefusedAtOnce) {
  test::Gateway gateway(loop_.get(), path());
  ASSERT_TRUE(accepts());
  ASSERT_TRUE(next<wire::Hello>() && next<wire::Credit>());
  for (std::uint64_t id = 0; id < 300; ++id)
    gateway.link.send(test::creation(id, {"/t/a"}, std::string(50'000, 'v')));
  ASSERT_TRUE(loop_.until([&] { return gateway.results.contains(299); }));
  EXPECT_EQ(gateway.results[299].outcome, Outcome::unavailable);
  EXPECT_FALSE(gateway.results.contains(0));
  auto wrong = test::creation(400, {""});
  gateway.link.send(wrong);
  ASSERT_TRUE(loop_.until([&] { return gateway.results.contains(400); }));
  EXPECT_EQ(gateway.results[400].outcome, Outcome::invalid);
}

}  // namespace
}  // namespace mlcca::cluster
