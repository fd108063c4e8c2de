// SPDX-License-Identifier: BSD-2-Clause
// Tests of the event channel handler while no descriptor is left for another connection.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "relay/famouso/handler.hpp"

namespace mlcca::relay {
namespace {

Fd connected_to(std::uint16_t port) {
  Fd out(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(port);
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::connect(out.get(), reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
  return out;
}

class HandlerRest : public ::testing::Test {
 protected:
  HandlerRest() {
    auto opened = EventChannelHandler::open(
        INADDR_LOOPBACK, 0, {}, "/nonexistent",
        {.log = [this](const std::string& text) { said_.push_back(text); },
         .user_of = [this](int) -> Result<uid_t> {
           ++asked_;
           return 1000;
         }});
    EXPECT_TRUE(opened) << opened.error().text;
    handler_ = std::move(*opened);
  }

  [[nodiscard]] bool is_ready(int milliseconds) const {
    pollfd waits{.fd = handler_->fd(), .events = POLLIN, .revents = 0};
    return ::poll(&waits, 1, milliseconds) > 0;
  }
  /// The number of turns for which the handler is ready while no descriptor is left, at most
  /// `most`.
  int turns_without_descriptors(int most) {
    rlimit before{};
    EXPECT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
    const rlimit none{3, before.rlim_max};
    EXPECT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
    int turns = 0;
    for (; turns < most && is_ready(0); ++turns) handler_->turn(now_);
    EXPECT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
    return turns;
  }
  bool reaches(std::size_t connections) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (handler_->connections() != connections) {
      if (std::chrono::steady_clock::now() > end) return false;
      static_cast<void>(is_ready(10));
      handler_->turn(now_);
    }
    return true;
  }

  std::vector<std::string> said_;
  std::unique_ptr<EventChannelHandler> handler_;
  std::uint64_t now_ = 1;
  int asked_ = 0;  ///< how often whose connection it is was asked
};

TEST_F(HandlerRest, WhoeverConnectsOtherWorkIsDoneInBetween) {
  std::vector<Fd> all;
  for (int i = 0; i < 20; ++i) all.push_back(connected_to(handler_->port()));
  ASSERT_TRUE(is_ready(60'000));
  handler_->turn(now_);
  EXPECT_LE(asked_, 4);
  EXPECT_TRUE(reaches(all.size()));
}

TEST_F(HandlerRest, WithoutDescriptorsItRestsAndTriesAgainAfterAWhile) {
  constexpr int most = 1000;
  const Fd one = connected_to(handler_->port());
  EXPECT_LT(turns_without_descriptors(most), most) << "the loop turns without end";
  ASSERT_EQ(said_.size(), 1U);
  EXPECT_NE(said_[0].find("whoever connects: accept: "), std::string::npos) << said_[0];
  now_ += EventChannelHandler::kRest - 1;
  handler_->turn(now_);
  EXPECT_EQ(handler_->connections(), 0U);
  now_ += 1;
  EXPECT_TRUE(reaches(1));
}

TEST_F(HandlerRest, WithoutDescriptorsItTriesAgainWhenAConnectionEnds) {
  constexpr int most = 1000;
  Fd one = connected_to(handler_->port());
  ASSERT_TRUE(reaches(1));
  const Fd other = connected_to(handler_->port());
  EXPECT_LT(turns_without_descriptors(most), most) << "the loop turns without end";
  EXPECT_EQ(handler_->connections(), 1U);
  one.reset();
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  // The descriptor has the same number again; what the other connection says must be read.
  constexpr std::string_view wrong = "QDistance";
  ASSERT_EQ(::send(other.get(), wrong.data(), wrong.size(), MSG_NOSIGNAL),
            static_cast<ssize_t>(wrong.size()));
  const auto taken = [this] {
    return std::ranges::any_of(
        said_, [](const auto& s) { return s.find("is closed: the first octet") != s.npos; });
  };
  while (!taken() && std::chrono::steady_clock::now() < end) {
    static_cast<void>(is_ready(10));
    handler_->turn(now_);
  }
  EXPECT_TRUE(taken());
}

}  // namespace
}  // namespace mlcca::relay
