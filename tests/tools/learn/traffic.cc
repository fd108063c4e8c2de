// SPDX-License-Identifier: BSD-2-Clause
#include "tests/tools/learn/traffic.hpp"

#include <algorithm>
#include <iterator>

#include "relay/layers/datagram.hpp"

namespace mlcca::learn::test {
namespace {

void put_number(std::vector<std::uint8_t>& to, std::uint64_t number, unsigned bytes) {
  while (bytes-- > 0) to.push_back(static_cast<std::uint8_t>(number >> 8 * bytes));
}

}  // namespace

Sent event(std::uint64_t ns, std::uint32_t interface, std::uint64_t subject, std::uint32_t sender,
           const std::vector<std::uint8_t>& data, bool is_fragment) {
  Sent out;
  out.ns = ns;
  out.interface = interface;
  const auto header = relay::datagram_header(subject, is_fragment);
  out.data.assign(header.begin(), header.end());
  out.data.insert(out.data.end(), data.begin(), data.end());
  Datagram& datagram = out.datagram.emplace();
  datagram.source = sender;
  datagram.destination = relay::group_of(subject);
  datagram.source_port = datagram.port = relay::kEventPort;
  datagram.bytes = static_cast<std::uint32_t>(out.data.size());
  datagram.mac = {2, 0, 0x5e, 0, 0, static_cast<std::uint8_t>(sender)};
  return out;
}

std::vector<std::uint8_t> packet_of(const Sent& datagram) {
  constexpr unsigned headers = 28;
  const Datagram& d = *datagram.datagram;
  std::vector<std::uint8_t> out = {0x45, 0};
  put_number(out, headers + datagram.data.size(), 2);
  put_number(out, 0, 4);
  put_number(out, 1U << 8U | 17U, 2);  // TTL 1, UDP
  put_number(out, 0, 2);
  put_number(out, d.source, 4);
  put_number(out, d.destination, 4);
  put_number(out, d.source_port, 2);
  put_number(out, d.port, 2);
  put_number(out, 8 + datagram.data.size(), 2);
  put_number(out, 0, 2);
  out.insert(out.end(), datagram.data.begin(), datagram.data.end());
  return out;
}

std::vector<std::uint8_t> frame_of(const Sent& datagram, unsigned tags) {
  const Datagram& d = *datagram.datagram;
  std::vector<std::uint8_t> out = {1, 0, 0x5e};
  put_number(out, d.destination & 0x7fffffU, 3);
  out.insert(out.end(), d.mac.begin(), d.mac.end());
  for (unsigned i = 0; i < tags; ++i) put_number(out, i == 0 ? 0x88a80005 : 0x81000007, 4);
  put_number(out, 0x0800, 2);
  const auto packet = packet_of(datagram);
  out.insert(out.end(), packet.begin(), packet.end());
  return out;
}

Traffic& Traffic::periodic(std::uint32_t interface, std::uint32_t id, std::uint64_t period,
                           std::uint64_t jitter, std::size_t bytes, std::uint64_t seconds,
                           unsigned lost) {
  const std::uint64_t begin = kSecond + below(period);
  for (std::uint64_t t = begin; t < (seconds + 1) * kSecond; t += period) {
    std::vector<std::uint8_t> data(bytes);
    for (auto& byte : data) byte = ++counter_;
    if (lost != 0 && below(lost) == 0) continue;
    all_.push_back({t + (jitter == 0 ? 0 : below(jitter)), interface, id, std::move(data)});
  }
  return *this;
}

Traffic& Traffic::bursts(std::uint32_t interface, std::uint32_t id, unsigned most,
                         std::uint64_t apart, std::uint64_t pause, std::uint64_t seconds) {
  for (std::uint64_t t = kSecond; t < (seconds + 1) * kSecond; t += pause / 2 + below(pause)) {
    const auto count = 1 + below(most);
    for (std::uint64_t i = 0; i < count; ++i)
      all_.push_back({t + i * apart, interface, id, {++counter_, 1}});
  }
  return *this;
}

Traffic& Traffic::events(std::uint32_t interface, std::uint64_t subject, std::uint32_t sender,
                         std::uint64_t period, std::uint64_t jitter, std::size_t bytes,
                         std::uint64_t seconds, unsigned lost) {
  const auto before = all_.size();
  periodic(interface, 0, period, jitter, bytes, seconds, lost);
  for (auto i = before; i < all_.size(); ++i)
    all_[i] = event(all_[i].ns, interface, subject, sender, all_[i].data);
  return *this;
}

/// 0.2 to 0.6 ms later.
void Traffic::put(std::vector<Sent> copies) {
  for (Sent& one : copies) {
    one.ns += kMs / 5 + below(2 * kMs / 5);
    all_.push_back(std::move(one));
  }
}

Traffic& Traffic::to_ethernet(std::uint32_t from, std::uint32_t id, std::uint32_t to,
                              std::uint64_t subject) {
  std::vector<Sent> copies;
  for (const Sent& one : all_) {
    if (one.datagram || one.interface != from || one.id != id) continue;
    copies.push_back(event(one.ns, to, subject, station(1), one.data));
    copies.back().local = true;
  }
  put(std::move(copies));
  return *this;
}

Traffic& Traffic::to_bus(std::uint32_t from, std::uint64_t subject, std::uint32_t sender,
                         std::uint32_t to, std::uint32_t id) {
  std::vector<Sent> copies;
  const auto header = relay::datagram_header(subject, false);
  for (const Sent& one : all_)
    if (one.datagram && one.interface == from && one.datagram->source == sender &&
        std::equal(header.begin(), header.end(), one.data.begin()))
      copies.push_back({one.ns, to, id, {one.data.begin() + header.size(), one.data.end()}});
  put(std::move(copies));
  return *this;
}

Traffic& Traffic::forwarded(std::uint32_t from, std::uint32_t id, std::uint32_t to) {
  std::vector<Sent> copies;
  for (const Sent& one : all_)
    if (one.interface == from && one.id == id) copies.push_back(one);
  for (Sent& one : copies) one.interface = to;
  put(std::move(copies));
  return *this;
}

std::vector<Sent> Traffic::sent() const {
  std::vector<Sent> out = all_;
  std::ranges::stable_sort(out, {}, &Sent::ns);
  return out;
}

}  // namespace mlcca::learn::test
