// SPDX-License-Identifier: BSD-2-Clause
// Carries events from network to network: what the daemon has granted, and nothing else. The gates
// on both sides judge its frames as those of any other program.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "control/messages.hpp"
#include "relay/layers/layer.hpp"

namespace mlcca::relay {

/// What became of the events of one transfer.
struct Carried {
  std::uint64_t events = 0;
  std::uint64_t dropped = 0;     ///< not taken by the other network: see Sent
  std::uint64_t late = 0;        ///< sent later than the gateway promises
  std::uint64_t longest_ns = 0;  ///< from the kernel's receipt to the end of sending
};

/// Events of a transfer that were late since it was last asked for them.
struct Delay {
  std::uint64_t late = 0;
  std::uint64_t longest_ns = 0;  ///< of them
};

class Carrier {
 public:
  using OpenLayer = std::function<Result<std::unique_ptr<Layer>>(const control::Endpoint&)>;
  /// The descriptor of an interface is there, or (-1) will be closed.
  using Watch = std::function<void(std::uint32_t ifindex, int fd)>;
  using Log = std::function<void(const std::string&)>;

  struct Outside {
    OpenLayer open;
    Watch watch;
    Log log;
    std::function<std::uint64_t()> unix_ns;
  };
  explicit Carrier(Outside outside) : outside_(std::move(outside)) {}

  /// What there is to carry from now on: all of it, or of one subject. What stays the same is not
  /// interrupted and keeps its counters.
  void set_all(const std::vector<control::Transfer>& transfers);
  void set(std::uint64_t subject, const std::vector<control::Transfer>& transfers);

  /// Tries once more what could not be carried until now: a port may be free again.
  void retry();

  /// Once a second: see Layer::expire().
  void expire();

  /// The descriptor of the interface can be read.
  void receive(std::uint32_t ifindex);

  [[nodiscard]] std::size_t transfers() const { return slots_.size() - free_.size(); }
  [[nodiscard]] std::size_t interfaces() const { return layers_.size(); }
  /// Of each transfer, as long as it is there.
  void each(const std::function<void(const control::Transfer&, const Carried&)>& handler) const;
  [[nodiscard]] Losses losses() const;
  /// Of each transfer with late events, once in `pause` ns at most. `now`: any steady clock.
  void take_delays(std::uint64_t now, std::uint64_t pause,
                   const std::function<void(const control::Transfer&, const Delay&)>& handler);

 private:
  struct Slot {
    control::Transfer transfer;
    Carried carried;
    Layer* to = nullptr;
    Delay delay;                                 ///< not taken yet
    std::optional<std::uint64_t> taken_at = {};  ///< when the last one was
  };

  /// Opened where it is not, and again where the network has become one of another kind.
  Layer* layer_of(const control::Endpoint& endpoint);
  void exchange(std::uint64_t subject, const std::vector<control::Transfer>& transfers);
  /// False: an interface cannot be used, or does not follow the subject.
  bool add(const control::Transfer& transfer);
  bool start(const control::Transfer& transfer, Layer& from, Layer& to);
  void note_problem(const std::string& of, const std::string& text);
  void remove(std::size_t number);
  void carry(const Layer::Arrival& arrival);
  void close(std::uint32_t ifindex);
  void close_unused();

  Outside outside_;
  std::vector<std::optional<Slot>> slots_;  ///< by follower
  std::vector<std::size_t> free_;
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> by_subject_;
  std::map<std::uint32_t, OpenedLayer> layers_;  ///< by interface
  std::vector<control::Transfer> waiting_;       ///< could not be carried yet
  std::map<std::string, std::string> problems_;  ///< why, as it was logged
};

}  // namespace mlcca::relay
