// SPDX-License-Identifier: BSD-2-Clause
// The media whose provision is computed and not only stated: response times on CAN buses, medium
// time on meshes. Takes what one flow needs of them from the ledger, hop by hop.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "core/admission/admission.hpp"
#include "core/model/verdict.hpp"
#include "core/reserve/ledger.hpp"
#include "mlcca/compose.hpp"

namespace mlcca::core {

/// How late events may be at the end of a hop, counted from their publication, for those who
/// receive them there.
struct Limit {
  std::size_t hop = 0;
  Value latency = kUnbounded;  ///< ns
  Value jitter = kUnbounded;   ///< ns, the source's included
};

/// Payload bytes of an event as a mesh carries it: one without payload is a packet all the same,
/// and of one whose size is not stated nothing is known: 0.
[[nodiscard]] Value mesh_event(const AttributeSet& offered);
/// Payload bytes/s that a mesh carries for `demand`: of events without payload, a byte each.
[[nodiscard]] Value mesh_demand(const AttributeSet& offered, Value demand);

/// Events come to a mesh, that hop of the route, and leave it or are received at one node: nothing
/// is sent over it.
[[nodiscard]] bool stays_at_a_node(const Situation& situation, const Verdict& verdict,
                                   std::size_t hop);

class Media {
 public:
  /// `hops`: what the hops of the verdict's route state; what is computed is put in its place.
  /// `limits` are of every subscriber that receives the events, at least one for the last hop.
  Media(const Situation& situation, Ledger& ledger, std::span<Hop> hops, std::vector<Limit> limits,
        Verdict& verdict);

  /// True if any hop of the verdict's route is computed.
  [[nodiscard]] static bool any(const Situation& situation, const Ledger& ledger,
                                const Verdict& verdict);

  /// Reserves what the flow needs, and adds rows for what cannot be had; the ledger is to be rolled
  /// back then. The flow has been added on every hop.
  void take();

  /// Puts the response times of the schedules as they are now in the place of those that they were
  /// when the granted verdict was decided.
  static void renew_responses(const Situation& situation, const Ledger& ledger, Verdict& verdict);

  /// What is left of the time of meshes: rows that stand behind the others.
  [[nodiscard]] std::vector<Row> take_medium_rows() { return std::move(medium_rows_); }

 private:
  enum class Kind : std::uint8_t { stated, bus, mesh };

  [[nodiscard]] Kind kind_of(std::size_t hop) const;
  void obstruct(Obstacle obstacle, std::size_t hop);
  void take_bus(std::size_t hop);
  void leave_out_own_load(std::size_t network);
  struct Crossing;
  void no_path(const Crossing& c, std::size_t hop);
  [[nodiscard]] bool is_relayed(const Crossing& c, std::span<const std::uint32_t> path);
  void take_mesh(std::size_t hop);
  bool take_paths(Crossing& c, std::size_t hop);
  bool take_path(Crossing& c, std::uint32_t from, std::uint32_t to);
  [[nodiscard]] std::vector<std::uint32_t> new_links(const Crossing& c,
                                                     std::span<const std::uint32_t> path) const;
  void compare_medium_time(const Crossing& crossing, std::size_t hop);
  void late_row(Place hop, const can::Schedule::Late& late);
  [[nodiscard]] Value delay_allowed(std::size_t hop) const;
  [[nodiscard]] Value most_handed_on(std::size_t hop, const can::Message& message) const;
  [[nodiscard]] Value bit_time(std::size_t hop) const;
  [[nodiscard]] Value promised_delay(std::size_t hop) const;
  [[nodiscard]] Value variation_before(std::size_t hop) const;
  [[nodiscard]] Value latency_of(std::size_t hop) const;
  [[nodiscard]] Value variation_of(std::size_t hop) const;
  [[nodiscard]] std::uint32_t sender_queue(std::size_t hop) const;
  [[nodiscard]] Value pauses_at(std::size_t hop) const;
  void name_sender(std::size_t hop, const Publisher& publisher, can::Message& message) const;

  const Situation& s_;
  Ledger& ledger_;
  std::span<const Place> places_;
  std::span<Hop> hops_;
  std::vector<Limit> limits_;
  Verdict& v_;
  std::vector<Value> guaranteed_;  ///< ns, of the buses that were taken; kUnbounded: not taken
  std::vector<Row> medium_rows_;
};

}  // namespace mlcca::core
