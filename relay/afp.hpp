// SPDX-License-Identifier: BSD-2-Clause
// FAMOUSO's fragmentation of events (AFP): an event that is longer than the payload of a frame goes
// as a sequence of fragments. Each begins with how many fragments follow it (s), 31 at most in one
// octet and 4095 in two, and whether it is the first one (f):
//
//   0efsssss            s <= 31
//   10efssss ssssssss   s <= 4095
//
// Where e is set an extension follows; on networks that reorder it is the number of the event:
//
//   00000000 nnnnnnnn nnnnnnnn nnnnnnnn nnnnnnnn
//
// Every fragment but the last one fills the payload exactly. For example 9 octets on CAN:
// 21 00 01 02 03 04 05 06, then 00 07 08. Compatible with FAMOUSO's own implementation where that
// is sound; it cannot tell two senders of a subject apart on CAN, which we do.
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
  std::size_t payload = 8;  ///< octets of a frame, 8 to 65,535
  bool numbered = false;    ///< fragments have the number of their event: the network reorders
};
inline constexpr Form kCan{.payload = 8, .numbered = false};
inline constexpr Form kUdp{.payload = 8183, .numbered = true};
inline constexpr Form kAwds{.payload = 1392, .numbered = true};

inline constexpr std::size_t kMostFragments = 4096;
inline constexpr std::size_t kMostOctets = 65'535;  ///< of an event

/// The longest event that a form carries: 24,608 octets on CAN.
[[nodiscard]] std::size_t longest_event(const Form& form);

/// Cuts one event into fragments, the first one first.
class Fragments {
 public:
  /// `number` is of the event, where the form numbers them; each has another one. The event must
  /// live as long as this. Error: it has more than longest_event() octets.
  static Result<Fragments> of(const Form& form, Octets event, std::uint32_t number = 0);

  /// How many there are, at least one.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// The next one; nothing behind the last one.
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

/// What became of fragments that gave no event.
struct Losses {
  std::uint64_t malformed = 0;   ///< fragments that are none, or have extensions we do not know
  std::uint64_t duplicates = 0;  ///< fragments that were there before, or of an event that was
  std::uint64_t incomplete = 0;  ///< events of which a fragment did not come, or not in time
  std::uint64_t crowded = 0;     ///< events that were given up since too many were begun
  std::uint64_t late = 0;        ///< events that a later one of their source has overtaken
  auto operator<=>(const Losses&) const = default;
};

/// Memory that keeping a fragment takes beside its data, about.
inline constexpr std::size_t kPerFragment = 64;

/// Puts events together again. It takes untrusted input: its memory is bounded. Where it is
/// full, the source that has most of it loses its oldest event.
class Reassembly {
 public:
  /// Of one source, as the caller distinguishes them: subject and sender.
  using Source = std::uint64_t;

  struct Limits {
    std::size_t begun = 64;  ///< events that are not complete
    /// Of these, all together, with kPerFragment for each of their fragments.
    std::size_t octets = std::size_t{1} << 20;
    std::size_t remembered = 1024;  ///< numbers of events that were complete
    std::uint64_t lifetime_ns =
        3'000'000'000;  ///< of an event that is not complete, and of a number
  };

  explicit Reassembly(const Form& form) : Reassembly(form, Limits{}) {}
  Reassembly(const Form& form, const Limits& limits) : form_(form), limits_(limits) {}

  /// Of numbered events: as many before the latest one as are late. What is further from it is of a
  /// sender that has begun again.
  static constexpr std::uint32_t kOvertakes = 1024;

  /// The event that this fragment completes, if it does and none of its source that was sent later
  /// is complete. `now` never falls.
  std::optional<Event> take(Source source, Octets fragment, std::uint64_t now);
  /// Gives up what is older than Limits::lifetime_ns; take() does, too.
  void expire(std::uint64_t now);

  [[nodiscard]] const Losses& losses() const { return losses_; }
  /// What is kept now, for tests of its bounds.
  [[nodiscard]] std::size_t begun() const { return begun_.size(); }
  [[nodiscard]] std::size_t octets() const { return octets_; }
  [[nodiscard]] std::size_t remembered() const { return done_.size(); }

 private:
  struct Key {
    Source source = 0;
    std::uint32_t number = 0;
    auto operator<=>(const Key&) const = default;
  };
  struct Fragment {
    std::size_t left = 0;  ///< fragments behind it
    bool first = false;
    std::uint32_t number = 0;
    Octets data;
  };
  /// Fragments by how many are left behind each.
  struct Begun {
    std::map<std::size_t, std::vector<std::uint8_t>> fragments;
    std::optional<std::size_t> last;  ///< `left` of the first fragment, once it is there
    std::size_t octets = 0;
    std::uint64_t since = 0;
  };
  using All = std::map<Key, Begun>;

  [[nodiscard]] std::optional<Fragment> parse(Octets fragment) const;
  std::optional<Event> take_in_order(Source source, const Fragment& fragment, std::uint64_t now);
  std::optional<Event> take_numbered(Source source, const Fragment& fragment, std::uint64_t now);
  /// False: it is too much, or of another length than the others; the event is given up.
  bool keep(All::iterator event, const Fragment& fragment);
  std::optional<Event> complete(All::iterator event);
  void remember(const Key& key, std::uint64_t now);
  [[nodiscard]] bool is_overtaken(const Key& key) const;
  All::iterator begin(const Key& key, std::uint64_t now);
  void give_up(All::iterator event, std::uint64_t& why);
  void forget(All::iterator event);
  void make_room(std::size_t octets, const Key& beside);
  /// The oldest event, but not `beside`, of the source for which `weight` of its events is most.
  template <class Weight>
  All::iterator victim(Weight weight, const Key* beside);

  Form form_;
  Limits limits_;
  All begun_;
  std::size_t octets_ = 0;
  std::map<Key, std::uint64_t> done_;  ///< when it was complete
  std::list<Key> done_order_;          ///< oldest first
  Losses losses_;
};

}  // namespace mlcca::relay::afp
