// SPDX-License-Identifier: BSD-2-Clause
// Collects what the gates refuse, by kind of frame and sender: since when, how often. In audit mode
// these are the frames that the description does not cover yet.
#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "base/clock.hpp"
#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "core/gates/frame_reason.hpp"
#include "core/gates/plan.hpp"
#include "daemon/gateway/drops.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/outside/frames.hpp"
#include "daemon/outside/gate_reader.hpp"

namespace mlcca {

class AuditLog {
 public:
  /// The most findings. Of more, those with the fewest frames are removed, and of these the oldest
  /// first. Their frames are in a finding of the other frames of the interface.
  static constexpr std::size_t kMost = 1024;

  /// All references must outlive this object.
  AuditLog(const Scene& scene, const GateReader& gates, const Clock& clock)
      : scene_(scene),
        gates_(gates),
        clock_(clock),
        since_unix_s_(clock.unix_ns() / 1'000'000'000),
        clean_since_(clock.monotonic_ns()) {}

  /// Called once at the start, before anything is counted: takes the findings that a former daemon
  /// has kept.
  void restore(const control::Audit& kept);

  /// Notes `frames` frames of a delivery that were refused since the last call.
  void refused(const core::Verdict& verdict, const core::GateEntry& entry,
               const core::StatedReason& reason, Fate fate, std::uint64_t frames);
  /// The same for frames whose sender is known, and is not the one that the entry admits. They came
  /// within `span` ns; 0: unknown.
  void refused(const core::Verdict& verdict, const core::GateEntry& entry,
               const gates::RefusedSender& sender, Fate fate, std::uint64_t frames,
               std::uint64_t span);
  /// Notes the frames that the gate of a port has refused since the last poll and that belong to no
  /// delivery. `unknown` are its counters of frames without a slot.
  void poll(std::size_t port, const UnknownFrames& unknown);
  /// Takes the counters of a port as the starting point: what they show now is never reported. If
  /// the gate of its interface was polled before, it is polled on instead, so that no frame is lost
  /// when the description changes.
  void take_up(std::size_t port, const UnknownFrames& unknown);

  /// The rules have changed: the time for which they would have dropped nothing begins again.
  void restart_clean() { clean_since_ = clock_.monotonic_ns(); }
  /// ns since a frame passed in audit mode that would have been dropped, or since restart_clean().
  [[nodiscard]] std::uint64_t clean_ns() const { return clock_.monotonic_ns() - clean_since_; }

  /// All findings, those with most frames first, for restore() of the next daemon.
  [[nodiscard]] control::Audit contents() const;
  /// The findings without those for which the gateway has rules now. Refused deliveries have the
  /// reason, unknown frames have the channel that the description states for them.
  [[nodiscard]] control::Audit report() const;
  /// Whether something was found since the last call.
  [[nodiscard]] bool take_news() { return std::exchange(has_news_, false); }

 private:
  /// The identity of a finding: frames that agree in all of these belong to the same one.
  struct Key {
    std::string interface = {};
    std::string network = {};
    bool egress = false;
    std::string reason = {};
    // For a delivery:
    std::string channel = {};
    std::string publisher = {};
    std::string to = {};
    // For any other frame:
    std::uint32_t can_id = 0;
    std::uint8_t format =
        0;  ///< as in UnknownFrame; 0: not a CAN frame, or its can_id is not known
    std::uint64_t subject = 0;
    std::string address = {};
    std::string mac = {};
    std::string user = {};        ///< of a program that sent it, as a number
    std::string entered_by = {};  ///< interface by which it came in before it left
    std::string described = {};   ///< channel of a frame that is not of the granted sender
    /// Frames whose kind or, for a delivery, whose sender is not known, or is not listed any more.
    bool others = false;
    auto operator<=>(const Key&) const = default;
  };
  struct Finding {
    std::uint64_t dropped = 0;
    std::uint64_t would_drop = 0;
    std::uint64_t first_unix_s = 0;
    std::uint64_t last_unix_s = 0;
    std::uint64_t busy_gap = 0;  ///< ns, see control::Finding
    std::uint64_t noted = 0;     ///< monotonic ns; 0: not noted by this daemon
    std::uint32_t length = 0;
  };
  /// The order in which findings are removed.
  struct Rank {
    bool is_rest = false;
    std::uint64_t frames = 0;
    std::uint64_t last_unix_s = 0;
    const Key* key = nullptr;
    auto operator<=>(const Rank&) const = default;
  };
  /// New frames of a finding.
  struct News {
    Fate fate = Fate::dropped;
    std::uint64_t frames = 0;
    std::uint32_t length = 0;  ///< of the longest
    std::uint64_t span = 0;    ///< ns in which they came; 0: unknown
  };
  /// A reason, and whether the frames were on their way out.
  using ReasonOfGate = std::pair<core::FrameReason, bool>;
  using FramesByReason = std::map<ReasonOfGate, UnknownFrames>;
  /// The counters of a port's gate at the last poll.
  struct Polled {
    struct Frame {
      std::uint64_t count = 0;
      std::uint64_t sequence = 0;
    };
    std::uint64_t at = 0;  ///< monotonic ns; 0: never
    UnknownFrames unknown;
    /// Frames in findings of their kinds that `unknown` does not contain yet: a gate counts the
    /// kind first.
    std::uint64_t ahead = 0;
    std::map<std::tuple<std::uint32_t, std::uint64_t, std::uint8_t, bool>, Frame> frames;
    std::map<ReasonOfGate, UnknownFrames> reasons;
    std::map<bool, WithoutSlot> parts;                    ///< by direction
    std::map<std::size_t, gates::RefusedSender> senders;  ///< of no slot, by place
  };
  enum class Reporting : bool { no, yes };
  /// Whether it is the finding of further frames of an interface.
  static bool is_rest(const Key& key) { return key.others && key.channel.empty(); }

  void poll(std::size_t port, const UnknownFrames& unknown, Reporting reporting);
  /// Notes the frames that were refused for a reason that concerns no slot: by sender where it is
  /// known.
  void poll_reasons(std::size_t port, Polled& last, std::uint64_t span, Reporting reporting);
  FramesByReason fresh_reasons(std::size_t port, Polled& last) const;
  void poll_senders(std::size_t port, Polled& last, std::uint64_t span, Reporting reporting,
                    FramesByReason& fresh);
  void note_rest(std::size_t port, const ReasonOfGate& of, const UnknownFrames& frames);
  /// Returns the number of frames in findings of their kinds.
  std::uint64_t poll_frames(std::size_t port, Polled& last, News news, Reporting reporting);
  void note(const Key& key, const News& news);
  static Rank rank_of(const Key& key, const Finding& finding);
  /// The finding, made if there is none. Its rank has to be added again by rank() after a change.
  std::pair<const Key, Finding>& unranked(const Key& key);
  void rank(const std::pair<const Key, Finding>& of);
  Polled& polled_of(std::size_t port);
  void make_room();
  void add_to_others(const Key& key, const Finding& removed);

  const Scene& scene_;
  const GateReader& gates_;
  const Clock& clock_;
  std::map<Key, Finding> findings_;
  std::map<int, Polled> polled_;  ///< by index of the interface
  std::set<Rank> ranks_;          ///< of all findings, those that are removed first in front
  std::uint64_t left_out_ = 0;
  std::uint64_t since_unix_s_;
  std::uint64_t clean_since_;  ///< monotonic ns
  bool has_news_ = false;
};

}  // namespace mlcca
