// SPDX-License-Identifier: BSD-2-Clause
#include "cluster/bridge.hpp"

#include <algorithm>
#include <utility>

#include "base/clock.hpp"
#include "base/many.hpp"
#include "cluster/grpc.hpp"
#include "cluster/outcome.hpp"

namespace mlcca::cluster {
namespace {

using core::cluster::Outcome;
using core::cluster::StoreState;
using core::cluster::Txn;
using core::cluster::TxnResult;

constexpr std::uint64_t kNanosInAMilli = 1'000'000;
constexpr std::uint64_t kMicrosInAMilli = 1000;
constexpr std::uint64_t kFirstPause = 100'000;      // µs
constexpr std::uint64_t kLongestPause = 3'200'000;  // µs
constexpr std::uint64_t kRefusedPause = 1'600'000;  // µs; longer, because an administrator must
                                                    // grant access first
constexpr unsigned kMostFailures = 3;
constexpr std::uint64_t kStandsStill = 5;  // timeouts after which the watch must have reported

}  // namespace

Bridge::Bridge(sd_event* loop, const Settings& settings, Outside outside)
    : loop_(loop),
      settings_(settings),
      outside_(std::move(outside)),
      endpoints_(settings.endpoints),
      follower_(outbox_,
                {.failed = [this](auto trouble, const auto& why) { take_trouble(trouble, why); },
                 .wrote =
                     [this] {
                       if (wrote_) wrote_();
                     }}),
      pause_(kFirstPause) {}

Result<void> Bridge::start() {
  if (auto started = poll_.start(loop_,
                                 [this] {
                                   if (channel_ && !status_call_) ask_status();
                                 });
      !started)
    return started;
  if (auto started = reconnect_.start(loop_,
                                      [this] {
                                        retired_.reset();
                                        if (session_ && !channel_) connect();
                                      });
      !started)
    return started;
  return refollow_.start(loop_, [this] {
    if (confirmed_ && !follower_.is_active()) follow();
  });
}

void Bridge::take(wire::ToStore message) {
  if (const auto* hello = std::get_if<wire::Hello>(&message)) {
    if (std::exchange(session_, true)) return;
    outside_.log("gateway " + hello->gateway + " of cluster " + hello->cluster);
    if (!channel_) connect();
  } else if (auto* follow_message = std::get_if<wire::Follow>(&message)) {
    follower_.set_prefixes(std::move(follow_message->prefixes));
    if (confirmed_) follow();
  } else if (const auto* credit = std::get_if<wire::Credit>(&message)) {
    outbox_.add_credit(credit->entries);
    if (wrote_) wrote_();
  } else {
    run(std::get<Txn>(message));
  }
}

void Bridge::end_session() {
  session_ = confirmed_ = false;
  follower_.stop();
  follower_.set_prefixes({});
  status_call_.reset();
  under_way_.clear();
  channel_.reset();
  outbox_ = {};
  status_.reset();
  refused_.clear();
  problem_.clear();
}

void Bridge::connect() {
  auto channel = outside_.open(endpoints_.current());
  if (!channel) {
    drop(channel.error().text);
    return;
  }
  channel_ = std::move(*channel);
  failures_ = 0;
  ask_status();
}

void Bridge::ask_status() {
  fresh_.reset();
  status_call_ = channel_->start(
      {.method = etcd::kStatus,
       .message = {},
       .timeout_ms = settings_.timeout_ms,
       .on_answer = [this](const std::string& answer) { fresh_ = etcd::read_status(answer); },
       .on_end = [this, asked = monotonic_ns()](const End& end) { take_status(end, asked); }});
}

void Bridge::take_status(const End& end, std::uint64_t asked) {
  status_call_.reset();
  if (end.status != grpc::kOk) {
    drop(end.text);
  } else if (!fresh_) {
    drop("an answer is not understood");
  } else if (fresh_->leader == 0) {
    drop("this member knows no leader");
  } else if (stands_still()) {
    drop("the watch stands still");
  } else {
    status_ = fresh_;
    latency_ = monotonic_ns() - asked;
    endpoints_.succeeded();
    problem_.clear();
    if (follower_.watches()) {
      pause_ = kFirstPause;
      refused_.clear();
    }
    if (!std::exchange(confirmed_, true) && follower_.has_prefixes()) follow();
    put_state();
    poll_.set(2 * settings_.timeout_ms * kMicrosInAMilli);
  }
}

/// A watch has no limit of time. If it works it soon reports what was written here.
void Bridge::note_written(std::int64_t revision) {
  if (lacking_ != 0) return;
  lacking_ = revision;
  lacking_since_ = monotonic_ns();
}

bool Bridge::stands_still() {
  if (!follower_.lacks(lacking_)) lacking_ = 0;
  return lacking_ != 0 &&
         monotonic_ns() - lacking_since_ > kStandsStill * settings_.timeout_ms * kNanosInAMilli;
}

void Bridge::follow() {
  lacking_ = 0;
  follower_.stop();
  if (follower_.has_prefixes()) follower_.start(*channel_, settings_.timeout_ms);
}

void Bridge::take_trouble(Follower::Trouble trouble, const std::string& why) {
  if (trouble == Follower::Trouble::broken) {
    drop(why);
    return;
  }
  const bool refused = trouble == Follower::Trouble::refused;
  refused_ = refused ? why : std::string();
  if (!refused) outside_.log(endpoints_.current() + ": " + why + "; a new snapshot is taken");
  refollow_.set(refused ? kRefusedPause : pause_);
  pause_ = std::min(2 * pause_, kLongestPause);
  put_state();
}

void Bridge::run(const Txn& txn) {
  TxnResult refused{
      .id = txn.id, .outcome = Outcome::unavailable, .revision = 0, .read = {}, .why = {}};
  if (under_way_.contains(txn.id)) {
    refused.outcome = Outcome::invalid;
    refused.why = "a transaction of this number is under way";
    answer(refused);
  } else if (!channel_) {
    refused.why = problem_.empty() ? "there is no connection to the store" : problem_;
    answer(refused);
  } else {
    const std::uint64_t id = txn.id;
    UnderWay& one = under_way_[id];
    one.gets = txn.else_get;
    one.followed = std::ranges::any_of(
        txn.puts, [this](const auto& put) { return follower_.follows(put.key); });
    one.call =
        channel_->start({.method = etcd::kTxn,
                         .message = etcd::txn_request(txn),
                         .timeout_ms = std::max<std::uint64_t>(txn.patience_ns / kNanosInAMilli, 1),
                         .on_answer =
                             [this, id](const std::string& octets) {
                               UnderWay& of = under_way_.at(id);
                               of.answer = etcd::read_txn(octets, of.gets);
                             },
                         .on_end = [this, id](const End& end) { end_txn(id, end); }});
  }
}

void Bridge::end_txn(std::uint64_t id, const End& end) {
  const auto of = under_way_.extract(id);
  TxnResult result{
      .id = id, .outcome = outcome_of(end), .revision = 0, .read = {}, .why = end.text};
  if (end.status == grpc::kOk && of.mapped().answer) {
    auto& read = *of.mapped().answer;
    result.outcome = read.succeeded ? Outcome::committed : Outcome::conflict;
    result.revision = read.header.revision;
    if (read.succeeded && of.mapped().followed) note_written(result.revision);
    for (auto& entry : read.read) result.read.push_back(wire::bounded(std::move(entry)));
  }
  const bool failed = end.status == End::kNoStatus || end.status == grpc::kUnavailable;
  answer(result);
  if (end.stuck && end.sent)
    drop(end.text);
  else if (failed)
    note_failure(end.text);
  else
    failures_ = 0;
}

/// Counts a failed transaction. A status request finds out whether this member or the store is at
/// fault; after kMostFailures failures the bridge goes to the next member.
void Bridge::note_failure(const std::string& why) {
  if (++failures_ >= kMostFailures)
    drop(why);
  else if (!status_call_)
    ask_status();
}

void Bridge::answer(const TxnResult& result) {
  outbox_.put(result);
  if (wrote_) wrote_();
}

void Bridge::drop(const std::string& why) {
  problem_ = endpoints_.current() + ": " + why;
  confirmed_ = false;
  refused_.clear();
  follower_.stop();
  status_call_.reset();
  status_.reset();
  for (auto& [id, of] : std::exchange(under_way_, {}))
    answer({.id = id,
            .outcome = of.call->sent() ? Outcome::unsure : Outcome::unavailable,
            .revision = 0,
            .read = {},
            .why = problem_});
  if (channel_) retired_ = std::move(channel_);
  put_state();
  reconnect_.set(endpoints_.failed());
}

void Bridge::put_state() {
  StoreState state{};
  state.problem =
      problem_.empty() && !refused_.empty() ? endpoints_.current() + ": " + refused_ : problem_;
  state.reachable = confirmed_ && state.problem.empty();
  state.endpoint = endpoints_.current();
  if (status_) {
    state.cluster_id = status_->header.cluster_id;
    state.db_bytes = status_->db_bytes;
    state.no_space = status_->no_space;
    state.latency_ns = latency_;
  }
  log_state(state);
  outbox_.put(std::move(state));
  if (wrote_) wrote_();
}

void Bridge::log_state(const StoreState& state) {
  const auto report = outage_.take(!state.problem.empty(), monotonic_ns());
  if (report == Outage::Report::none) return;
  if (report == Outage::Report::back) {
    outside_.log(state.endpoint + " answers");
    return;
  }
  const unsigned more = outage_.take_unreported();
  outside_.log(
      "the store is lost: " + state.problem +
      (more == 0 ? "" : " (and " + many(more, "time") + " for a moment since the last report)"));
}

}  // namespace mlcca::cluster
