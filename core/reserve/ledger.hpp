// SPDX-License-Identifier: BSD-2-Clause
// What has been promised, of every resource that a route touches: bytes/s of networks and gateways,
// the schedule of each CAN bus, the time of each domain of a mesh. Changed in place and taken back
// exactly: integers, and schedules that are kept as they were (ADR 14).
#pragma once
#include <compare>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "core/can/schedule.hpp"
#include "core/mesh/evaluation.hpp"
#include "core/model/system.hpp"

namespace mlcca::core {

/// The traffic of one publisher on one resource (a network or gateway, see System::resource_of). It
/// is carried once, however many subscribers are behind it, but once more for each way in.
struct Flow {
  std::size_t publisher = 0;
  std::size_t resource = 0;
  std::size_t from = kOwn;  ///< the resource that it comes from; kOwn: the publisher itself

  static constexpr std::size_t kOwn = 0xffffffff;
  auto operator<=>(const Flow&) const = default;
};

/// What a flow takes of a mesh.
struct MeshHolding {
  std::vector<std::uint32_t> links;  ///< of the graph at that time
  std::vector<mesh::Share> shares;   ///< each domain once
};

/// A flow in the ledger.
struct Holding {
  std::uint32_t resource = 0;
  std::uint32_t from = 0;
  Value bytes_per_second = 0;
  bool scheduled = false;  ///< it has a message in the schedule of its bus
  std::unique_ptr<MeshHolding> mesh;
};

class Ledger {
 public:
  Ledger() = default;
  explicit Ledger(const System& system);

  /// Payload bytes/s promised on a resource.
  [[nodiscard]] Value reserved(std::size_t resource) const { return reserved_[resource]; }
  /// ps/s promised of a domain of a mesh.
  [[nodiscard]] Value medium_time(std::size_t network, std::size_t domain) const {
    return domains_[network][domain];
  }
  /// Null where the bus is not analysed.
  [[nodiscard]] const can::Schedule* schedule(std::size_t network) const {
    return schedules_[network] ? &*schedules_[network] : nullptr;
  }
  [[nodiscard]] const Holding* find(const Flow& flow) const;
  [[nodiscard]] bool carries(const Flow& flow) const { return find(flow) != nullptr; }
  [[nodiscard]] std::span<const Holding> holdings_of(std::size_t publisher) const {
    if (publisher >= holdings_.size()) return {};
    return holdings_[publisher];
  }

  /// Everything after a mark can be taken back, latest mark first.
  using Mark = std::size_t;
  [[nodiscard]] Mark mark();
  void roll_back(Mark mark);
  /// What was done cannot be taken back any more.
  void commit();

  /// False if the flow is carried already. The caller has checked the capacity: a sum above 2^64 -
  /// 1 bytes/s is a bug.
  bool add(const Flow& flow, Value bytes_per_second);
  /// More links of a mesh for a flow that was added, and what they take of its domains.
  void occupy(const Flow& flow, std::span<const std::uint32_t> links,
              std::vector<mesh::Share> shares);
  /// A message for a flow that was added, on an analysed bus; in place of the one that it has. What
  /// would be late if it did not fit: nothing was changed then.
  std::optional<can::Schedule::Late> schedule(const Flow& flow, can::Message message);
  /// The bus is analysed with less background, or the same, from now on.
  void assume(std::size_t network, can::Assumptions bus);
  /// Everything that a publisher holds.
  void remove(std::size_t publisher);

  /// The bus as it is analysed from now on. No channel holds anything of the network, and no mark
  /// is open.
  void set_bus(std::size_t network, std::optional<can::Assumptions> bus);
  /// The same for the domains of a mesh.
  void set_domains(std::size_t network, std::size_t count) { domains_[network].assign(count, 0); }

  /// The key of a flow's message in the schedule of its bus.
  [[nodiscard]] static std::uint64_t key_of(const Flow& flow);
  [[nodiscard]] static std::size_t publisher_of(std::uint64_t key) { return key >> kFromBits; }

  /// The same is promised, in whatever order it was.
  [[nodiscard]] bool same_promises(const Ledger& other) const;

 private:
  static constexpr unsigned kFromBits = 12;

  struct Added {
    std::size_t publisher;
  };
  struct Occupied {
    std::size_t publisher;
    std::size_t index;
    std::size_t links;                ///< how many it had
    std::vector<mesh::Share> shares;  ///< what was added; where it had none: all that it has
  };
  struct Scheduled {
    std::size_t publisher;
    std::size_t index;
  };
  struct Removed {
    std::size_t publisher;
    std::vector<Holding> holdings;
  };
  /// A schedule as it was at a mark.
  struct Kept {
    std::size_t network;
    std::unique_ptr<can::Schedule> schedule;
  };
  using Step = std::variant<Added, Occupied, Scheduled, Removed, Kept>;

  [[nodiscard]] std::size_t index_of(const Flow& flow) const;
  void keep_schedule(std::size_t network);
  void forget_kept(std::size_t from);
  void count(const Holding& holding, bool in);
  void undo(Added& step);
  void undo(Occupied& step);
  void undo(Scheduled& step);
  void undo(Removed& step);
  void undo(Kept& step);

  std::size_t networks_ = 0;
  std::vector<Value> reserved_;
  std::vector<std::vector<Value>> domains_;              // per network, per domain
  std::vector<std::optional<can::Schedule>> schedules_;  // per network
  std::vector<std::size_t> kept_;                        // per network: number of its last Kept
  std::vector<std::size_t> kept_networks_;               // those that have one, oldest first
  std::vector<std::vector<Holding>> holdings_;           // per publisher
  std::vector<Step> steps_;
  std::size_t last_mark_ = 0;
  bool marked_ = false;
};

}  // namespace mlcca::core
