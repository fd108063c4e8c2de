// SPDX-License-Identifier: BSD-2-Clause
#include "tools/sources/awds.hpp"

#include <sys/epoll.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <string>
#include <utility>

#include "base/loop_timer.hpp"
#include "base/system_error.hpp"
#include "base/throttle.hpp"
#include "base/unix_address.hpp"
#include "tools/sources/awds_packet.hpp"
#include "tools/sources/peer.hpp"

namespace mlcca::net {
namespace {

/// Packets that are handled before other events of the loop.
constexpr int kTurn = 64;

class Awds final : public LinkSource {
 public:
  Awds(std::string path, const sockaddr_un& address, core::mesh::AwdsMetric metric, sd_event* loop,
       core::mesh::DescribedNodes described, Report report)
      : path_(std::move(path)),
        address_(address),
        loop_(loop),
        report_(std::move(report)),
        graph_(metric, std::move(described)) {}

  Result<void> start() {
    if (auto started = throttle_.start(loop_, [this] { report(); }); !started) return started;
    return timer_.start(loop_, [this] { poll(); });
  }

 private:
  void poll() {
    if (!socket_) connect();
    throttle_.ask();
    timer_.set(kPollInterval);
  }

  void connect() {
    Fd socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    // Connecting to a local socket succeeds or fails at once.
    if (!socket || ::connect(socket.get(), generic(address_), sizeof address_) < 0) {
      problem_ = error_words(path_, errno);
      return;
    }
    if (const auto checked = check_peer(socket.get()); !checked) {
      problem_ = path_ + ": " + checked.error().text;
      return;
    }
    sd_event_source* raw = nullptr;
    if (const int e = sd_event_add_io(loop_, &raw, socket.get(), EPOLLIN, on_packets, this);
        e < 0) {
      problem_ = error_words(path_, -e);
      return;
    }
    io_.reset(raw);
    socket_ = std::move(socket);
    problem_.clear();
  }

  static int on_packets(sd_event_source*, int, std::uint32_t, void* self) noexcept {
    static_cast<Awds*>(self)->receive();
    return 0;
  }

  void receive() {
    bool changed = false;
    for (int i = 0; i < kTurn; ++i) {
      std::array<std::uint8_t, awds::kLongest> packet{};
      const auto size = ::recv(socket_.get(), packet.data(), packet.size(), 0);
      if (size < 0 && (errno == EAGAIN || errno == EINTR)) break;
      if (size <= 0) {
        disconnect(size == 0 ? "has closed" : error_words("receiving", errno));
        changed = true;
        break;
      }
      auto topology = awds::parse({packet.data(), static_cast<std::size_t>(size)});
      if (topology && graph_.take(std::move(*topology), loop_time(loop_))) changed = true;
    }
    if (changed) throttle_.ask();
  }

  /// Ends the connection. What was received stays valid for its time; the next poll connects again.
  void disconnect(const std::string& why) {
    io_.reset();
    socket_.reset();
    problem_ = path_ + ": " + why;
  }

  void report() {
    auto snapshot = graph_.snapshot(loop_time(loop_));
    if (snapshot.links.empty() && !problem_.empty()) snapshot.problem = problem_;
    report_(std::move(snapshot));
  }

  std::string path_;
  sockaddr_un address_;
  sd_event* loop_;
  Report report_;
  awds::Graph graph_;
  Fd socket_;
  EventSource io_;
  LoopTimer timer_;
  Throttle throttle_;
  std::string problem_;
};

}  // namespace

Result<std::unique_ptr<LinkSource>> open_awds(const core::mesh::Source& source,
                                              const core::mesh::Mesh& mesh, sd_event* loop,
                                              LinkSource::Report report) {
  const bool elsewhere = source.endpoint.starts_with('/');
  std::string path = elsewhere ? source.endpoint : kAwdsFolder + source.interface;
  const auto address = unix_address(path);
  if (!address) return std::unexpected(address.error());
  auto awds = std::make_unique<Awds>(std::move(path), *address, source.metric, loop,
                                     described_nodes(mesh), std::move(report));
  if (auto started = awds->start(); !started) return std::unexpected(started.error());
  return awds;
}

}  // namespace mlcca::net
