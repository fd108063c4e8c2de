// SPDX-License-Identifier: BSD-2-Clause
#include "core/mesh/medium_time.hpp"

#include <algorithm>
#include <cstddef>

#include "mlcca/exact.hpp"

namespace mlcca::core::mesh {
namespace {

constexpr Value kPicosecondsPerNanosecond = 1000;
constexpr Value kBitsPerByte = 8;

}  // namespace

Value packet_time(const LinkQuality& link, const Mesh& mesh, Value payload_bytes) {
  if (link.rate == 0 || link.loss >= kCertainLoss) return kUnbounded;
  const bool bare = link.kind == RateKind::phy;
  const Value bytes = add_saturating(payload_bytes, bare ? mesh.header_bytes : 0);
  const Value overhead = bare ? mul_saturating(mesh.packet_time, kPicosecondsPerNanosecond) : 0;
  const Value bits = mul_saturating(bytes, kBitsPerByte);
  const Value once = add_saturating(overhead, mul_div_up(bits, kFullTime, link.rate));
  if (link.loss == 0 || once == kUnbounded) return once;
  return mul_div_up(once, kCertainLoss, kCertainLoss - link.loss);
}

Value event_time(const LinkQuality& link, const Mesh& mesh, Value event_bytes) {
  const Value full = std::max<Value>(mesh.packet_bytes, 1);
  if (event_bytes <= full) return packet_time(link, mesh, event_bytes);
  const Value rest = event_bytes % full;
  const Value packets = mul_saturating(packet_time(link, mesh, full), event_bytes / full);
  return rest == 0 ? packets : add_saturating(packets, packet_time(link, mesh, rest));
}

Value medium_time(const LinkQuality& link, const Mesh& mesh, Value bytes_per_second,
                  Value event_bytes) {
  const Value event = reckoned_event(mesh, event_bytes);
  const Value time = event_time(link, mesh, event);
  return time == kUnbounded ? kUnbounded : mul_div_up(bytes_per_second, time, event);
}

Value paper_rate(std::span<const Value> rates_bit_s) {
  if (rates_bit_s.empty()) return 0;
  detail::ReciprocalSum groups;
  for (std::size_t i = 0; i < rates_bit_s.size(); i += kMaxComposedHops) {
    detail::ReciprocalSum group;
    const auto size = std::min(rates_bit_s.size() - i, kMaxComposedHops);
    for (const Value rate : rates_bit_s.subspan(i, size)) group.add(rate);
    groups.add(group.value());
  }
  return groups.value();
}

}  // namespace mlcca::core::mesh
