// SPDX-License-Identifier: BSD-2-Clause
// Follows the replies of FAMOUSO's broker. A gate has already closed what they contradict; here the
// verdicts follow, and tags that are learned or dealt again open.
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

/// Keeps the tags of the buses, compares them with what the gates have seen, and asks brokers for
/// tags that are not known.
class TagBindings final : public ConditionSource {
 public:
  /// All references must outlive this object.
  TagBindings(Scene& scene, GateDriver& gates, EventLog& log, Turn& turn, Recorder& recorder,
              CanSender& can, const Clock& clock)
      : scene_(scene),
        gates_(gates),
        log_(log),
        turn_(turn),
        recorder_(recorder),
        can_(can),
        clock_(clock) {}

  /// take_up() is called for a description that has just been put in force, before it is decided.
  /// What the gates have learned under an earlier daemon still holds. `known`: at a start the tags
  /// on disk count as well, where no gate knows better.
  enum class Known : std::uint8_t { by_gates, by_gates_and_disk };
  void take_up(Known known);
  /// Writes to every gate which tags its subjects have. A new gate knows none.
  void state();
  void add_to(std::vector<core::Condition>& conditions) const override;

  /// Channels have been added at run time. Their tags are compared with what the broker has dealt
  /// before anything of them is granted.
  void claim();
  /// Channels that were added at run time are no longer used: others may have their tags.
  void leave_unused();

  /// To be called once a second, and when a gate reports a reply: closes an old identifier before
  /// the new one opens. `anyway`: also if no gate has news.
  void poll(bool anyway = false);
  /// To be called once a second: sends at most one request to the broker of each bus, for a tag
  /// that is not known.
  void ask();
  /// Why no broker can be asked although a tag is not known; empty if there is no such reason.
  [[nodiscard]] std::string problem() const;

  [[nodiscard]] std::span<const Tag> all() const { return tags_.all(); }

 private:
  /// The findings of one poll.
  struct Poll {
    bool changed = false;                      ///< a contradiction, or who has a tag, has changed
    std::map<Tag*, gates::FoundBinding> seen;  ///< what the gate of its network has seen
    std::vector<Tag*> confirmed;               ///< contradicted before, and dealt as stated since
  };
  void take_up(std::size_t port, const gates::FoundBinding& found);
  void put(const Tag& tag) const;
  void note() { recorder_.note_contradicted(tags_.to_keep()); }
  void report_rivals(const std::vector<Tag*>& changed);
  void take(std::size_t port, const gates::FoundBinding& found, Poll& poll);
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
  std::string reported_;                 ///< the latest reported problem()
  std::map<int, std::uint32_t> polled_;  ///< count of a gate's reports that was polled, by
                                         ///< interface
};

}  // namespace mlcca
