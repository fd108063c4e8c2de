// SPDX-License-Identifier: BSD-2-Clause
// What follows from the replies of FAMOUSO's broker. A gate has closed what they contradict before
// this runs: here the verdicts follow, and tags that are learned or dealt again open.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "core/admission/state.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/gateway/tags.hpp"
#include "daemon/gateway/turn.hpp"
#include "daemon/outside/can_sender.hpp"
#include "daemon/outside/gate_driver.hpp"

namespace mlcca {

class TagBindings final : public ConditionSource {
 public:
  /// All of them must outlive this.
  TagBindings(Scene& scene, GateDriver& gates, EventLog& log, Turn& turn, Recorder& recorder,
              CanSender& can, const Clock& clock)
      : scene_(scene),
        gates_(gates),
        log_(log),
        turn_(turn),
        recorder_(recorder),
        can_(can),
        clock_(clock) {}

  /// For a description that has just become the one in force, before it is decided. What the gates
  /// have learned under a daemon before this one is still so, unless they say otherwise.
  /// `known`: at a start what is on disk counts, too, where no gate knows better.
  enum class Known : std::uint8_t { by_gates, by_gates_and_disk };
  void take_up(Known known);
  /// States to every gate which tags its subjects have: one that is new knows none.
  void state();
  void add_to(std::vector<core::Condition>& conditions) const override;

  /// Channels that are not described come and go. Their tags are compared with what the broker has
  /// dealt before anything of them is granted.
  void claim();
  /// Some of them are not used any more, so that their tags may become others'.
  void leave_unused();

  /// Once a second, and when a gate reports a reply: the old identifier is closed before the new
  /// one opens. `anyway`: also where no gate has found anything.
  void poll(bool anyway = false);
  /// Once a second: one request to the broker of each bus for a tag that is not known.
  void ask();
  /// Why no broker is asked although a tag is not known; empty: no reason.
  [[nodiscard]] std::string problem() const;

  [[nodiscard]] std::span<const Tag> all() const { return tags_.all(); }

 private:
  /// What one poll has found.
  struct Poll {
    bool changed = false;                        ///< of what is contradicted, or whose a tag is
    std::map<Tag*, enforce::FoundBinding> seen;  ///< in the gate of its network
    std::vector<Tag*> confirmed;                 ///< contradicted, and dealt as stated since
  };
  void take_up(std::size_t port, const enforce::FoundBinding& found);
  void put(const Tag& tag) const;
  void note() { recorder_.note_contradicted(tags_.to_keep()); }
  void report_rivals(const std::vector<Tag*>& changed);
  void take(std::size_t port, const enforce::FoundBinding& found, Poll& poll);
  bool move(const Poll& poll, core::FormerRules& left);
  void move(Tag& tag, core::FormerRules& left);
  [[nodiscard]] bool gates_agree_on(const Tag& tag);
  void report(const Tag& tag, int priority, std::string message);

  Scene& scene_;
  GateDriver& gates_;
  EventLog& log_;
  Turn& turn_;
  Recorder& recorder_;
  CanSender& can_;
  const Clock& clock_;
  Tags tags_;
  std::string reported_;                 ///< problem() as it was reported last
  std::map<int, std::uint32_t> polled_;  ///< count of a gate's reports that was polled, by
                                         ///< interface
};

}  // namespace mlcca
