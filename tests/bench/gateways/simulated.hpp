// SPDX-License-Identifier: BSD-2-Clause
// Gateways for the bench that have no kernel and no clients.
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
#include "daemon/cluster/record_codec.hpp"
#include "tests/bench/gateways/place.hpp"

namespace mlcca::bench {

/// A description, and what follows from it for entries in the store.
struct Described {
  explicit Described(const std::string& file);
  [[nodiscard]] const std::string& name() const { return system.name; }

  core::System system;
  core::cluster::Digest digest{};
  std::shared_ptr<const core::cluster::Keys> keys;
  std::unique_ptr<cluster::RecordCodec> codec;
  /// The value of d/current which says that this description is in force.
  core::cluster::Entry current;
};

/// A simulated gateway: it uses the protocol and the entries of the product, and has its own
/// connection to the store. It does not watch the store; the bench passes the changes of other
/// gateways to it.
class Simulated {
 public:
  struct Place {
    sd_event* loop = nullptr;
    const Described& described;
    std::size_t gateway = 0;
    std::size_t network = 0;  ///< the network on which it reserves
    Value lease = 0;
    std::string& trouble;  ///< receives what went wrong, because a callback cannot end the bench
  };
  Simulated(const Place& place, const cluster::Settings& settings, const std::string& endpoint);

  /// Begins from a store that has only the description in force.
  void begin();
  [[nodiscard]] bool joined() const { return joined_; }
  /// Makes one reservation, which ends with on_granted or on_refused.
  void reserve();
  /// Lets time pass; `later` (ns) is added to all later times.
  void pass(Value later);
  /// Passes a change of the network by another gateway.
  void observe(const core::cluster::Batch& batch);

  std::function<void()> on_granted, on_refused;
  /// Called when this gateway has changed the version of the network.
  std::function<void(const core::cluster::Batch&)> on_changed;

  [[nodiscard]] bool idle() const { return call_ == nullptr; }
  [[nodiscard]] std::size_t granted() const { return granted_; }
  [[nodiscard]] std::size_t conflicts() const { return conflicts_; }
  [[nodiscard]] std::size_t transactions() const { return transactions_; }
  /// Bytes of all requests, without HTTP.
  [[nodiscard]] std::size_t octets() const { return octets_; }
  /// Duration of the latest transaction.
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
  core::cluster::Txn txn_;  ///< the transaction in progress
  std::string answer_;
  Steady::time_point sent_;
  std::uint64_t next_ = 0;  ///< number of the next reservation
  Value later_ = 0;
  bool joined_ = false;
  std::size_t granted_ = 0, conflicts_ = 0, transactions_ = 0, octets_ = 0;
  double latest_ms_ = 0;
};

/// Bytes of the entries of one reservation in the store: of a rate on a network, and of a message
/// on a CAN bus.
struct EntrySizes {
  std::size_t rate = 0, message = 0, asked = 0, beat = 0;
};
[[nodiscard]] EntrySizes entry_sizes(const Described& described);

}  // namespace mlcca::bench
