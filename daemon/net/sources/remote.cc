// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/sources/remote.hpp"

#include <sys/epoll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <deque>
#include <utility>

#include "base/clock.hpp"
#include "base/loop_timer.hpp"
#include "base/system_error.hpp"
#include "base/throttle.hpp"
#include "core/mesh/bounds.hpp"
#include "daemon/net/sources/child.hpp"
#include "daemon/net/sources/facts.hpp"

namespace mlcca::net {
namespace {

constexpr int kTurn = 16;                            // messages that are handled in one turn
constexpr std::uint64_t kLongestPause = 32'000'000;  // µs
constexpr std::uint64_t kStable = 60'000'000'000;    // ns after which a failure is the first one
constexpr std::uint64_t kRest = kLeastPause / 2;     // µs at least between two snapshots
// After a snapshot the sources of a mesh rest for this many times as long as it took to read and
// report it, but at most kLongestRest. So all of them together take a tenth of the time.
constexpr std::uint64_t kRestPerWork = 10;
constexpr std::uint64_t kLongestRest = 1'000'000;  // µs

class Remote final : public LinkSource {
 public:
  Remote(const core::mesh::Source& source, const core::mesh::Mesh& mesh, sd_event* loop,
         Report report, Helper helper)
      : question_(facts::question(source, mesh)),
        described_(described_nodes(mesh)),
        loop_(loop),
        report_(std::move(report)),
        sources_(std::max<std::size_t>(mesh.sources.size(), 1)),
        helper_(std::move(helper)),
        pause_(helper_.pause) {}

  Result<void> start() {
    if (auto rest = rest_.start(loop_, [this] { listen(); }); !rest) return rest;
    return timer_.start(loop_, [this] { poll(); });
  }

 private:
  void poll() {
    Child::collect();
    if (!peer_.socket)
      begin();
    else if (loop_time(loop_) > received_ + helper_.timeout)
      end("the process that reads it says nothing");
    else
      timer_.set(kPollInterval);
  }

  void begin() {
    auto peer = find_peer();
    if (!peer) {
      end(peer.error().text);
      return;
    }
    sd_event_source* raw = nullptr;
    if (const int e =
            sd_event_add_io(loop_, &raw, peer->socket.get(), EPOLLIN | EPOLLOUT, on_io, this);
        e < 0) {
      end(error_words("watching the process that reads it", -e));
      return;
    }
    io_.reset(raw);
    peer_ = std::move(*peer);
    reader_ = {};
    to_send_.assign(question_.begin(), question_.end());
    begun_ = received_ = loop_time(loop_);
    timer_.set(kPollInterval);
  }

  [[nodiscard]] Result<Peer> find_peer() const {
    if (::access(helper_.socket.c_str(), F_OK) == 0)
      return connect_to_helper(helper_.socket, "mlcca-sources.socket");
    return start_helper(helper_.program.empty() ? find_helper() : helper_.program);
  }

  static int on_io(sd_event_source*, int, std::uint32_t events, void* self) noexcept {
    auto& remote = *static_cast<Remote*>(self);
    if ((events & EPOLLOUT) != 0) remote.send();
    if (remote.io_ && (events & ~EPOLLOUT) != 0) {
      const std::uint64_t begin = monotonic_ns();
      const bool whole = remote.receive();
      remote.worked_ += monotonic_ns() - begin;
      if (whole) remote.rest();
    }
    return 0;
  }

  void send() {
    while (!to_send_.empty()) {
      const auto& next = to_send_.front();
      if (::send(peer_.socket.get(), next.data(), next.size(), MSG_DONTWAIT | MSG_NOSIGNAL) < 0) {
        if (errno != EAGAIN && errno != EINTR) end(ended(errno));
        return;
      }
      to_send_.pop_front();
    }
    listen();
  }

  /// Sets which events of the socket are awaited, when everything was sent or a rest has ended.
  void listen() {
    if (io_)
      sd_event_source_set_io_events(io_.get(), to_send_.empty() ? EPOLLIN : EPOLLIN | EPOLLOUT);
  }

  /// Reads messages; true if a snapshot was completed and reported.
  bool receive() {
    for (int i = 0; i < kTurn && io_; ++i) {
      const auto size = ::recv(peer_.socket.get(), buffer_.data(), buffer_.size(), MSG_TRUNC);
      if (size < 0 && (errno == EAGAIN || errno == EINTR)) return false;
      if (size <= 0) {
        end(ended(size == 0 ? 0 : errno));
        return false;
      }
      if (take(static_cast<std::size_t>(size))) return true;
    }
    return false;
  }

  /// Rests, so that the process cannot cause more snapshots than the loop has time for.
  void rest() {
    sd_event_source_set_io_events(io_.get(), 0);
    const std::uint64_t work = std::exchange(worked_, 0) / 1000;
    rest_.set(std::clamp(work * kRestPerWork * sources_, kRest, kLongestRest));
  }

  /// Takes one message; true if it has completed a snapshot, which was reported.
  bool take(std::size_t size) {
    auto read = size > buffer_.size() ? fail("it sent a message that is too long")
                                      : reader_.take({buffer_.data(), size});
    if (!read) {
      end("the process that reads it is not to be believed: " + read.error().text);
      return false;
    }
    if (!*read) return false;
    received_ = loop_time(loop_);
    report_(bounded(std::move(**read), described_, received_));
    return true;
  }

  static std::string ended(int error) {
    const std::string what = "the process that reads it has ended";
    return error == 0 ? what : error_words(what, error);
  }

  void end(const std::string& why) {
    const std::uint64_t now = loop_time(loop_);
    if (peer_.socket && now > begun_ + kStable) pause_ = helper_.pause;
    io_.reset();
    peer_ = {};
    to_send_.clear();
    timer_.set(pause_);
    pause_ = std::min(2 * pause_, kLongestPause);
    report_(core::mesh::bounded({.links = {}, .next_hops = {}, .problem = why}, described_, now));
  }

  std::vector<facts::Message> question_;
  core::mesh::DescribedNodes described_;
  sd_event* loop_;
  Report report_;
  std::size_t sources_;  ///< of the mesh
  Helper helper_;
  std::uint64_t pause_;  ///< µs before the next process
  Peer peer_;
  std::deque<facts::Message> to_send_;
  facts::AnswerReader reader_;
  std::array<char, facts::kMaxMessage> buffer_{};
  std::uint64_t begun_ = 0;     ///< ns
  std::uint64_t worked_ = 0;    ///< ns of work since the latest rest
  std::uint64_t received_ = 0;  ///< ns: time of the latest snapshot
  EventSource io_;
  LoopTimer timer_;
  LoopTimer rest_;
};

}  // namespace

Result<std::unique_ptr<LinkSource>> open_remote(const core::mesh::Source& source,
                                                const core::mesh::Mesh& mesh, sd_event* loop,
                                                LinkSource::Report report, Helper helper) {
  auto made = std::make_unique<Remote>(source, mesh, loop, std::move(report), std::move(helper));
  if (auto started = made->start(); !started) return std::unexpected(started.error());
  return made;
}

}  // namespace mlcca::net
