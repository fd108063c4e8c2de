// SPDX-License-Identifier: BSD-2-Clause
#include "core/mesh/belief.hpp"

#include <algorithm>

namespace mlcca::core::mesh {
namespace {

/// The bit/s of payload in full packets.
Value carried(const LinkQuality& link, const Mesh& mesh) {
  const Value time = packet_time({.rate = link.rate, .kind = link.kind}, mesh, mesh.packet_bytes);
  return mul_div_down(8 * Value{mesh.packet_bytes}, kFullTime, std::max<Value>(time, 1));
}

struct Comparable {
  Value a = 0;
  Value b = 0;
};

Comparable comparable(const LinkQuality& a, const LinkQuality& b, const Mesh& mesh) {
  const bool alike = (a.kind == RateKind::phy) == (b.kind == RateKind::phy);
  if (alike) return {a.rate, b.rate};
  return {carried(a, mesh), carried(b, mesh)};
}

}  // namespace

bool FasterIsBetter::better(const LinkQuality& a, const LinkQuality& b, const Mesh& mesh) {
  const Comparable rates = comparable(a, b, mesh);
  return rates.a > rates.b;
}

bool FasterIsBetter::clearly(const LinkQuality& a, const LinkQuality& b, const Mesh& mesh) {
  const Comparable rates = comparable(a, b, mesh);
  return sub_floor(rates.a, rates.b) > mul_div_down(rates.b, mesh.tolerance, kWhole);
}

void Belief::observe(const std::optional<Observation>& seen, std::uint64_t now, const Mesh& mesh) {
  if (!seen) {
    if (seen_) lost_at_ = now;
    seen_.reset();
    return;
  }
  const LinkQuality carrier = {.rate = seen->quality.rate, .kind = seen->quality.kind};
  if (!seen_) {
    seen_.emplace(Seen{Held<LinkQuality, FasterIsBetter>(carrier),
                       Held<Value, LessIsBetter>(seen->quality.loss),
                       Held<Value, LessIsBetter>(seen->busy)});
    usable_from_ = now < held_until(mesh) ? add_saturating(now, mesh.hold_up) : now;
  }
  seen_->carrier.observe(carrier, now, mesh);
  seen_->loss.observe(seen->quality.loss, now, mesh);
  seen_->busy.observe(seen->busy, now, mesh);
  seen_->loss_known = seen->quality.loss_known;
  seen_->channel = seen->channel;
}

Link Belief::link() const {
  Link result;
  if (!seen_) return result;
  result.quality = seen_->carrier.value();
  result.quality.loss = seen_->loss.value();
  result.quality.loss_known = seen_->loss_known || result.quality.loss != 0;
  result.channel = seen_->channel;
  result.busy = seen_->busy.value();
  return result;
}

std::uint64_t Belief::deadline(std::uint64_t now, const Mesh& mesh) const {
  if (!seen_) return now < held_until(mesh) ? held_until(mesh) : kUnbounded;
  const std::uint64_t rise =
      std::min({seen_->carrier.due(mesh), seen_->loss.due(mesh), seen_->busy.due(mesh)});
  return now < usable_from_ ? std::min(rise, usable_from_) : rise;
}

}  // namespace mlcca::core::mesh
