// SPDX-License-Identifier: BSD-2-Clause
// What has been promised, of every resource that a route touches: bytes/s of networks and gateways,
// the schedule of each CAN bus, the time of each domain of a mesh. Changed in place and taken back
// exactly: integers, and schedules that are kept as they were (ADR 14).
#pragma once
#include <compare>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "core/can/schedule.hpp"
#include "core/mesh/evaluation.hpp"
#include "core/model/system.hpp"
#include "core/reserve/parts.hpp"

namespace mlcca::core {

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

/// What a flow is promised whether or not it is held here.
struct Placeholder {
  Flow flow;
  Value bytes_per_second = 0;
  std::optional<can::Message> message;  ///< on an analysed bus
  std::vector<mesh::Share> shares;      ///< on a mesh, each domain once
  /// Another gateway has reserved it too: it counts even if it was given up here.
  bool by_others = false;
  bool operator==(const Placeholder&) const = default;
};

/// What is promised of a network beside what is held here.
struct Others {
  std::vector<can::Message> messages;  ///< keys: of Ledger::key_of_other()
  Value bytes_per_second = 0;
  std::vector<mesh::Share> shares;    ///< each domain once
  std::vector<Placeholder> standing;  ///< flows rising
  Value most_bytes = kUnbounded;      ///< payload bytes/s that the network has
  Value most_time = kUnbounded;       ///< ps/s that each domain has
  std::vector<Value> busy;            ///< ps/s of each domain that are measured as taken beside
                                      ///< all of this; empty: none
  bool complete = true;               ///< there is nothing else that is not known
  [[nodiscard]] bool empty() const {
    return messages.empty() && bytes_per_second == 0 && shares.empty() && standing.empty();
  }
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
  /// The message that a flow has, as it was asked for: without what others have reserved of it.
  [[nodiscard]] const can::Message* message_of(const Flow& flow) const;
  /// The bus is analysed with less background, or the same, from now on.
  void assume(std::size_t network, can::Assumptions bus);
  /// Everything that a publisher holds.
  void remove(std::size_t publisher);

  /// The bus as it is analysed from now on. No channel holds anything of the network, and no mark
  /// is open.
  void set_bus(std::size_t network, std::optional<can::Assumptions> bus);
  /// The same for the domains of a mesh.
  void set_domains(std::size_t network, std::size_t count);

  // What is promised to others, and what is promised here and not held. A
  // placeholder counts in full, whether or not its flow is carried and whatever is held of it: all
  // others count it so, too. Only one that did not fit does not, or that was given up (relax()).
  // Without any, none of this costs anything.

  struct Change {
    bool fits = true;       ///< false: what is held would suffer; rebuild_others() is due
    bool relieved = false;  ///< something takes less now
    bool held = false;      ///< a flow that was held without a placeholder has one now
  };
  /// In place of what there was, while channels hold something of the network. No mark is open.
  Change set_others(std::size_t network, Others others);
  /// The same while none does. What is late with all of that counts and is spared.
  void rebuild_others(std::size_t network, Others others);
  [[nodiscard]] bool has_others(std::size_t network) const {
    return !others_.empty() && !others_[network].is_empty();
  }
  /// All placeholders count in full, and all that is promised of the network fits. Otherwise what
  /// counts depends on the order in which it was decided.
  [[nodiscard]] bool counts_all(std::size_t network) const;
  /// What is promised on the flow's resource without the flow itself.
  [[nodiscard]] Value reserved_without(const Flow& flow) const;
  /// Placeholders of a publisher do not count until place_rest(). No mark is open.
  void relax(std::size_t publisher);
  /// Placeholders that do not count although their flows are not carried, as far as they fit.
  void place_rest();
  /// The publisher has no placeholders any more.
  void forget_placeholders(std::size_t publisher);
  /// From here until the mark is rolled back a flow takes what it is promised at least, as every
  /// other gateway counts it. False: not all of that fits on the network as it is now.
  [[nodiscard]] bool raise(std::size_t network);
  void set_raised(bool raised) { raised_ = raised; }

  /// Key of another gateway's message, and which gateway that is.
  [[nodiscard]] static std::uint64_t key_of_other(std::size_t gateway) {
    return kOther | static_cast<std::uint64_t>(gateway) << kGatewayShift;
  }
  [[nodiscard]] static bool is_of_other(std::uint64_t key) { return (key & kOther) != 0; }
  [[nodiscard]] static std::size_t gateway_of(std::uint64_t key) {
    return (key & ~kOther) >> kGatewayShift;
  }

