// SPDX-License-Identifier: BSD-2-Clause
// Calls over HTTP/2 to peers that accept, and then do nothing more or only half of it.
#include "cluster/http.hpp"

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/handle.hpp"
#include "tests/cluster/gateway.hpp"
#include "tests/cluster/processes.hpp"
#include "tests/support/require.hpp"

namespace mlcca::cluster {
namespace {

using std::chrono::milliseconds;

/// Much longer than the limit of a call, also on a busy machine.
constexpr milliseconds kInTime{20'000};

/// Names in .silent are looked up until the end of the test.
class Lookups {
 public:
  void wait() {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, 2 * kInTime, [this] { return ended_; });
  }
  void end() {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ended_ = false;
};
/// Never destroyed: a thread of libcurl may still be in it at the end of the program.
Lookups& lookups = *new Lookups;

}  // namespace
}  // namespace mlcca::cluster

/// In place of the function of the C library, for libcurl as well.
extern "C" int getaddrinfo(const char* node, const char* service, const addrinfo* hints,
                           addrinfo** found) {
  const std::string_view name = node == nullptr ? "" : node;
  if (name.ends_with(".silent")) {
    mlcca::cluster::lookups.wait();
    return EAI_AGAIN;
  }
  static const auto real =
      reinterpret_cast<decltype(&getaddrinfo)>(::dlsym(RTLD_NEXT, "getaddrinfo"));
  return real(node, service, hints, found);
}

namespace mlcca::cluster {
namespace {

constexpr std::uint64_t kShort = 200;    // ms
constexpr std::uint64_t kLong = 60'000;  // ms

class ClusterHttp : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::WorkFolder;
    test::require(prepare_http().has_value(), "libcurl");
    test::require(test::run_script(R"(
openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -keyout key.pem \
	-out cert.pem -subj /CN=peer -addext subjectAltName=IP:127.0.0.1 -days 2
)",
                                   folder_->path()),
                  "a certificate");
  }
  static void TearDownTestSuite() { delete std::exchange(folder_, nullptr); }

  std::unique_ptr<Channel> open(const std::string& endpoint, std::uint64_t timeout_ms) {
    auto channel = open_http(loop_.get(),
                             {.endpoints = {endpoint},
                              .ca = *folder_ / "cert.pem",
                              .certificate = *folder_ / "cert.pem",
                              .key = *folder_ / "key.pem",
                              .timeout_ms = timeout_ms},
                             endpoint);
    test::require(channel.has_value(), "a channel");
    return std::move(*channel);
  }

  /// A call, and how it has ended.
  struct Asked {
    std::unique_ptr<Call> call;
    std::optional<End> end;
  };
  static std::unique_ptr<Asked> ask(Channel& channel, std::uint64_t timeout_ms,
                                    bool stays_open = false) {
    auto asked = std::make_unique<Asked>();
    asked->call = channel.start({.method = "/a.B/C",
                                 .message = "message",
                                 .timeout_ms = timeout_ms,
                                 .stays_open = stays_open,
                                 .on_answer = [](const std::string&) {},
                                 .on_end = [to = asked.get()](const End& end) { to->end = end; }});
    return asked;
  }
  static std::string loopback(int port) { return "https://127.0.0.1:" + std::to_string(port); }

  inline static test::WorkFolder* folder_ = nullptr;
  test::Loop loop_;
};

/// Accepts connections and never says anything.
class Silent {
 public:
  Silent() : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* const generic = reinterpret_cast<sockaddr*>(&address);
    test::require(::bind(socket_.get(), generic, size) == 0 && ::listen(socket_.get(), 16) == 0 &&
                      ::getsockname(socket_.get(), generic, &size) == 0,
                  "a silent peer");
    port_ = ntohs(address.sin_port);
  }
  [[nodiscard]] int port() const { return port_; }

 private:
  Fd socket_;
  int port_ = 0;
};

TEST_F(ClusterHttp, ACallThatWaitsForTheConnectionOfAnotherOneEndsInItsTime) {
  const Silent peer;
  const auto channel = open(loopback(peer.port()), kLong);
  const auto first = ask(*channel, 0, true);
  loop_.until([] { return false; }, milliseconds(50));
  const auto second = ask(*channel, kShort);
  ASSERT_TRUE(loop_.until([&] { return second->end.has_value(); }, kInTime));
  EXPECT_EQ(second->end->status, End::kNoStatus);
  EXPECT_FALSE(second->end->sent) << "nothing of it has left";
  EXPECT_FALSE(first->end) << "it has no limit";
}

TEST_F(ClusterHttp, ACallEndsInItsTimeWhateverTheTimeOfAConnection) {
  const Silent peer;
  const auto channel = open(loopback(peer.port()), kLong);
  const auto asked = ask(*channel, kShort);
  ASSERT_TRUE(loop_.until([&] { return asked->end.has_value(); }, kInTime));
  EXPECT_FALSE(asked->end->sent);
}

TEST_F(ClusterHttp, ANameThatNobodyResolvesHoldsUpNothing) {
  const auto begun = std::chrono::steady_clock::now();
  auto channel = open("https://store.silent:1", kShort);
  auto asked = ask(*channel, kShort);
  EXPECT_TRUE(loop_.until([&] { return asked->end.has_value(); }, kInTime));
  asked.reset();
  channel.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - begun, kInTime);
  lookups.end();
}

}  // namespace
}  // namespace mlcca::cluster
