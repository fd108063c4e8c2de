// SPDX-License-Identifier: BSD-2-Clause
#include "cluster/outbox.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace mlcca::cluster {
namespace {

using core::cluster::Batch;
using core::cluster::TxnResult;

std::size_t bytes_of(const Batch& batch, std::size_t from, std::size_t to) {
  std::size_t bytes = 0;
  for (; from < to; ++from)
    bytes += batch.entries[from].key.size() + batch.entries[from].value.size();
  return bytes;
}

}  // namespace

void Outbox::put(const TxnResult& result) {
  for (auto& message : wire::messages_of(result)) results_.push_back(std::move(message));
}

void Outbox::begin(std::int64_t revision) {
  forget_feed();
  feed_.emplace_back(ClusterSnapshot{revision});
}

void Outbox::put(Batch batch) {
  // A batch without entries only states up to which revision everything is known; the latest
  // suffices.
  if (batch.entries.empty() && !feed_.empty())
    if (auto* last = std::get_if<Part>(&feed_.back());
        last != nullptr && last->batch.entries.empty())
      feed_.pop_back();
  put_part({.batch = std::move(batch)});
}

void Outbox::put_page(Batch batch) {
  if (!batch.entries.empty()) put_part({.batch = std::move(batch), .of_snapshot = true});
}

void Outbox::put_part(Part part) {
  fed_bytes_ += bytes_of(part.batch, 0, part.batch.entries.size());
  fed_entries_ += part.batch.entries.size();
  feed_.emplace_back(std::move(part));
}

void Outbox::synced(std::int64_t revision) { feed_.emplace_back(ClusterSynced{revision}); }

void Outbox::forget_feed() {
  feed_.clear();
  fed_bytes_ = fed_entries_ = 0;
}

void Outbox::add_credit(std::uint32_t entries) {
  constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
  credit_ = std::min(credit_ + entries, most);
}

const wire::Message* Outbox::next() {
  if (!next_) next_ = make();
  return next_ ? &*next_ : nullptr;
}

std::optional<wire::Message> Outbox::make() {
  if (state_) return wire::message_of(*std::exchange(state_, std::nullopt));
  if (!results_.empty()) {
    auto message = std::move(results_.front());
    results_.pop_front();
    return message;
  }
  return make_fed();
}

std::optional<wire::Message> Outbox::make_fed() {
  if (feed_.empty()) return std::nullopt;
  auto* const part = std::get_if<Part>(&feed_.front());
  if (part == nullptr) {
    auto message = std::holds_alternative<ClusterSnapshot>(feed_.front())
                       ? wire::message_of(std::get<ClusterSnapshot>(feed_.front()))
                       : wire::message_of(std::get<ClusterSynced>(feed_.front()));
    feed_.pop_front();
    return message;
  }
  if (credit_ == 0 && !part->batch.entries.empty()) return std::nullopt;
  const std::size_t before = part->next;
  const auto most = static_cast<std::size_t>(credit_);
  auto message = part->of_snapshot ? wire::page_of(part->batch, part->next, most)
                                   : wire::message_of(part->batch, part->next, most, false);
  const std::size_t sent = part->next - before;
  credit_ -= sent;
  fed_entries_ -= sent;
  fed_bytes_ -= bytes_of(part->batch, before, part->next);
  if (part->next == part->batch.entries.size()) feed_.pop_front();
  return message;
}

}  // namespace mlcca::cluster
