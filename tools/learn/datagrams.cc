// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/datagrams.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "base/hash.hpp"
#include "base/many.hpp"
#include "core/gates/control_traffic.hpp"
#include "core/model/station.hpp"
#include "core/model/words.hpp"
#include "relay/layers/datagram.hpp"

namespace mlcca::learn {
namespace {

/// "ManChan!": announcements and reservations of FAMOUSO's management layer.
constexpr std::uint64_t kManagement = 0x4d616e4368616e21;
/// The largest header of a fragment before its data, with the number of its event.
constexpr std::size_t kFragmentHeader = 7;

/// Whether a description can state the address.
bool is_station(std::uint32_t address) {
  return core::station_of(core::to_text(core::Station{address})).has_value();
}

/// Combines subject and sender into one number.
std::uint64_t source_of(std::uint64_t subject, std::uint32_t sender) {
  std::uint64_t hash = kHashOfNothing;
  for (unsigned shift = 0; shift < 64; shift += 8)
    hash = hash_with(hash, static_cast<std::uint8_t>(subject >> shift & 0xffU));
  for (unsigned shift = 0; shift < 32; shift += 8)
    hash = hash_with(hash, static_cast<std::uint8_t>(sender >> shift & 0xffU));
  return hash;
}

/// The entries with most counts in words, and what remains of `all`.
template <class Counts, class Entry, class Rest>
std::string listed(const Counts& counts, std::uint64_t all, Entry entry, Rest rest_of) {
  constexpr std::size_t most = 8;
  std::vector<std::pair<typename Counts::key_type, std::uint64_t>> sorted(counts.begin(),
                                                                          counts.end());
  std::ranges::stable_sort(sorted, std::ranges::greater{},
                           [](const auto& one) { return one.second; });
  if (sorted.size() > most) sorted.resize(most);
  std::vector<std::string> out;
  for (const auto& [key, count] : sorted) {
    out.push_back(entry(key, count));
    all -= count;
  }
  if (all != 0) out.push_back(rest_of(all));
  return fmt::format("{}", fmt::join(out, ", "));
}

}  // namespace

std::string transport_word(bool is_broadcast) {
  using core::NetworkKind;
  return fmt::format("{} (port {})",
                     core::words::kNetworkKinds.of(is_broadcast ? NetworkKind::udp_broadcast
                                                                : NetworkKind::udp_multicast),
                     is_broadcast ? relay::kBroadcastPort : relay::kEventPort);
}

void Datagrams::take(const Frame& frame, const Decoder::OnEvent& on_event) {
  const Datagram& datagram = *frame.datagram;
  if (datagram.port != relay::kEventPort && datagram.port != relay::kBroadcastPort) {
    count_other(datagram);
    return;
  }
  const auto parsed = relay::parse_datagram(frame.data);
  const std::size_t bytes =
      datagram.bytes - std::min<std::size_t>(datagram.bytes, relay::kDatagramHeader);
  if (!parsed || parsed->subject == 0 || bytes > relay::afp::kUdp.payload ||
      (!frame.local && !is_station(datagram.source))) {
    count_malformed(frame);
    return;
  }
  ++events_;
  const bool broadcast = datagram.port == relay::kBroadcastPort;
  ++(broadcast ? transports_.broadcast : transports_.multicast);
  if (datagram.destination == relay::group_of(parsed->subject)) ++grouped_;
  if (parsed->subject == core::kSubscribeSubject || parsed->subject == kManagement) {
    ++control_;
    if (parsed->subject == kManagement) ++management_;
    return;
  }
  Event event;
  event.ns = frame.ns;
  event.number = parsed->subject;
  event.node = frame.local ? 0 : datagram.source;
  event.local = frame.local;
  event.mac = datagram.mac;
  event.broadcast = broadcast;
  event.bytes = event.frame_bytes = static_cast<std::uint32_t>(bytes);
  event.head = parsed->data.first(std::min({parsed->data.size(), bytes, kHead}));
  if (parsed->is_fragment)
    take_fragment(frame, event, parsed->data, on_event);
  else
    on_event(event);
}

void Datagrams::take_fragment(const Frame& frame, Event event, std::span<const std::uint8_t> data,
                              const Decoder::OnEvent& on_event) {
  const std::size_t bytes = event.bytes;
  if (data.size() < std::min(bytes, kFragmentHeader)) {
    count_malformed(frame);
    return;
  }
  // Only sizes and the beginning matter, so bytes that were truncated, or come in later IP
  // fragments, may have any value.
  is_cut_ = is_cut_ || data.size() < std::min(bytes, kFragmentHeader + kHead);
  fragment_.assign(bytes, 0);
  std::ranges::copy(data.first(std::min(data.size(), bytes)), fragment_.begin());
  now_ = std::max(now_, frame.ns);
  const auto source = source_of(event.number, frame.datagram->source);
  const auto whole = fragments_.take(source, fragment_, now_);
  if (!whole) return;
  event.bytes = static_cast<std::uint32_t>(whole->size());
  event.head = std::span(*whole).first(is_cut_ ? 0 : std::min(whole->size(), kHead));
  on_event(event);
}

void Datagrams::count_malformed(const Frame& frame) {
  ++malformed_;
  const std::string sender =
      frame.local ? "this host" : core::to_text(core::Station{frame.datagram->source});
  if (malformed_from_.size() < kMostSenders || malformed_from_.contains(sender))
    ++malformed_from_[sender];
}

/// Counts the smaller port: of a request and its answer it is mostly the port of the service.
void Datagrams::count_other(const Datagram& datagram) {
  ++others_;
  const std::uint16_t port = std::min(datagram.port, datagram.source_port);
  if (ports_.size() < kMostPorts || ports_.contains(port)) ++ports_[port];
}

std::uint64_t Datagrams::incomplete() const {
  const auto& losses = fragments_.losses();
  return losses.incomplete + losses.crowded + losses.malformed;
}

std::string Datagrams::other_ports() const {
  return listed(
      ports_, others_,
      [](auto port, auto count) { return fmt::format("port {} ({})", port, count); },
      [](auto rest) { return fmt::format("others ({})", rest); });
}

std::string Datagrams::malformed_senders() const {
  return listed(
      malformed_from_, malformed_,
      [](const auto& sender, auto count) { return fmt::format("{} from {}", count, sender); },
      [](auto rest) { return fmt::format("{} from others", rest); });
}

std::vector<std::string> Datagrams::notes(const std::string& name) const {
  std::vector<std::string> out;
  if (others_ != 0)
    out.push_back(fmt::format("{}: {} {} of other traffic, which needs no channel: {}", name,
                              others_, word_for(others_, Medium::ethernet), other_ports()));
  if (malformed_ != 0)
    out.push_back(
        fmt::format("{}: {} to FAMOUSO's ports that {}: {}", name, many(malformed_, "datagram"),
                    malformed_ == 1 ? "is no event" : "are no events", malformed_senders()));
  if (incomplete() != 0)
    out.push_back(
        fmt::format("{}: {} of which a fragment was not seen", name, many(incomplete(), "event")));
  if (management_ != 0)
    out.push_back(
        fmt::format("{}: {} of the subject ManChan!, which a gate drops unless you "
                    "describe a channel for it",
                    name, many(management_, "event")));
  return out;
}

Recognised Datagrams::recognised() const {
  using core::Profile;
  constexpr unsigned silent = 90;         // certainty if nothing contradicts the profile
  constexpr unsigned without_group = 70;  // certainty without multicast groups: anything may be
                                          // broadcast
  constexpr unsigned most = 99;
  const std::uint64_t all = events_ + malformed_;
  if (all == 0)
    return {Profile::none, silent, "no datagram went to FAMOUSO's ports, 9999 and 8888"};
  const auto share = static_cast<unsigned>(events_ * 100 / all);
  if (share < 50)
    return {Profile::none, std::min(100 - share, most),
            fmt::format("{} % of {} to FAMOUSO's ports are events", share, many(all, "datagram"))};
  if (grouped_ == 0)
    return {Profile::famouso, std::min(share, without_group),
            fmt::format("{} % of {} to ports 9999 and 8888 are events, but none went to the "
                        "multicast group of its subject",
                        share, many(all, "datagram"))};
  return {Profile::famouso, std::min(share, most),
          fmt::format("{} % of {} to ports 9999 and 8888 are events, {} of them to the "
                      "multicast group of their subject",
                      share, many(all, "datagram"), grouped_)};
}

}  // namespace mlcca::learn
