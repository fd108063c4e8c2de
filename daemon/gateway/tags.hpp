// SPDX-License-Identifier: BSD-2-Clause
// The tags of FAMOUSO on the buses of this gateway: which subject has which tag, as the description
// states it or the broker has dealt it, and what contradicts that.
#pragma once
#include <linux/can.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/admission/world.hpp"
#include "core/model/system.hpp"
#include "daemon/gates/bindings.hpp"
#include "daemon/store/contents.hpp"

namespace mlcca {

/// The tag of a subject on one bus.
struct Tag {
  std::size_t network = 0;
  std::string network_name;
  core::Subject subject = 0;
  std::string name;                    ///< of the channel, or "SUBSCRIB"
  std::optional<std::size_t> channel;  ///< nullopt: kSubscribeSubject, control traffic
  bool dynamic = false;                ///< the broker deals it; otherwise the description states it
  std::uint16_t etag = 0;   ///< the tag that its frames have here, stated or dealt; 0: none
  std::uint16_t dealt = 0;  ///< dynamic: what the broker has dealt instead of `etag`; 0: nothing
  bool is_in_gates = true;  ///< false: the gates have no room for it
  bool is_confirmed =
      false;  ///< a gate has compared just this tag with the broker's replies all along
  std::string contradiction;  ///< what the broker said, as a clause; empty: no contradiction
  std::string rival;          ///< why else no subject may have the tag, as a clause; empty: no
                              ///< reason
  std::uint64_t asked = 0;    ///< ns, when the broker was last asked; 0: never
  std::uint64_t wait = 0;     ///< ns until it may be asked again

  /// Whether it is worth a request: it is not known, or the broker may deal it again.
  [[nodiscard]] bool is_wanted() const { return dynamic && (etag == 0 || !contradiction.empty()); }
  /// The tag that its frames are to have here: the dealt one, or none if another subject claims
  /// that too.
  [[nodiscard]] std::uint16_t due() const {
    if (dealt == 0) return etag;
    return rival.empty() ? dealt : std::uint16_t{0};
  }
  /// Why none of its frames pass; empty if the tag is no reason.
  [[nodiscard]] const std::string& problem() const {
    return contradiction.empty() ? rival : contradiction;
  }
};

/// ns until a request is repeated: kFirstTagWait, then twice as long each time, up to
/// kLongestTagWait.
inline constexpr std::uint64_t kFirstTagWait = 1'000'000'000;
inline constexpr std::uint64_t kLongestTagWait = 30'000'000'000;

/// All tags of this gateway, sorted by network and subject.
class Tags {
 public:
  /// Takes the tags of a description. What is known of a tag that is stated as before stays known.
  void describe(const core::System& system, std::size_t gateway);

  [[nodiscard]] std::span<const Tag> all() const { return tags_; }
  [[nodiscard]] std::span<Tag> all() { return tags_; }
  /// Enforces that a tag belongs to one subject. Of several subjects that claim one (stated,
  /// admitted or dealt), none may use it until all but one have another tag or are released. A
  /// subject to which it was dealt gives it up to one for which it is stated. Returns those whose
  /// `rival` has changed.
  std::vector<Tag*> hold_apart();
  [[nodiscard]] Tag* find(std::size_t network, core::Subject subject);
  /// The tags of a network, as its gates hold them.
  [[nodiscard]] std::vector<gates::StatedBinding> stated(std::size_t network) const;
  /// The contradicted tags of a network, as its Condition has them.
  [[nodiscard]] std::vector<core::Contradicted> contradicted(std::size_t network) const;
  /// The tags that must be kept beyond the gates: stated ones that nothing passes by, since the
  /// broker has dealt them otherwise.
  [[nodiscard]] std::vector<store::Contradicted> to_keep() const;
  /// Takes up kept contradictions where no gate knows better. Returns the tags that are closed by
  /// them.
  std::vector<Tag*> recall(const store::Contents& kept);
  /// The tag to ask for now; nullptr if it is too early or all are known.
  [[nodiscard]] Tag* to_ask_for(std::size_t network, std::uint64_t now);

 private:
  std::vector<Tag> tags_;
};

/// The text of a contradiction, for example "the broker has dealt its tag 0x3ffe on robot-can to
/// 0x44697374616e6365 (Distance)".
[[nodiscard]] std::string contradiction_words(const Tag& tag, const gates::FoundBinding& found);
/// For example "0x44697374616e6365 (Distance)". The text in brackets is present only if all of it
/// can be printed.
[[nodiscard]] std::string subject_words(core::Subject subject);

/// The frame by which a node of FAMOUSO asks the broker of a bus for the tag of a subject.
[[nodiscard]] can_frame request_for_tag(std::uint8_t node, core::Subject subject);

}  // namespace mlcca
