// SPDX-License-Identifier: BSD-2-Clause
// What holds of every snapshot, whatever it was made of.
#pragma once
#include <cstdlib>
#include <string_view>

#include "core/mesh/bounds.hpp"
#include "daemon/net/sources/facts.hpp"

namespace mlcca::fuzz {

inline void demand(bool holds) {
  if (!holds) std::abort();
}

inline constexpr std::uint64_t kNow = 1'000'000'000'000;  // ns

/// Within the bounds nothing is out of them, and all of it arrives at mlccad.
inline void check(core::mesh::Snapshot snapshot) {
  const auto kept = core::mesh::bounded(std::move(snapshot), {"a", "10.0.0.1"}, kNow);
  demand(kept.links.size() <= core::mesh::kMaxFacts &&
         kept.next_hops.size() <= core::mesh::kMaxFacts);
  for (const auto& s : kept.links) {
    demand(core::mesh::is_address(s.from) && core::mesh::is_address(s.to));
    demand(s.rate <= core::mesh::kMaxRate && s.taken <= kNow);
    demand(s.loss.value_or(0) <= 1'000'000'000 && s.busy.value_or(0) <= core::mesh::kWhole);
    demand(s.valid.value_or(0) <= core::mesh::kMaxValidity);
  }
  net::facts::AnswerReader reader;
  std::optional<core::mesh::Snapshot> arrived;
  for (const auto& message : net::facts::answer(kept)) {
    demand(!arrived && message.size() <= net::facts::kMaxMessage);
    auto read = reader.take(message);
    demand(read.has_value());
    arrived = std::move(*read);
  }
  demand(arrived && arrived->links == kept.links && arrived->next_hops == kept.next_hops);
}

/// Cuts the input into pieces: two octets say how long one is.
class Pieces {
 public:
  explicit Pieces(std::string_view rest) : rest_(rest) {}
  [[nodiscard]] bool done() const { return rest_.size() < 2; }
  std::string_view next() {
    const auto octet = [this](std::size_t i) { return static_cast<unsigned char>(rest_[i]); };
    const std::size_t size = octet(0) * 256U + octet(1);
    rest_.remove_prefix(2);
    const auto piece = rest_.substr(0, size);
    rest_.remove_prefix(piece.size());
    return piece;
  }

 private:
  std::string_view rest_;
};

}  // namespace mlcca::fuzz
