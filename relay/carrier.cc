// SPDX-License-Identifier: BSD-2-Clause
#include "relay/carrier.hpp"

#include <algorithm>
#include <set>
#include <utility>

namespace mlcca::relay {
namespace {

/// Frames received from one interface before it is the turn of another.
constexpr std::size_t kMostOfTurn = 64;

}  // namespace

// --- what there is to carry ----------------------------------------------------------------------

Layer* Carrier::layer_of(const control::Endpoint& endpoint) {
  const auto known = layers_.find(endpoint.ifindex);
  if (known != layers_.end()) {
    if (known->second.serves(endpoint)) return known->second.layer.get();
    close(endpoint.ifindex);  // ends its transfers as well, which the daemon is asked for again
  }
  auto layer = outside_.open(endpoint);
  if (!layer) {
    note_problem(endpoint.interface, endpoint.interface + " cannot be used: " + layer.error().text);
    return nullptr;
  }
  if (problems_.erase(endpoint.interface) != 0)
    outside_.log(endpoint.interface + " can be used again");
  outside_.watch(endpoint.ifindex, (*layer)->fd());
  return layers_.emplace(endpoint.ifindex, OpenedLayer{form_of_layer(endpoint), std::move(*layer)})
      .first->second.layer.get();
}

void Carrier::note_problem(const std::string& of, const std::string& text) {
  std::string& known = problems_[of];
  if (known == text) return;
  known = text;
  outside_.log(text);
}

bool Carrier::add(const control::Transfer& transfer) {
  if (transfer.from.ifindex == transfer.to.ifindex) return true;  // an event would return endlessly
  Layer* const from = layer_of(transfer.from);
  Layer* const to = layer_of(transfer.to);
  return from != nullptr && to != nullptr && start(transfer, *from, *to);
}

bool Carrier::start(const control::Transfer& transfer, Layer& from, Layer& to) {
  std::size_t number = slots_.size();
  if (free_.empty()) {
    slots_.emplace_back();
  } else {
    number = free_.back();
    free_.pop_back();
  }
  const auto done = from.follow(static_cast<Layer::Follower>(number), transfer.from,
                                transfer.subject, transfer.event_bytes);
  const std::string way = transfer.channel + " is not carried from " + transfer.from.interface +
                          " to " + transfer.to.interface;
  if (!done) {
    free_.push_back(number);
    note_problem(way, way + ": " + done.error().text);
    return false;
  }
  problems_.erase(way);
  slots_[number] = Slot{.transfer = transfer, .carried = {}, .to = &to, .delay = {}};
  by_subject_[transfer.subject].push_back(number);
  if (transfer.latency_ns != 0) latencies_.insert(transfer.latency_ns);
  return true;
}

void Carrier::retry() {
  for (const control::Transfer& transfer : std::exchange(waiting_, {}))
    if (!add(transfer)) waiting_.push_back(transfer);
}

void Carrier::remove(std::size_t number) {
  const control::Transfer& transfer = slots_[number]->transfer;
  if (const auto from = layers_.find(transfer.from.ifindex); from != layers_.end())
    from->second.layer->leave(static_cast<Layer::Follower>(number), transfer.from,
                              transfer.subject);
  const auto known = by_subject_.find(transfer.subject);
  std::erase(known->second, number);
  if (known->second.empty()) by_subject_.erase(known);
  if (const auto latency = latencies_.find(transfer.latency_ns); latency != latencies_.end())
    latencies_.erase(latency);
  slots_[number].reset();
  free_.push_back(number);
}

void Carrier::set(std::uint64_t subject, const std::vector<control::Transfer>& transfers) {
  exchange(subject, transfers);
  close_unused();
}

void Carrier::exchange(std::uint64_t subject, const std::vector<control::Transfer>& transfers) {
  std::vector<const control::Transfer*> fresh;
  fresh.reserve(transfers.size());
  for (const control::Transfer& transfer : transfers) fresh.push_back(&transfer);
  const auto known = by_subject_.find(subject);
  const auto before = known == by_subject_.end() ? std::vector<std::size_t>{} : known->second;
  for (const std::size_t number : before) {
    const auto same = std::ranges::find_if(
        fresh, [&](const auto* transfer) { return *transfer == slots_[number]->transfer; });
    if (same == fresh.end())
      remove(number);
    else
      fresh.erase(same);
  }
  std::erase_if(waiting_, [&](const auto& transfer) { return transfer.subject == subject; });
  for (const control::Transfer* transfer : fresh)
    if (!add(*transfer)) waiting_.push_back(*transfer);
  if (waiting_.empty()) problems_.clear();
}

void Carrier::set_all(const std::vector<control::Transfer>& transfers) {
  std::unordered_map<std::uint64_t, std::vector<control::Transfer>> by_subject;
  for (const auto& [subject, numbers] : by_subject_) by_subject[subject];
  for (const control::Transfer& transfer : waiting_) by_subject[transfer.subject];
  for (const control::Transfer& transfer : transfers)
    by_subject[transfer.subject].push_back(transfer);
  for (const auto& [subject, some] : by_subject) exchange(subject, some);
  close_unused();
}

// --- events --------------------------------------------------------------------------------------

void Carrier::receive(std::uint32_t ifindex) {
  const auto known = layers_.find(ifindex);
  if (known == layers_.end()) return;
  const bool there = known->second.layer->receive(
      kMostOfTurn, [this](const Layer::Arrival& arrival) { carry(arrival); });
  if (!there) close(ifindex);
}

void Carrier::expire() {
  for (const auto& [ifindex, one] : layers_)
    if (one.layer->holds_parts()) one.layer->expire();
}

void Carrier::carry(const Layer::Arrival& arrival) {
  Slot& slot = *slots_[arrival.follower];
  const Sent sent = slot.to->send(slot.transfer.to, slot.transfer.subject, arrival.event);
  ++slot.carried.events;
  if (sent != Sent::sent) ++slot.carried.dropped;
  if (arrival.unix_ns == 0) return;
  const std::uint64_t now = outside_.unix_ns();
  const std::uint64_t took = now > arrival.unix_ns ? now - arrival.unix_ns : 0;
  slot.carried.longest_ns = std::max(slot.carried.longest_ns, took);
  if (slot.transfer.latency_ns == 0 || took <= slot.transfer.latency_ns) return;
  ++slot.carried.late;
  ++slot.delay.late;
  slot.delay.longest_ns = std::max(slot.delay.longest_ns, took);
}

void Carrier::take_delays(
    std::uint64_t now, std::uint64_t pause,
    const std::function<void(const control::Transfer&, const Delay&)>& handler) {
  for (auto& slot : slots_) {
    if (!slot || slot->delay.late == 0) continue;
    if (slot->taken_at && now - *slot->taken_at < pause) continue;
    slot->taken_at = now;
    handler(slot->transfer, std::exchange(slot->delay, {}));
  }
}

void Carrier::each(
    const std::function<void(const control::Transfer&, const Carried&)>& handler) const {
  for (const auto& slot : slots_)
    if (slot) handler(slot->transfer, slot->carried);
}

Losses Carrier::losses() const {
  Losses all;
  for (const auto& [ifindex, one] : layers_) {
    const Losses some = one.layer->losses();
    all.malformed += some.malformed;
    all.incomplete += some.incomplete;
    all.crowded += some.crowded;
    all.too_long += some.too_long;
    all.in_socket += some.in_socket;
    all.unsent += some.unsent;
  }
  return all;
}

// --- interfaces ----------------------------------------------------------------------------------

/// Closes the layer of an interface that is gone, and ends its transfers until the daemon states
/// them again.
void Carrier::close(std::uint32_t ifindex) {
  for (std::size_t number = 0; number < slots_.size(); ++number)
    if (slots_[number] && (slots_[number]->transfer.from.ifindex == ifindex ||
                           slots_[number]->transfer.to.ifindex == ifindex))
      remove(number);
  outside_.watch(ifindex, -1);
  layers_.erase(ifindex);
}

void Carrier::close_unused() {
  std::set<std::uint32_t> used;
  for (const auto& slot : slots_)
    if (slot) used.insert({slot->transfer.from.ifindex, slot->transfer.to.ifindex});
  for (auto it = layers_.begin(); it != layers_.end();) {
    if (used.contains(it->first)) {
      ++it;
      continue;
    }
    outside_.watch(it->first, -1);
    it = layers_.erase(it);
  }
}

}  // namespace mlcca::relay
