// SPDX-License-Identifier: BSD-2-Clause
// Fragmentation of events by FAMOUSO's protocol AFP. An event that is longer than the payload of a
// frame is sent as a sequence of fragments. Each begins with a header: the number of fragments that
// follow (s), up to 31 in one octet and up to 4095 in two, and whether this is the first one (f):
//
//   0efsssss            s <= 31
//   10efssss ssssssss   s <= 4095
//
// If e is set, an extension follows. On networks that reorder frames it has the number of the
// event:
//
//   00000000 nnnnnnnn nnnnnnnn nnnnnnnn nnnnnnnn
//
// Every fragment except the last one fills the payload exactly. For example, 9 octets on CAN are
// sent as 21 00 01 02 03 04 05 06, then 00 07 08. This is compatible with FAMOUSO's own
// implementation where that is sound; unlike it, this code distinguishes two senders of a subject
// on CAN.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "base/result.hpp"

namespace mlcca::relay::afp {

using Octets = std::span<const std::uint8_t>;
using Event = std::vector<std::uint8_t>;

/// How a network carries fragments.
struct Form {
  std::size_t payload = 8;  ///< largest payload of a frame in octets, 8 to 65,535
  bool numbered = false;    ///< fragments carry the number of their event, because the network
                            ///< reorders frames
};
inline constexpr Form kCan{.payload = 8, .numbered = false};
inline constexpr Form kUdp{.payload = 8183, .numbered = true};

inline constexpr std::size_t kMostFragments = 4096;
inline constexpr std::size_t kMostOctets = 65'535;  ///< length of an event

/// The longest event in octets that a form carries, e.g. 24,608 on CAN.
[[nodiscard]] std::size_t longest_event(const Form& form);

/// Cuts one event into fragments, in the order in which they are sent.
class Fragments {
 public:
  /// `number` identifies the event if the form is numbered; events of one sender have different
  /// ones. The event must outlive this object. Fails if the event has more than longest_event()
  /// octets.
  static Result<Fragments> of(const Form& form, Octets event, std::uint32_t number = 0);

  /// The number of fragments in all, at least one.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// Returns the next fragment; nullopt after the last one.
  std::optional<std::vector<std::uint8_t>> next();

 private:
  Fragments(const Form& form, Octets event, std::uint32_t number, std::size_t count)
      : form_(form), rest_(event), number_(number), count_(count), left_(count) {}
  Form form_;
  Octets rest_;
  std::uint32_t number_;
  std::size_t count_;
  std::size_t left_;
};

/// Counts of fragments and events that were discarded.
struct Losses {
  std::uint64_t malformed = 0;   ///< fragments with a wrong header or an unknown extension
  std::uint64_t duplicates = 0;  ///< fragments that were received before, or belong to a complete
                                 ///< event
  std::uint64_t incomplete = 0;  ///< events given up because a fragment did not arrive, or not in
                                 ///< time
  std::uint64_t crowded = 0;     ///< events given up because too many were incomplete
  std::uint64_t late = 0;        ///< events discarded because a later event of the same source was
                                 ///< complete before
  std::uint64_t repeated = 0;  ///< events discarded because all of their fragments came again after
                               ///< later events of the same source: it may have started again
  auto operator<=>(const Losses&) const = default;
};

/// Approximate memory per stored fragment, in addition to its data.
inline constexpr std::size_t kPerFragment = 64;

/// Reassembles events from fragments. The input is untrusted, so the memory is bounded: if it is
/// full, the source with the largest share of it loses its oldest incomplete event.
class Reassembly {
 public:
  /// A sender of a subject, by a number that the caller chooses.
  using Source = std::uint64_t;

  /// Bounds of memory and time.
  struct Limits {
    std::size_t begun = 64;  ///< incomplete events
    /// Octets of all incomplete events, including kPerFragment for each fragment.
    std::size_t octets = std::size_t{1} << 20;
    std::size_t remembered = 1024;  ///< numbers of complete events, by which duplicates are
                                    ///< recognised, each with 8 octets for each of its fragments
    std::uint64_t lifetime_ns =
        3'000'000'000;  ///< how long an incomplete event or a number is kept
  };

