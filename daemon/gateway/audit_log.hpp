// SPDX-License-Identifier: BSD-2-Clause
// What the gates refuse, by kind of frame and sender: since when, how often. In audit mode that is
// what a description still lacks.
#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include "base/clock.hpp"
#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "core/gates/plan.hpp"
#include "daemon/gateway/drops.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/outside/gate_driver.hpp"

namespace mlcca {

class AuditLog {
 public:
  /// Of more findings those of the fewest frames give way, the oldest of them first.
  static constexpr std::size_t kMost = 1024;

  /// All of them must outlive this.
  AuditLog(const Scene& scene, const GateDriver& gates, const Clock& clock)
      : scene_(scene),
        gates_(gates),
        clock_(clock),
        since_unix_s_(clock.unix_ns() / 1'000'000'000),
        clean_since_(clock.monotonic_ns()) {}

  /// Once at the start, before anything is counted: what a former daemon has kept.
  void restore(const control::Audit& kept);

  /// So many frames of a delivery were refused since the last call, `reason` in words.
  void refused(const core::Verdict& verdict, const core::GateEntry& entry,
               const std::string& reason, Fate fate, std::uint64_t frames);
  /// Looks for frames that a port has refused since the last poll and that belong to no delivery;
  /// `unknown`: those without a slot so far.
  void poll(std::size_t port, const UnknownFrames& unknown);
  /// What the gate of a port has counted until now is not reported any more.
  void take_up(std::size_t port, const UnknownFrames& unknown);

  /// The rules are other ones now: for how long they would have dropped nothing begins again.
  void restart_clean() { clean_since_ = clock_.monotonic_ns(); }
  /// For so long nothing was let through that would have been dropped, ns.
  [[nodiscard]] std::uint64_t clean_ns() const { return clock_.monotonic_ns() - clean_since_; }

  /// Everything, the latest first: to be kept for the next daemon, see restore().
  [[nodiscard]] control::Audit contents() const;
  /// The same, without what the gateway has rules for now; of refused deliveries with why, of
  /// unknown frames with the channel that the description has for them.
  [[nodiscard]] control::Audit report() const;
  /// Something was found since the last call.
  [[nodiscard]] bool take_news() { return std::exchange(has_news_, false); }

 private:
  /// What makes a finding another one.
  struct Key {
    std::string interface = {};
    std::string network = {};
    bool egress = false;
    std::string reason = {};
    // Of a delivery:
    std::string channel = {};
    std::string publisher = {};
    std::string to = {};
    // Else the frame:
    std::uint32_t can_id = 0;
    std::uint8_t format = 0;  ///< as UnknownFrame has it; 0: no CAN frame
    std::uint64_t subject = 0;
    std::string address = {};
    std::string mac = {};
    auto operator<=>(const Key&) const = default;
  };
  struct Finding {
    std::uint64_t dropped = 0;
    std::uint64_t would_drop = 0;
    std::uint64_t first_unix_s = 0;
    std::uint64_t last_unix_s = 0;
    std::uint64_t busy_gap = 0;  ///< ns, see control::Finding
    std::uint64_t noted = 0;     ///< monotonic ns; 0: not by this daemon
    std::uint32_t length = 0;
  };
  /// New frames of a finding.
  struct News {
    Fate fate = Fate::dropped;
    std::uint64_t frames = 0;
    std::uint32_t length = 0;  ///< of the longest
    std::uint64_t span = 0;    ///< ns in which they came; 0: not known
  };
  /// What the gate of a port had counted at the last poll.
  struct Polled {
    struct Frame {
      std::uint64_t count = 0;
      std::uint64_t sequence = 0;
    };
    std::uint64_t at = 0;  ///< monotonic ns; 0: never
    UnknownFrames unknown;
    std::map<std::tuple<std::uint32_t, std::uint64_t, std::uint8_t, bool>, Frame> frames;
    std::map<std::pair<std::string, bool>, UnknownFrames> reasons;
  };
  enum class Reporting : bool { no, yes };

  void poll(std::size_t port, const UnknownFrames& unknown, Reporting reporting);
  void poll_reasons(std::size_t port, Polled& last, Reporting reporting);
  void poll_frames(std::size_t port, Polled& last, News news, Reporting reporting);
  void note(const Key& key, const News& news);
  void make_room();

  const Scene& scene_;
  const GateDriver& gates_;
  const Clock& clock_;
  std::map<Key, Finding> findings_;
  std::map<std::size_t, Polled> polled_;  ///< by port
  std::uint64_t left_out_ = 0;
  std::uint64_t since_unix_s_;
  std::uint64_t clean_since_;  ///< monotonic ns
  bool has_news_ = false;
};

}  // namespace mlcca
