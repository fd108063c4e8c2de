// SPDX-License-Identifier: BSD-2-Clause
// The media whose provision is computed: response times on CAN buses and medium time on meshes.
// What a flow needs of them is reserved in the ledger hop by hop.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "core/admission/admission.hpp"
#include "core/model/verdict.hpp"
#include "core/reserve/ledger.hpp"
#include "mlcca/compose.hpp"

namespace mlcca::core {

/// The latest times, counted from publication, at which events may be at the end of a hop, as
/// required by those who receive them there.
struct Limit {
  std::size_t hop = 0;
  Value latency = kUnbounded;  ///< ns
  Value jitter = kUnbounded;   ///< ns, the jitter of the source included
};

/// The payload bytes of an event for a mesh. An event without payload counts as 1 byte, because it
/// is a packet too; 0 if the size is not stated.
[[nodiscard]] Value mesh_event(const AttributeSet& offered);
/// The payload bytes/s for which a mesh reserves time, given `demand` bytes/s: 1 byte per event if
/// events have no payload.
[[nodiscard]] Value mesh_demand(const AttributeSet& offered, Value demand);

/// Whether events enter and leave the mesh at that hop at one and the same node, so that nothing is
/// sent over it.
[[nodiscard]] bool stays_at_a_node(const Situation& situation, const Verdict& verdict,
                                   std::size_t hop);

/// Reserves what one flow needs on the buses and meshes of its route, and replaces stated
/// provisions of these hops by computed ones.
class Media {
 public:
  /// `hops` are those of the verdict's route with their stated provisions; computed values replace
  /// them. `limits` has one for each group of receiving subscribers, at least one for the last hop.
  /// The flow must have been added to the ledger on every hop.
  Media(const Situation& situation, Ledger& ledger, std::span<Hop> hops, std::vector<Limit> limits,
        Verdict& verdict);

  /// Whether the provision of any hop of the route is computed.
  [[nodiscard]] static bool any(const Situation& situation, const Ledger& ledger,
                                const Verdict& verdict);

  /// Reserves what the flow needs. If something cannot be had, it adds unfit rows or an obstacle to
  /// the verdict, and the caller must roll the ledger back.
  void take();

  /// Updates the response times of a granted verdict to those of the present schedules.
  static void renew_responses(const Situation& situation, const Ledger& ledger, Verdict& verdict);

  /// Takes the rows about free medium time, which belong behind all others in the verdict.
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
  std::vector<Value> guaranteed_;  ///< ns, per hop: promised by a bus that was reserved;
                                   ///< kUnbounded: not reserved
  std::vector<Row> medium_rows_;
};

}  // namespace mlcca::core