  explicit Reassembly(const Form& form) : Reassembly(form, Limits{}) {}
  Reassembly(const Form& form, const Limits& limits) : form_(form), limits_(limits) {}

  /// An event with a number up to this much lower than that of a complete event of the source is
  /// late and discarded. A number with a greater distance is of a sender that has started again,
  /// and so is a fragment whose data differ from those that came before with the same number.
  static constexpr std::uint32_t kOvertakes = 1024;

  /// Takes one fragment, and returns the event if the fragment completes it. An event is not
  /// returned if a later one of its source was complete before. `now` (ns) must not decrease.
  std::optional<Event> take(Source source, Octets fragment, std::uint64_t now);
  /// Gives up incomplete events that are older than Limits::lifetime_ns. take() calls it as well.
  void expire(std::uint64_t now);

  [[nodiscard]] const Losses& losses() const { return losses_; }
  /// What is stored at present; for tests of the bounds.
  [[nodiscard]] std::size_t begun() const { return begun_.size(); }
  [[nodiscard]] std::size_t octets() const { return octets_; }
  [[nodiscard]] std::size_t remembered() const { return done_.size(); }

 private:
  /// Identifies an event of a source; the number is 0 if the form is not numbered.
  struct Key {
    Source source = 0;
    std::uint32_t number = 0;
    auto operator<=>(const Key&) const = default;
  };
  /// A parsed fragment; `data` refers to the frame.
  struct Fragment {
    std::size_t left = 0;  ///< number of fragments behind it
    bool first = false;
    std::uint32_t number = 0;
    Octets data;
  };
  /// An incomplete event: its fragments by the number of fragments behind each.
  struct Begun {
    std::map<std::size_t, std::vector<std::uint8_t>> fragments;
    std::optional<std::size_t> last;  ///< `left` of the first fragment, once that has arrived; the
                                      ///< event is complete with one fragment more than this
    std::size_t octets = 0;
    std::uint64_t since = 0;
  };
  using All = std::map<Key, Begun>;
  /// What is remembered of a fragment that was received.
  struct Print {
    std::uint32_t hash = 0;  ///< of its data
    bool known = false;
    bool again = false;  ///< it has come once more since
  };
  /// An event that is over.
  struct Done {
    std::uint64_t at = 0;       ///< when it was complete, or known to be late
    std::vector<Print> prints;  ///< by the number of fragments behind each
    bool complete = false;
    bool repeated = false;  ///< it was counted as such
  };

  [[nodiscard]] std::optional<Fragment> parse(Octets fragment) const;
  std::optional<Event> take_in_order(Source source, const Fragment& fragment, std::uint64_t now);
  std::optional<Event> take_numbered(Source source, const Fragment& fragment, std::uint64_t now);
  /// Stores a fragment. Returns false if it contradicts the others or no memory is left; the event
  /// is given up then.
  bool keep(All::iterator event, const Fragment& fragment);
  std::optional<Event> complete(All::iterator event);
  [[nodiscard]] static std::vector<Print> prints_of(const Begun& begun);
  void remember(const Key& key, Done done);
  /// Takes a fragment of an event that is over. Returns false if it is of another event, because
  /// the sender has started again.
  bool take_duplicate(const Key& key, Done& done, const Fragment& fragment);
  /// Forgets everything of a source that has started again.
  void start_again(Source source);
  [[nodiscard]] bool is_overtaken(const Key& key) const;
  All::iterator begin(const Key& key, std::uint64_t now);
  void give_up(All::iterator event, std::uint64_t& why);
  void forget(All::iterator event);
  void make_room(std::size_t octets, const Key& beside);
  /// The oldest event, except `beside`, of the source whose events have the largest sum of
  /// `weight`.
  template <class Weight>
  All::iterator victim(Weight weight, const Key* beside);

  Form form_;
  Limits limits_;
  All begun_;
  std::size_t octets_ = 0;
  std::map<Key, Done> done_;
  std::list<Key> done_order_;  ///< oldest first
  Losses losses_;
};

}  // namespace mlcca::relay::afp
