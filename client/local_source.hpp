// SPDX-License-Identifier: BSD-2-Clause
// What programs of one user on the gateway send to a subscriber of this program. No gate is in
// between: what comes is held against what the daemon has granted by the rules of a gate.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "control/messages.hpp"

namespace mlcca::client {

class LocalSource {
 public:
  /// For which events come again before that is reported, as at a gate.
  static constexpr std::uint64_t kHold = 1'000'000'000;
  /// Between two reports of what was too much, and of what was missed, ns.
  static constexpr std::uint64_t kPause = 1'000'000'000;

  /// `now`: CLOCK_MONOTONIC, ns, as everywhere here.
  LocalSource(control::Endpoint granted, std::uint64_t now)
      : granted_(std::move(granted)), last_(now) {}

  [[nodiscard]] const control::Endpoint& granted() const { return granted_; }
  /// The same user, with other numbers perhaps.
  void grant(control::Endpoint granted) { granted_ = std::move(granted); }

  /// False: it is too long or too much, and dropped. `unix_ns`: when the kernel received it.
  [[nodiscard]] bool takes(std::size_t bytes, std::uint64_t unix_ns, std::uint64_t now);

  /// So many were lost before this one came: the kernel had no room for them.
  void miss(std::uint64_t events, std::uint64_t now);

  /// What has happened, as the daemon reports it of a gate. Call it until there is nothing.
  [[nodiscard]] std::optional<control::Event> happened(std::uint64_t now);
  /// When there may be something; nothing: not before another event has come.
  [[nodiscard]] std::optional<std::uint64_t> due() const;

 private:
  [[nodiscard]] bool is_in_turn(std::size_t bytes, std::uint64_t unix_ns);
  [[nodiscard]] control::Event event(const char* kind) const;
  [[nodiscard]] control::Event excess();
  [[nodiscard]] control::Event missed();
  [[nodiscard]] control::Event missing(std::uint64_t now);
  [[nodiscard]] control::Event restored();

  control::Endpoint granted_;
  std::uint64_t last_;           ///< when an event came, or it began
  std::uint64_t silent_at_ = 0;  ///< the last one before the silence that is reported; 0: none is
  std::uint64_t back_at_ = 0;    ///< since when they come again; 0: they do not
  std::uint64_t turn_ = 0;       ///< of the next event, Unix time, ns
  std::uint64_t seen_ = 0;       ///< Unix time of the latest one
  std::uint64_t excess_ = 0;     ///< not reported yet
  std::uint64_t excess_at_ = 0;  ///< when the first of them came
  std::uint64_t missed_ = 0;     ///< not reported yet
  std::uint64_t missed_at_ = 0;  ///< when the first of them was seen to be missed
};

}  // namespace mlcca::client
