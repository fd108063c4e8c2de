// SPDX-License-Identifier: BSD-2-Clause
// The server over a real socket and loop, with answers that a test makes up.
#pragma once
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "control/buffer.hpp"
#include "control/codec.hpp"
#include "control/slices.hpp"
#include "daemon/serve/server.hpp"

namespace mlcca::serve {

using control::Reply;
using control::Request;

inline constexpr int kManyTurns = 20'000;
inline constexpr gid_t kGroup = 4242;
inline constexpr gid_t kNoGroup = 65'000;

class ServerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "serve-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    sd_event* raw = nullptr;
    ASSERT_GE(sd_event_new(&raw), 0);
    loop_.reset(raw);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, (folder_ + "/s").c_str(), sizeof address.sun_path - 1);
    address_ = address;
    Fd listening(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    ASSERT_EQ(::bind(listening.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    ASSERT_EQ(::listen(listening.get(), 64), 0);
    std::filesystem::permissions(folder_, std::filesystem::perms::all);
    std::filesystem::permissions(folder_ + "/s", std::filesystem::perms::all);
    auto server = Server::open(
        loop_.get(), std::move(listening), kGroup,
        [this](const Request& request, const Peer& peer) { return answer_(request, peer); });
    ASSERT_TRUE(server);
    server_ = std::move(*server);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Fd client() {
    Fd socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    EXPECT_EQ(::connect(socket.get(), reinterpret_cast<sockaddr*>(&address_), sizeof address_), 0);
    return socket;
  }

  /// Of this user, whom the server has accepted or refused. Needs root.
  Fd client_of(uid_t uid, gid_t gid = kNoGroup) {
    EXPECT_EQ(::setegid(gid), 0);
    EXPECT_EQ(::seteuid(uid), 0);
    Fd socket = client();
    EXPECT_EQ(::seteuid(0), 0);
    EXPECT_EQ(::setegid(0), 0);
    run();
    return socket;
  }
  /// What an error says that has come; "hung up" without one; nothing where neither is so.
  std::string fate(const Fd& socket) {
    control::Buffer buffer;
    for (const Reply& reply : replies(socket, buffer))
      if (const auto* error = std::get_if<control::Error>(&reply.body)) return error->message;
    char more = 0;
    return ::recv(socket.get(), &more, 1, MSG_DONTWAIT) == 0 ? "hung up" : "";
  }
  bool is_served(const Fd& socket) {
    control::Buffer buffer;
    ask(socket, 1);
    const auto all = replies(socket, buffer);
    return all.size() == 1 && std::holds_alternative<control::Done>(all[0].body);
  }

  /// Turns of the loop until there is nothing to do.
  void run() {
    for (int i = 0; i < kManyTurns && sd_event_run(loop_.get(), 0) > 0;) ++i;
  }

  void ask(const Fd& socket, std::uint64_t id, bool slices = true,
           decltype(Request::body) body = control::ChannelsRequest{}) {
    const std::string bytes = control::encode(Request{id, std::move(body), slices});
    ASSERT_EQ(::send(socket.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }

  /// All that has come, and what comes while it is read.
  std::vector<Reply> replies(const Fd& socket, control::Buffer& buffer) {
    std::vector<Reply> all;
    for (;;) {
      run();
      auto room = buffer.space(65536);
      const ssize_t n = ::recv(socket.get(), room.data(), room.size(), MSG_DONTWAIT);
      if (n <= 0) return all;
      buffer.commit(static_cast<std::size_t>(n));
      for (;;) {
        auto reply = control::decode_reply(buffer);
        if (!reply || !*reply) break;
        all.push_back(std::move(**reply));
      }
    }
  }

  /// `rows` channels with a description of `bytes`, one a slice.
  Answer channels(std::uint64_t id, int rows, std::size_t bytes) {
    Answer answer{Reply{id, {}}};
    answer.slices = [this, rows, bytes, next = 0]() mutable -> std::optional<Slice> {
      ++made_;
      control::Channels out;
      out.channels.emplace_back().subject = static_cast<std::uint64_t>(next);
      out.channels.back().description = std::string(bytes, 'x');
      return Slice{std::move(out), ++next < rows};
    };
    return answer;
  }

  std::string folder_;
  sockaddr_un address_{};
  std::unique_ptr<sd_event, FreeWith<sd_event_unref>> loop_;
  std::unique_ptr<Server> server_;
  std::function<Answer(const Request&, const Peer&)> answer_;
  int made_ = 0;
};

}  // namespace mlcca::serve
