// SPDX-License-Identifier: BSD-2-Clause
// A gateway without a kernel and without clients: the protocol and the entries of the product, and
// a connection of its own to the store. What others do it gets to know from whoever runs it.
#pragma once
#include <systemd/sd-event.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "base/handle.hpp"
#include "cluster/channel.hpp"
#include "cluster/settings.hpp"
#include "core/cluster/member.hpp"
#include "core/model/system.hpp"
#include "daemon/cluster/codec.hpp"
#include "tests/bench/gateways/place.hpp"

namespace mlcca::bench {

/// A description, and what follows from it for entries in the store.
struct Described {
  explicit Described(const std::string& file);
  [[nodiscard]] const std::string& name() const { return system.name; }

  core::System system;
  core::cluster::Digest digest{};
  std::shared_ptr<const core::cluster::Keys> keys;
  std::unique_ptr<cluster::Codec> codec;
  /// d/current, where it says that this description is in force.
  core::cluster::Entry current;
};

class Simulated {
 public:
  struct Place {
    sd_event* loop = nullptr;
    const Described& described;
    std::size_t gateway = 0;
    std::size_t network = 0;  ///< of which it reserves
    Value lease = 0;
    std::string& trouble;  ///< gets what went wrong: a callback cannot end the bench
  };
  Simulated(const Place& place, const cluster::Settings& settings, const std::string& endpoint);

  /// From a store that has the description in force, and nothing else.
  void begin();
  [[nodiscard]] bool joined() const { return joined_; }
  /// One reservation: it ends with on_granted or on_refused.
  void reserve();
  /// Time has passed, or is said to have: `later` is added to all that follows.
  void pass(Value later);
  /// Somebody else has changed the network.
  void observe(const core::cluster::Batch& batch);

  std::function<void()> on_granted, on_refused;
  /// The network has a new version.
  std::function<void(const core::cluster::Batch&)> on_changed;

  [[nodiscard]] bool idle() const { return call_ == nullptr; }
  [[nodiscard]] std::size_t granted() const { return granted_; }
  [[nodiscard]] std::size_t conflicts() const { return conflicts_; }
  [[nodiscard]] std::size_t transactions() const { return transactions_; }
  /// Octets of all requests, without what carries them.
  [[nodiscard]] std::size_t octets() const { return octets_; }
  /// How long the latest transaction has taken.
  [[nodiscard]] double latest_ms() const { return latest_ms_; }

 private:
  [[nodiscard]] Value now() const;
  [[nodiscard]] core::cluster::Wanted wanted() const;
  void pump();
  void take(const core::cluster::Event& event);
  void send(core::cluster::Txn txn);
  void end(const cluster::End& end);
  void committed(std::int64_t revision);

  Place place_;
  core::cluster::Member member_;
  std::unique_ptr<sd_event_source, FreeWith<sd_event_source_disable_unref>> timer_;
  std::unique_ptr<cluster::Channel> channel_;
  std::unique_ptr<cluster::Call> call_;
  core::cluster::Txn txn_;  ///< that is under way
  std::string answer_;
  Steady::time_point sent_;
  std::uint64_t next_ = 0;  ///< number of a reservation
  Value later_ = 0;
  bool joined_ = false;
  std::size_t granted_ = 0, conflicts_ = 0, transactions_ = 0, octets_ = 0;
  double latest_ms_ = 0;
};

/// The octets of what the store has of one reservation: of so many bytes a second of a network, and
/// of a message on a CAN bus.
struct EntrySizes {
  std::size_t rate = 0, message = 0, asked = 0, beat = 0;
};
[[nodiscard]] EntrySizes entry_sizes(const Described& described);

}  // namespace mlcca::bench
