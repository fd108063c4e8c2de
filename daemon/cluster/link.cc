// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/cluster/link.hpp"

#include <sys/epoll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "base/loop_timer.hpp"
#include "base/system_error.hpp"
#include "daemon/net/sources/child.hpp"

namespace mlcca::cluster {
namespace {

using core::cluster::Outcome;
using core::cluster::StoreState;
using core::cluster::Txn;
using core::cluster::TxnResult;

constexpr std::size_t kTurnEntries = 256;  // that are handled in one turn
constexpr int kTurnMessages = 64;
constexpr std::uint32_t kCredit = 4096;                     // entries that may be in transit
constexpr std::size_t kLeastCredit = kTurnEntries;          // that is worth a message
constexpr std::size_t kMostUnderWay = 256;                  // transactions
constexpr std::size_t kMostQueued = std::size_t{4} << 20U;  // bytes of them
constexpr std::uint64_t kGrace = 500'000'000;        // ns after the patience of a transaction
constexpr std::uint64_t kLongestPause = 32'000'000;  // µs
constexpr std::uint64_t kStable = 60'000'000'000;    // ns after which a failure is the first one
constexpr std::uint64_t kRound = 500'000;            // µs
constexpr std::uint64_t kNanosInAMicro = 1'000;

}  // namespace

SocketLink::SocketLink(sd_event* loop, Options options)
    : loop_(loop), options_(std::move(options)), pause_(options_.pause) {}

Result<void> SocketLink::start() {
  if (auto started = deliveries_.start(loop_, [this] { deliver(); }); !started) return started;
  return timer_.start(loop_, [this] { poll(); });
}

void SocketLink::on_message(std::function<void(ClusterMessage)> call) { call_ = std::move(call); }

void SocketLink::introduce(std::string cluster, std::string gateway) {
  options_.hello = {.cluster = std::move(cluster), .gateway = std::move(gateway)};
}

void SocketLink::wait(std::uint64_t ns) { sd_event_run(loop_, ns / kNanosInAMicro); }

void SocketLink::send(const Txn& txn) {
  auto& under_way = under_way_[txn.id];
  under_way.until = loop_time(loop_) + txn.patience_ns + kGrace;
  const std::string misfit = wire::misfit_of(txn);
  if (!misfit.empty()) {
    answer(txn.id, Outcome::invalid, misfit);
  } else if (!io_) {
    answer(txn.id, Outcome::unavailable, "there is no connection to mlcca-cluster");
  } else if (under_way_.size() > kMostUnderWay || queued_bytes_ > kMostQueued) {
    answer(txn.id, Outcome::unavailable, "too many transactions are under way");
  } else {
    for (auto& message : wire::messages_of(txn))
      push({.message = std::move(message), .of_txn = true, .id = txn.id});
    send_queued();
  }
}

void SocketLink::follow(std::vector<std::string> prefixes) {
  prefixes_ = std::move(prefixes);
  if (!io_) return;
  push({.message = wire::message_of(wire::Follow{prefixes_})});
  send_queued();
}

void SocketLink::poll() {
  answer_late();
  if (!io_) {
    begin();
  } else if (loop_time(loop_) > received_ + options_.timeout) {
    end("mlcca-cluster says nothing");
  } else {
    timer_.set(kRound);
  }
}

void SocketLink::begin() {
  auto peer = net::connect_to_helper(options_.socket, "mlcca-cluster.socket");
  if (!peer) {
    end(peer.error().text);
    return;
  }
  sd_event_source* raw = nullptr;
  if (const int e =
          sd_event_add_io(loop_, &raw, peer->socket.get(), EPOLLIN | EPOLLOUT, on_io, this);
      e < 0) {
    end(error_words("watching mlcca-cluster", -e));
    return;
  }
  io_.reset(raw);
  socket_ = std::move(peer->socket);
  reader_ = {};
  owed_ = 0;
  begun_ = received_ = loop_time(loop_);
  push({.message = wire::message_of(options_.hello)});
  if (!prefixes_.empty()) push({.message = wire::message_of(wire::Follow{prefixes_})});
  push({.message = wire::message_of(wire::Credit{kCredit})});
  timer_.set(kRound);
}

int SocketLink::on_io(sd_event_source*, int, std::uint32_t events, void* self) noexcept {
  auto& link = *static_cast<SocketLink*>(self);
  if ((events & EPOLLOUT) != 0) link.send_queued();
  if (link.io_ && (events & ~EPOLLOUT) != 0) link.receive();
  return 0;
}

void SocketLink::push(Queued queued) {
  queued_bytes_ += queued.message.size();
  queue_.push_back(std::move(queued));
}

void SocketLink::send_queued() {
  while (io_ && !queue_.empty()) {
    const Queued& next = queue_.front();
    if (::send(socket_.get(), next.message.data(), next.message.size(),
               MSG_DONTWAIT | MSG_NOSIGNAL) < 0) {
      if (errno != EAGAIN && errno != EINTR) {
        end(error_words("mlcca-cluster", errno));
        return;
      }
      sd_event_source_set_io_events(io_.get(), EPOLLIN | EPOLLOUT);
      return;
    }
    if (next.of_txn)
      if (const auto txn = under_way_.find(next.id); txn != under_way_.end())
        txn->second.sent = true;
    queued_bytes_ -= next.message.size();
    queue_.pop_front();
  }
  if (io_) sd_event_source_set_io_events(io_.get(), EPOLLIN);
}

void SocketLink::receive() {
  handled_ = 0;
  for (int i = 0; i < kTurnMessages && handled_ < kTurnEntries && io_; ++i) {
    const auto size = ::recv(socket_.get(), buffer_.data(), buffer_.size(), MSG_TRUNC);
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (size <= 0) {
      end(size == 0 ? "mlcca-cluster has ended the connection"
                    : error_words("mlcca-cluster", errno));
      return;
    }
    take(static_cast<std::size_t>(size));
  }
}

void SocketLink::take(std::size_t size) {
  auto read = size > buffer_.size() ? fail("it sent a message that is too long")
                                    : reader_.take({buffer_.data(), size});
  if (!read) {
    end("mlcca-cluster is not to be believed: " + read.error().text);
    return;
  }
  received_ = loop_time(loop_);
  handled_ += read->entries;
  if (read->whole) handle(std::move(*read->whole));
  give_credit(read->entries);
}

void SocketLink::handle(ClusterMessage message) {
  // Results that were answered here already, or never requested, are dropped.
  if (const auto* result = std::get_if<TxnResult>(&message);
      result != nullptr && under_way_.erase(result->id) == 0)
    return;
  if (call_) call_(std::move(message));
}

void SocketLink::give_credit(std::size_t entries) {
  owed_ += entries;
  if (owed_ < kLeastCredit || !io_) return;
  push({.message = wire::message_of(wire::Credit{static_cast<std::uint32_t>(owed_)})});
  owed_ = 0;
  send_queued();
}

void SocketLink::answer(std::uint64_t id, Outcome outcome, const std::string& why) {
  if (under_way_.erase(id) == 0) return;
  due_.emplace_back(TxnResult{.id = id, .outcome = outcome, .revision = 0, .read = {}, .why = why});
  deliveries_.set(0);
}

void SocketLink::answer_late() {
  const std::uint64_t now = loop_time(loop_);
  std::vector<std::uint64_t> late;
  for (const auto& [id, txn] : under_way_)
    if (now > txn.until) late.push_back(id);
  for (const std::uint64_t id : late)
    answer(id, Outcome::unsure, "mlcca-cluster has not answered in time");
}

void SocketLink::end(const std::string& why) {
  if (io_ && loop_time(loop_) > begun_ + kStable) pause_ = options_.pause;
  io_.reset();
  socket_.reset();
  queue_.clear();
  queued_bytes_ = 0;
  timer_.set(pause_);
  pause_ = std::min(2 * pause_, kLongestPause);
  StoreState state{};
  state.problem = why;
  due_.emplace_back(std::move(state));
  for (const auto& [id, txn] : std::exchange(under_way_, {}))
    due_.emplace_back(TxnResult{.id = id,
                                .outcome = txn.sent ? Outcome::unsure : Outcome::unavailable,
                                .revision = 0,
                                .read = {},
                                .why = why});
  deliveries_.set(0);
}

void SocketLink::deliver() {
  for (auto& message : std::exchange(due_, {}))
    if (call_) call_(std::move(message));
}

}  // namespace mlcca::cluster
