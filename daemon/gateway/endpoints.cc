// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/endpoints.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <string>
#include <utility>

#include "core/gates/control_traffic.hpp"
#include "core/gates/together.hpp"
#include "core/model/medium.hpp"
#include "core/model/words.hpp"
#include "daemon/gateway/slice_budget.hpp"

namespace mlcca {
namespace {

constexpr std::size_t kTransferRow = 256;  // typical bytes on the wire

void add_once(std::vector<control::Endpoint>& to, std::optional<control::Endpoint> endpoint) {
  if (endpoint && std::ranges::find(to, *endpoint) == to.end()) to.push_back(*std::move(endpoint));
}

/// Whether the frames of both come in by the same entry of a gate and leave by the same one.
bool is_same_way(const control::Transfer& a, control::Endpoint from, control::Endpoint to) {
  from.fragmented = a.from.fragmented;
  to.fragmented = a.to.fragmented;
  from.frame_bytes = a.from.frame_bytes;
  to.frame_bytes = a.to.frame_bytes;
  return a.from == from && a.to == to;
}

}  // namespace

std::vector<core::Passage> Endpoints::passages(std::size_t channel) const {
  const core::State& state = *scene_.state;
  return core::passages(state.system(), state.members(), channel,
                        state.decisions()[channel].verdicts, scene_.self);
}

std::uint32_t Endpoints::event_bytes(const core::Passage& passage) const {
  const core::Publisher& publisher = scene_.state->members().publisher(passage.publisher);
  const AttributeSet& offered = core::attributes_in(publisher, passage.set);
  if (offered.has(Attribute::max_payload))
    return static_cast<std::uint32_t>(
        std::min<Value>(offered[Attribute::max_payload], core::kDatagramMaxEvent));
  // Not stated: what one frame holds, if events are not fragmented.
  std::uint32_t most = core::kDatagramMaxEvent;
  for (const auto& entry : {passage.in, passage.out})
    if (entry && (entry->mask != 0 || !entry->fragmented))
      most = std::min<std::uint32_t>(most, entry->max_length);
  return most;
}

const core::Network& Endpoints::network_at(std::size_t port) const {
  const core::System& system = scene_.state->system();
  return system.networks[system.gateways[scene_.self].ports[port].network];
}

std::optional<control::Endpoint> Endpoints::at_port(std::size_t port) const {
  const int ifindex = gates_.gated_interface(port);
  if (ifindex == 0) return std::nullopt;
  const core::Network& network = network_at(port);
  control::Endpoint out;
  out.network = network.name;
  out.interface = gates_.interface_name(port);
  out.ifindex = static_cast<std::uint32_t>(ifindex);
  out.can = !network.carries_subjects();
  out.broadcast = !out.can && network.kind == core::NetworkKind::udp_broadcast;
  out.wpan = !out.can && network.kind == core::NetworkKind::ieee802154;
  out.profile = core::words::kProfiles.of(network.profile);
  return out;
}

std::optional<control::Endpoint> Endpoints::endpoint(std::size_t channel,
                                                     const core::GateEntry& entry,
                                                     std::uint32_t event_bytes) const {
  auto there = at_port(entry.port);
  if (!there) return std::nullopt;
  control::Endpoint& out = *there;
  const core::Network& network = network_at(entry.port);
  out.id = entry.id;
  out.mask = entry.mask;
  out.classic = entry.classic;
  out.fd = entry.fd;
  out.frame_bytes = entry.frame_length();
  out.fragmented = entry.fragmented;
  out.address = core::to_text(entry.station);
  if (out.can)
    out.fragmented = core::is_fragmented(network, network.binding_of(channel), event_bytes);
  return there;
}

control::SubscriptionNetwork Endpoints::of_subscriptions(std::size_t port) const {
  const core::Network& network = network_at(port);
  control::SubscriptionNetwork out;
  out.network = network.name;
  out.accepts_all = network.subscriptions.accept == core::Subscribing::all;
  out.most = network.subscriptions.most;
  out.gateways_only = network.subscriptions.accept == core::Subscribing::gateways;
  const core::Port& own = scene_.state->system().gateways[scene_.self].ports[port];
  out.user = own.control_uid;
  auto there = at_port(port);
  if (!there) {
    out.problem = "the interface is not there, or has no gate";
    return out;
  }
  there->frame_bytes = core::subscription_bytes(network);
  if (there->can) {
    const auto frames = core::subscription_frames(network, own);
    if (!frames) {
      out.problem = own.node ? "the tag of SUBSCRIB is not known yet"
                             : "the Port states no node: subscriptions need a sender";
      return out;
    }
    there->id = frames->id;
    there->mask = frames->mask;
    there->classic = true;
    there->fragmented = true;
    there->frame_bytes = core::kClassicBytes;
  }
  out.endpoint = *std::move(there);
  return out;
}

std::vector<control::Endpoint> Endpoints::of_publisher(std::size_t channel,
                                                       std::size_t publisher) const {
  std::vector<control::Endpoint> out;
  for (const core::Passage& passage : passages(channel)) {
    if (passage.publisher != publisher || passage.in) continue;
    if (passage.out) {
      add_once(out, endpoint(channel, *passage.out, event_bytes(passage)));
      continue;
    }
    for (auto& [user, address] :
         local_ends_.all(scene_.state->system().channels[channel].subject)) {
      control::Endpoint here;
      here.local = std::move(address);
      here.local_user = user;
      here.frame_bytes = event_bytes(passage);
      add_once(out, std::move(here));
    }
  }
  return out;
}

/// Sums up the programs of each user. The kernel cannot distinguish programs of one user, as a gate
/// cannot distinguish publishers that share an entry.
class Endpoints::FromPrograms {
 public:
  void add(const core::Publisher& publisher, std::size_t set, std::uint32_t bytes, Value silence) {
    if (!publisher.uid) return;
    const AttributeSet& offered = core::attributes_in(publisher, set);
    const core::Policing policing = core::policing_of(offered, 1, bytes);
    const core::Watching watching{offered[Attribute::period], silence, 0};
    const auto [at, fresh] =
        by_user_.try_emplace(*publisher.uid, One{publisher.name, bytes, policing, watching});
    One& one = at->second;
    if (fresh || one.publisher == publisher.name) return;
    one.publisher.clear();
    one.bytes = std::max(one.bytes, bytes);
    one.policing = core::together(one.policing, policing, one.bytes);
    one.watching = core::together(one.watching, watching);
  }
  void add_to(std::vector<control::Endpoint>& to) const {
    for (const auto& [user, one] : by_user_) {
      control::Endpoint here;
      here.user = user;
      here.publisher = one.publisher;
      here.frame_bytes = one.bytes;
      here.period_ns = one.watching.period;
      here.silence_ns = one.watching.silence;
      here.event_cost_ns = one.policing.per_frame;
      here.byte_cost = one.policing.per_byte;
      here.tolerance_ns = one.policing.tolerance;
      to.push_back(std::move(here));
    }
  }

