// SPDX-License-Identifier: BSD-2-Clause
#include "cluster/follower.hpp"

#include <algorithm>
#include <utility>

#include "base/text.hpp"
#include "cluster/grpc.hpp"

namespace mlcca::cluster {
namespace {

using core::cluster::Batch;
using core::cluster::Entry;

constexpr std::size_t kRoom = std::size_t{4} << 20U;  // octets that may wait in the outbox before a
                                                      // page is requested
constexpr std::size_t kMostBytes = std::size_t{16} << 20U;  // octets that may wait in the outbox at
                                                            // all
constexpr std::size_t kMostEntries = 200'000;
constexpr std::uint64_t kPatience = 5;  // factor on the timeout, because a page is large

std::size_t bytes_of(const std::vector<Entry>& entries) {
  std::size_t bytes = 0;
  for (const Entry& entry : entries) bytes += entry.key.size() + entry.value.size();
  return bytes;
}

}  // namespace

Prefixes::Prefixes(std::vector<std::string> all) {
  std::ranges::sort(all);
  for (auto& prefix : all)
    if (!prefix.empty() && !has(prefix)) all_.push_back(std::move(prefix));
}

bool Prefixes::has(std::string_view key) const {
  const auto behind = std::ranges::upper_bound(all_, key, std::less<std::string_view>{});
  return behind != all_.begin() && key.starts_with(*std::prev(behind));
}

std::string Prefixes::folder() const {
  if (all_.empty()) return {};
  // The prefixes are sorted, so what the first and the last have in common all have.
  const auto& first = all_.front();
  const auto& last = all_.back();
  const auto same = std::ranges::mismatch(first, last).in1 - first.begin();
  const auto slash = std::string_view(first).substr(0, static_cast<std::size_t>(same)).rfind('/');
  return slash == std::string_view::npos ? std::string() : first.substr(0, slash + 1);
}

void Follower::start(Channel& channel, std::uint64_t timeout_ms) {
  stop();
  channel_ = &channel;
  timeout_ms_ = timeout_ms;
  prefix_ = 0;
  revision_ = 0;
  key_ = prefixes_.all().front();
  paging_ = true;
  ask_page();
}

void Follower::stop() {
  call_.reset();
  channel_ = nullptr;
  paging_ = waits_ = watching_ = false;
  outbox_.forget_feed();
}

void Follower::go_on() {
  if (waits_ && outbox_.fed_bytes() < kRoom) ask_page();
}

void Follower::ask_page() {
  waits_ = outbox_.fed_bytes() >= kRoom;
  if (waits_) return;
  call_ = channel_->start({.method = etcd::kRange,
                           .message = etcd::range_request(
                               key_, etcd::end_of(prefixes_.all()[prefix_]), limit_, revision_),
                           .timeout_ms = kPatience * timeout_ms_,
                           .on_answer = [this](const std::string& answer) { take_page(answer); },
                           .on_end = [this](const End& end) { end_page(end); }});
}

void Follower::take_page(const std::string& answer) {
  auto page = etcd::read_page(answer);
  if (!page || page->header.revision <= 0 || (page->more && page->entries.empty())) {
    fail(Trouble::broken, "an answer is not understood");
    return;
  }
  if (revision_ == 0) {
    revision_ = page->header.revision;
    outbox_.begin(revision_);
  }
  if (page->more)
    key_ = page->entries.back().key + '\0';
  else
    key_.clear();
  for (Entry& entry : page->entries) entry = wire::bounded(std::move(entry));
  outbox_.put_page(Batch{.revision = revision_, .entries = std::move(page->entries)});
  outside_.wrote();
}

void Follower::end_page(const End& end) {
  if (end.too_long && limit_ > 1) {
    limit_ /= 2;
    ask_page();
  } else if (end.status == grpc::kOk && revision_ > 0) {
    if (key_.empty())
      next_prefix();
    else
      ask_page();
  } else if (end.status == grpc::kOutOfRange) {
    fail(Trouble::again, "a snapshot: " + end.text);
  } else if (end.status == grpc::kPermissionDenied || end.status == grpc::kUnauthenticated) {
    fail(Trouble::refused, "the store refuses " + prefixes_.all()[prefix_] + ": " + end.text);
  } else {
    fail(Trouble::broken, end.text);
  }
}

void Follower::next_prefix() {
  if (++prefix_ < prefixes_.all().size()) {
    key_ = prefixes_.all()[prefix_];
    ask_page();
    return;
  }
  paging_ = false;
  outbox_.synced(revision_);
  outside_.wrote();
  watch();
}

void Follower::watch() {
  const std::string folder = prefixes_.folder();
  if (folder.empty()) {
    fail(Trouble::refused, "what is to be followed is in no folder");
    return;
  }
  call_ = channel_->start(
      {.method = etcd::kWatch,
       .message = etcd::watch_request(folder, etcd::end_of(folder), revision_ + 1),
       .stays_open = true,
       .on_answer = [this](const std::string& answer) { take_changes(answer); },
       .on_end =
           [this](const End& end) {
             const bool again = end.too_long || end.status == grpc::kOk;
             fail(again ? Trouble::again : Trouble::broken,
                  "the watch has ended: " + (end.text.empty() ? "no cause is stated" : end.text));
           }});
}

void Follower::take_changes(const std::string& answer) {
  auto changes = etcd::read_changes(answer);
  if (!changes) {
    fail(Trouble::broken, "an answer is not understood");
  } else if (changes->canceled) {
    const bool refused = changes->reason.find("ermission") != std::string::npos;
    fail(refused ? Trouble::refused : Trouble::again,
         "the watch was canceled: " +
             (changes->compacted > 0 ? "compacted up to " + std::to_string(changes->compacted)
                                     : std::string(cut(changes->reason, wire::kMaxWords / 2))));
  } else if (changes->header.revision < revision_) {
    // Watching would wait for a revision that may never come, and report nothing.
    fail(Trouble::again,
         "the store has gone back to revision " + std::to_string(changes->header.revision));
  } else {
    watching_ = true;
    put_changes(*changes);
  }
}

void Follower::put_changes(etcd::Changes& changes) {
  auto next = changes.entries.begin();
  while (next != changes.entries.end()) {
    const std::int64_t revision = next->mod;
    const auto end = std::find_if(next, changes.entries.end(),
                                  [revision](const Entry& e) { return e.mod != revision; });
    if (revision <= revision_) {
      fail(Trouble::broken, "it repeats revision " + std::to_string(revision));
      return;
    }
    Batch batch{.revision = revision, .entries = {}};
    for (; next != end; ++next)
      if (prefixes_.has(next->key)) batch.entries.push_back(wire::bounded(std::move(*next)));
    revision_ = revision;
    if (batch.entries.size() > wire::kMaxBatch || bytes_of(batch.entries) > wire::kMaxBatchBytes) {
      fail(Trouble::again, "revision " + std::to_string(revision) + " changes too much at once");
      return;
    }
    outbox_.put(std::move(batch));
  }
  if (outbox_.fed_bytes() > kMostBytes || outbox_.fed_entries() > kMostEntries)
    fail(Trouble::again, "mlccad is too slow");
  else
    outside_.wrote();
}

void Follower::fail(Trouble trouble, const std::string& why) {
  stop();
  outside_.failed(trouble, why);
}

}  // namespace mlcca::cluster
