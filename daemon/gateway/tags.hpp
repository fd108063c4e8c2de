// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's tags on the buses of this gateway: which subject has which, as the description states
// it or as the broker has dealt it, and where the broker contradicts that.
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

/// A subject on a bus.
struct Tag {
  std::size_t network = 0;
  std::string network_name;
  core::Subject subject = 0;
  std::string name;                    ///< of the channel, or "SUBSCRIB"
  std::optional<std::size_t> channel;  ///< none: kSubscribeSubject, control traffic
  bool dynamic = false;                ///< whatever the broker deals
  std::uint16_t etag = 0;              ///< stated or dealt, what its frames have here; 0: none
  std::uint16_t dealt = 0;  ///< dynamic: what the broker has dealt it instead of `etag`; 0: nothing
  bool is_in_gates = true;  ///< false: they have no room for it
  bool is_confirmed =
      false;  ///< a gate has compared just this tag with the broker's replies all along
  std::string contradiction;  ///< what the broker said, as a clause; empty: nothing
  std::string rival;          ///< why else no subject may have the tag, as a clause; empty: no
                              ///< reason
  std::uint64_t asked = 0;    ///< ns, when; 0: never
  std::uint64_t wait = 0;     ///< ns until it is asked for again

  /// Worth a request: it is unknown, or the broker may deal it again.
  [[nodiscard]] bool is_wanted() const { return dynamic && (etag == 0 || !contradiction.empty()); }
  /// What its frames are to have here: what was dealt, unless that is claimed by another one, too.
  [[nodiscard]] std::uint16_t due() const {
    if (dealt == 0) return etag;
    return rival.empty() ? dealt : std::uint16_t{0};
  }
  /// Why none of its frames passes; empty: it is not for the tag.
  [[nodiscard]] const std::string& problem() const {
    return contradiction.empty() ? rival : contradiction;
  }
};

/// Until a request is repeated, ns: this, then twice as long each time, up to the longest.
inline constexpr std::uint64_t kFirstTagWait = 1'000'000'000;
inline constexpr std::uint64_t kLongestTagWait = 30'000'000'000;

class Tags {
 public:
  /// Those of a description. What is known of a tag that stays as it is stated stays known.
  void describe(const core::System& system, std::size_t gateway);

  [[nodiscard]] std::span<const Tag> all() const { return tags_; }
  [[nodiscard]] std::span<Tag> all() { return tags_; }
  /// A tag is one subject's. Of the subjects that claim one (stated, admitted or dealt) none may
  /// have it, until all but one are stated or dealt another, or released. Who was dealt it gives it
  /// up to whom it is stated for. Gives those whose `rival` is another now.
  std::vector<Tag*> hold_apart();
  [[nodiscard]] Tag* find(std::size_t network, core::Subject subject);
  /// For the gates of a network.
  [[nodiscard]] std::vector<enforce::StatedBinding> stated(std::size_t network) const;
  /// Of a network, as its Condition has them.
  [[nodiscard]] std::vector<core::Contradicted> contradicted(std::size_t network) const;
  /// What has to outlive the gates: the tags that are stated and that nothing passes by, since the
  /// broker has dealt them otherwise.
  [[nodiscard]] std::vector<store::Contradicted> to_keep() const;
  /// Takes up what was kept, where no gate knows better. Gives those that are closed by it.
  std::vector<Tag*> recall(const store::Contents& kept);
  /// The one to ask for now; none: it is not time yet, or all are known.
  [[nodiscard]] Tag* to_ask_for(std::size_t network, std::uint64_t now);

 private:
  std::vector<Tag> tags_;
};

/// What a contradiction says: "the broker has dealt its tag 0x3ffe on robot-can to
/// 0x44697374616e6365 (Distance)".
[[nodiscard]] std::string contradiction_words(const Tag& tag, const enforce::FoundBinding& found);
/// "0x44697374616e6365 (Distance)"; the text only where all of it can be printed.
[[nodiscard]] std::string subject_words(core::Subject subject);

/// Asks the broker of a bus for the tag of a subject, as a node of FAMOUSO does.
[[nodiscard]] can_frame request_for_tag(std::uint8_t node, core::Subject subject);

}  // namespace mlcca
