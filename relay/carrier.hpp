// SPDX-License-Identifier: BSD-2-Clause
// Carries events between the networks of a gateway.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "control/messages.hpp"
#include "relay/layers/layer.hpp"

namespace mlcca::relay {

/// Counters of one transfer.
struct Carried {
  std::uint64_t events = 0;
  std::uint64_t dropped = 0;     ///< events that the other network did not take, see Sent
  std::uint64_t late = 0;        ///< events that took longer than the gateway's Latency
  std::uint64_t longest_ns = 0;  ///< longest time from the kernel's receipt to the end of sending
};

/// Late events of a transfer since they were reported last.
struct Delay {
  std::uint64_t late = 0;
  std::uint64_t longest_ns = 0;  ///< longest time that one of them took
};

/// Receives the events of granted transfers on one interface and sends them on another. It carries
/// what the daemon has granted and nothing else; the gates on both sides check its frames like
/// those of any other program. It knows networks by their layers only.
class Carrier {
 public:
  using OpenLayer = std::function<Result<std::unique_ptr<Layer>>(const control::Endpoint&)>;
  /// Called with the descriptor of an interface when it is opened, and with -1 before it is closed.
  using Watch = std::function<void(std::uint32_t ifindex, int fd)>;
  using Log = std::function<void(const std::string&)>;

  /// What the carrier needs from its environment; tests replace it.
  struct Outside {
    OpenLayer open;
    Watch watch;
    Log log;
    std::function<std::uint64_t()> unix_ns;
  };
  explicit Carrier(Outside outside) : outside_(std::move(outside)) {}

  /// Replaces all transfers, or those of one subject. A transfer that stays the same is not
  /// interrupted and keeps its counters.
  void set_all(const std::vector<control::Transfer>& transfers);
  void set(std::uint64_t subject, const std::vector<control::Transfer>& transfers);

  /// Tries the transfers again that could not be started; a port may have become free, for example.
  void retry();

  /// Expires incomplete events, see Layer::expire(). To be called once a second.
  void expire();

  /// To be called when the descriptor of the interface is readable.
  void receive(std::uint32_t ifindex);

  [[nodiscard]] std::size_t transfers() const { return slots_.size() - free_.size(); }
  [[nodiscard]] std::size_t interfaces() const { return layers_.size(); }
  /// The shortest Latency of all transfers, in ns; 0: none is stated.
  [[nodiscard]] std::uint64_t shortest_latency() const {
    return latencies_.empty() ? 0 : *latencies_.begin();
  }
  /// Calls the handler for each transfer with its counters since it was started.
  void each(const std::function<void(const control::Transfer&, const Carried&)>& handler) const;
  [[nodiscard]] Losses losses() const;
  /// Calls the handler for each transfer with late events, at most once in `pause` ns for each
  /// transfer. `now`: any clock that does not decrease, in ns.
  void take_delays(std::uint64_t now, std::uint64_t pause,
                   const std::function<void(const control::Transfer&, const Delay&)>& handler);

 private:
  /// A transfer that is carried, and its counters.
  struct Slot {
    control::Transfer transfer;
    Carried carried;
    Layer* to = nullptr;
    Delay delay;                                 ///< not reported yet
    std::optional<std::uint64_t> taken_at = {};  ///< when it was reported last
  };

  /// Returns the layer of the endpoint's interface. It opens the layer if necessary, and opens it
  /// again if the network has become one of another kind. Null if that fails.
  Layer* layer_of(const control::Endpoint& endpoint);
  void exchange(std::uint64_t subject, const std::vector<control::Transfer>& transfers);
  /// Starts a transfer. Returns false if an interface cannot be used or cannot receive the subject.
  bool add(const control::Transfer& transfer);
  bool start(const control::Transfer& transfer, Layer& from, Layer& to);
  void note_problem(const std::string& of, const std::string& text);
  void remove(std::size_t number);
  void carry(const Layer::Arrival& arrival);
  void close(std::uint32_t ifindex);
  void close_unused();

  Outside outside_;
  std::vector<std::optional<Slot>> slots_;  ///< indexed by the follower number at the layer
  std::vector<std::size_t> free_;
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> by_subject_;
  std::map<std::uint32_t, OpenedLayer> layers_;  ///< by interface index
  std::multiset<std::uint64_t> latencies_;       ///< those that transfers state
  std::vector<control::Transfer> waiting_;       ///< transfers that could not be started yet
  std::map<std::string, std::string> problems_;  ///< what has failed and why, as it was logged, so
                                                 ///< that it is logged once
};

}  // namespace mlcca::relay