 private:
  struct One {
    std::string publisher;
    std::uint32_t bytes = 0;
    core::Policing policing;
    core::Watching watching;
  };
  std::map<uid_t, One> by_user_;
};

std::vector<control::Endpoint> Endpoints::of_subscriber(std::size_t channel,
                                                        std::size_t subscriber) const {
  const core::State& state = *scene_.state;
  std::map<std::size_t, Value> silences;  // by publisher
  for (const core::Verdict& v : state.decisions()[channel].verdicts)
    if (std::ranges::find(v.subscribers, subscriber) != v.subscribers.end())
      silences[v.publisher] = core::silence_here(v);
  std::vector<control::Endpoint> out;
  FromPrograms from_programs;
  for (const core::Passage& passage : passages(channel)) {
    if (passage.out) continue;
    if (passage.in)
      add_once(out, endpoint(channel, *passage.in, event_bytes(passage)));
    else
      from_programs.add(state.members().publisher(passage.publisher), passage.set,
                        event_bytes(passage), silences[passage.publisher]);
  }
  from_programs.add_to(out);
  return out;
}

void Endpoints::add_transfers(std::size_t channel, std::optional<std::uint32_t> user,
                              control::Transfers& to) const {
  const core::State& state = *scene_.state;
  const std::size_t before = to.transfers.size();
  for (const core::Passage& passage : passages(channel)) {
    if (!passage.in || !passage.out || passage.by_kernel) continue;
    if (user && passage.out->uid != *user) continue;
    const std::uint32_t bytes = event_bytes(passage);
    auto from = endpoint(channel, *passage.in, bytes);
    auto into = endpoint(channel, *passage.out, bytes);
    if (!from || !into) continue;
    // Publishers whose frames cannot be distinguished come in and leave together.
    const auto same = std::find_if(
        to.transfers.begin() + static_cast<std::ptrdiff_t>(before), to.transfers.end(),
        [&](const control::Transfer& other) { return is_same_way(other, *from, *into); });
    if (same != to.transfers.end()) {
      same->event_bytes = std::max(same->event_bytes, bytes);
      same->from.fragmented |= from->fragmented;
      same->to.fragmented |= into->fragmented;
      continue;
    }
    const core::Publisher& publisher = state.members().publisher(passage.publisher);
    to.transfers.push_back(
        {.subject = state.system().channels[channel].subject,
         .channel = state.system().channels[channel].name,
         .publisher = publisher.name,
         .from = *std::move(from),
         .to = *std::move(into),
         .event_bytes = bytes,
         .period_ns = core::attributes_in(publisher, passage.set)[Attribute::period],
         .user = passage.out->uid,
         .latency_ns = state.system().gateways[scene_.self].provision[Attribute::latency]});
  }
}

void Endpoints::add_to(control::Routes& to) const {
  control::Transfers all;
  for (std::size_t channel = 0; channel < scene_.state->decisions().size(); ++channel) {
    add_transfers(channel, {}, all);
    const std::size_t room = control::Routes::kMostTransfers - to.transfers.size();
    const std::size_t taken = std::min(room, all.transfers.size());
    std::move(all.transfers.begin(), all.transfers.begin() + static_cast<std::ptrdiff_t>(taken),
              std::back_inserter(to.transfers));
    to.transfers_left_out += static_cast<std::uint32_t>(all.transfers.size() - taken);
    all.transfers.clear();
  }
}

serve::Slice Endpoints::some_transfers(std::size_t& at, std::optional<std::uint32_t> user) const {
  control::Transfers out;
  const std::size_t channels = scene_.state->decisions().size();
  SliceBudget budget(kTransferRow);
  for (bool goes_on = true; goes_on && at < channels; ++at) {
    const std::size_t before = out.transfers.size();
    add_transfers(at, user, out);
    goes_on = budget.made(std::max<std::size_t>(1, out.transfers.size() - before));
  }
  return {{std::move(out)}, at < channels};
}

}  // namespace mlcca
