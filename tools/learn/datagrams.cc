// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/datagrams.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "base/hash.hpp"
#include "base/many.hpp"
#include "core/gates/control_traffic.hpp"
#include "core/model/station.hpp"
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

}  // namespace

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
    ++malformed_;
    return;
  }
  ++events_;
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
    ++malformed_;
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
  constexpr std::size_t most = 8;
  std::vector<std::pair<std::uint16_t, std::uint64_t>> all(ports_.begin(), ports_.end());
  std::ranges::stable_sort(all, std::ranges::greater{}, [](const auto& one) { return one.second; });
  if (all.size() > most) all.resize(most);
  std::string out;
  std::uint64_t rest = others_;
  for (const auto& [port, count] : all) {
    out += fmt::format("{}port {} ({})", out.empty() ? "" : ", ", port, count);
    rest -= count;
  }
  return rest == 0 ? out : out + fmt::format(", others ({})", rest);
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
