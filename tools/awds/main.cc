// SPDX-License-Identifier: BSD-2-Clause
// mlcca-awds INTERFACE [SOCKET]: passes topology packets of AWDS on to connected readers. It is a
// separate program because it alone needs CAP_NET_RAW, for one call. It does not parse packets: the
// only parser is in mlcca-sources, and this program stays small enough to review.
#include <linux/capability.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <systemd/sd-event.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <memory>
#include <string>
#include <utility>

#include "base/at_once.hpp"
#include "base/listen.hpp"
#include "base/loop_timer.hpp"
#include "base/standard_streams.hpp"
#include "base/system_error.hpp"
#include "base/throttle.hpp"
#include "tools/awds/capture.hpp"
#include "tools/awds/readers.hpp"
#include "tools/sources/awds_packet.hpp"

namespace mlcca::awds {
namespace {

/// Packets that are passed on before other events of the loop are handled.
constexpr int kTurn = 64;

void say(const std::string& text) { write_at_once(STDERR_FILENO, "mlcca-awds: " + text + '\n'); }

/// Gives up all capabilities for good.
Result<void> drop_capabilities() {
  __user_cap_header_struct header{.version = _LINUX_CAPABILITY_VERSION_3, .pid = 0};
  const std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> none{};
  if (::syscall(SYS_capset, &header, none.data()) < 0)
    return system_error("giving up capabilities");
  return {};
}

/// The socket that systemd has passed, or a new one at `path`.
Result<Fd> listening_socket(const char* path) {
  if (path != nullptr) return listen_at(path, SOCK_SEQPACKET);
  auto given = handed_over(SOCK_SEQPACKET);
  if (given && !*given) return fail("no socket: start mlcca-awds@INTERFACE.socket, or name one");
  return given;
}

class Relay {
 public:
  Relay(Capture capture, Fd listening, sd_event* loop)
      : loop_(loop), capture_(std::move(capture)), readers_(loop, std::move(listening)) {}

  Result<void> start() {
    sd_event_source* raw = nullptr;
    if (const int e = sd_event_add_io(loop_, &raw, capture_.fd(), EPOLLIN, on_packets, this); e < 0)
      return system_error("watching the interface", -e);
    io_.reset(raw);
    if (auto started = readers_.start(); !started) return started;
    return timer_.start(loop_, [this] { poll(); });  // at once, and then periodically
  }

 private:
  void poll() {
    std::string problem;
    if (const auto following = capture_.follow(); !following) problem = following.error().text;
    if (problem != problem_) {
      say(problem.empty() ? "listening" : problem);
      problem_ = std::move(problem);
      reported_ = false;
    }
    if (!reported_)  // until it is accepted, because systemd waits for the first notification
      reported_ = notify("READY=1\nSTATUS=" + (problem_.empty() ? "listening" : problem_));
    timer_.set(kPollInterval);
  }

  static int on_packets(sd_event_source*, int, std::uint32_t, void* self) noexcept {
    const auto& relay = *static_cast<const Relay*>(self);
    std::array<std::uint8_t, net::awds::kLongest> buffer{};
    for (int i = 0; i < kTurn; ++i) {
      const auto packet = relay.capture_.next(buffer);
      if (packet.empty()) break;
      relay.readers_.send(packet);
    }
    return 0;
  }

  sd_event* loop_;
  Capture capture_;
  Readers readers_;
  EventSource io_;
  LoopTimer timer_;
  std::string problem_;
  bool reported_ = false;  ///< systemd has received problem_
};

Result<void> serve(const std::string& interface, const char* path) {
  auto listening = listening_socket(path);
  if (!listening) return std::unexpected(listening.error());
  auto capture = Capture::open(interface);
  if (!capture) return std::unexpected(capture.error());
  if (auto dropped = drop_capabilities(); !dropped) return dropped;

  sigset_t handled;
  sigemptyset(&handled);
  for (const int signal : {SIGTERM, SIGINT}) sigaddset(&handled, signal);
  ::sigprocmask(SIG_BLOCK, &handled, nullptr);
  sd_event* raw = nullptr;
  int e = sd_event_new(&raw);
  const std::unique_ptr<sd_event, FreeWith<sd_event_unref>> loop(raw);
  for (const int signal : {SIGTERM, SIGINT})
    if (e >= 0) e = sd_event_add_signal(raw, nullptr, signal, nullptr, nullptr);
  if (e < 0) return system_error("event loop", -e);
  Relay relay(std::move(*capture), std::move(*listening), raw);
  if (auto started = relay.start(); !started) return started;
  if (e = sd_event_loop(raw); e < 0) return system_error("event loop", -e);
  return {};
}

}  // namespace
}  // namespace mlcca::awds

int main(int argc, char** argv) {
  mlcca::keep_standard_streams();
  if (argc < 2 || argc > 3 || argv[1][0] == '-') {
    mlcca::awds::say("usage: mlcca-awds INTERFACE [SOCKET]");
    return 2;
  }
  ::signal(SIGPIPE, SIG_IGN);  // NOLINT(cert-err33-c): a log without a reader
  try {
    const auto served = mlcca::awds::serve(argv[1], argc == 3 ? argv[2] : nullptr);
    if (served) return 0;
    mlcca::awds::say(served.error().text);
  } catch (const std::exception& e) {
    mlcca::awds::say(e.what());
  }
  return 1;
}