  /// The key of a flow's message in the schedule of its bus.
  [[nodiscard]] static std::uint64_t key_of(const Flow& flow);
  [[nodiscard]] static std::size_t publisher_of(std::uint64_t key) { return key >> kFromBits; }

  /// The same is promised, in whatever order it was.
  [[nodiscard]] bool same_promises(const Ledger& other) const;

 private:
  static constexpr unsigned kFromBits = 12;
  static constexpr std::size_t kNowhere = ~std::size_t{0};

  static constexpr std::uint64_t kOther = std::uint64_t{1} << 63U;
  static constexpr unsigned kGatewayShift = 32;

  struct Added {
    std::size_t publisher;
    bool lifted;  ///< its placeholder counted before
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
    std::unique_ptr<std::vector<Flow>> placed;  ///< whose placeholders count since; null: none
  };
  /// What a network carries more than it did.
  struct Raised {
    std::size_t network;
    Value bytes_per_second;
    std::vector<mesh::Share> shares;
    std::vector<Flow> placed;
  };
  /// A schedule as it was at a mark.
  struct Bus {
    can::Schedule schedule;
    std::map<std::uint64_t, can::Message> asked;  ///< see OfOthers
  };
  struct Kept {
    std::size_t network;
    std::unique_ptr<Bus> bus;
  };
  using Step = std::variant<Added, Occupied, Scheduled, Removed, std::unique_ptr<Raised>, Kept>;

  struct Placed {
    Placeholder what;
    bool counts = false;
    bool in_full = false;  ///< also while less of the flow is held
  };
  struct OfOthers {
    std::vector<can::Message> messages;
    Value bytes_per_second = 0;
    std::vector<mesh::Share> shares;
    std::vector<Placed> standing;
    Value most_bytes = kUnbounded;
    Value most_time = kUnbounded;
    std::uint32_t numbered = 0;  ///< messages that had a number so far
    /// By their keys: messages as they were asked for, where more of the flow counts.
    std::map<std::uint64_t, can::Message> asked;
    [[nodiscard]] bool is_empty() const {
      return messages.empty() && bytes_per_second == 0 && shares.empty() && standing.empty();
    }
  };

  [[nodiscard]] std::size_t index_of(const Flow& flow) const;
  void keep_schedule(std::size_t network);
  void forget_kept(std::size_t from);
  void count(const Holding& holding, bool in);
  void undo(Added& step);
  void undo(Occupied& step);
  void undo(Scheduled& step);
  void undo(Removed& step);
  void undo(std::unique_ptr<Raised>& step);
  void undo(Kept& step);

  [[nodiscard]] Placed* placeholder(const Flow& flow);
  [[nodiscard]] const Placed* placeholder(const Flow& flow) const {
    return others_.empty() ? nullptr : const_cast<Ledger*>(this)->placeholder(flow);
  }
  void note_asked(std::size_t network, const can::Message& asked, const can::Message& counted);
  void count_shares(std::size_t network, std::span<const mesh::Share> shares, bool in);
  void count(Placed& placed, bool in);
  void lift(Placed& placed);
  [[nodiscard]] bool place(Placed& placed);
  std::unique_ptr<std::vector<Flow>> place_after(std::size_t publisher,
                                                 std::span<const Holding> gone);
  [[nodiscard]] bool has_room(std::size_t network, Value bytes_per_second,
                              std::span<const mesh::Share> shares) const;
  [[nodiscard]] bool is_fuller(std::size_t network, std::span<const Value> before,
                               std::span<const Value> busy) const;
  void forget_others(std::size_t network);
  [[nodiscard]] bool change_messages(std::size_t network, std::vector<can::Message> messages,
                                     bool& relieved);
  [[nodiscard]] bool change_sums(std::size_t network, const Others& others, bool& relieved);
  [[nodiscard]] bool lift_changed(std::vector<Placed>& before, std::vector<Placed>& next);
  [[nodiscard]] bool change_standing(std::size_t network, std::vector<Placeholder> standing,
                                     Change& change);
  [[nodiscard]] bool holds_in_full(const Placed& placed) const;
  [[nodiscard]] bool count_held(std::size_t network, std::span<Placed* const> fresh) const;
  [[nodiscard]] bool raise(Placed& placed, Raised& step);

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
  std::vector<OfOthers> others_;  // per network; empty: there are none
  bool unplaced_ = false;         // a placeholder may be left that place_rest() is due to
  bool raised_ = false;
};

}  // namespace mlcca::core
