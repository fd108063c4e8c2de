// SPDX-License-Identifier: BSD-2-Clause
#include "relay/afp.hpp"

#include <algorithm>
#include <functional>
#include <ranges>
#include <string>
#include <string_view>
#include <utility>

namespace mlcca::relay::afp {
namespace {

constexpr std::size_t kShort = 31;  // most fragments behind a fragment whose header has one octet
constexpr std::size_t kLong = kMostFragments - 1;  // the same for a header of two octets
constexpr std::size_t kNumber = 5;        // octets of the extension with the event's number
constexpr std::uint8_t kExtended = 0x40;  // bit in a header of one octet
constexpr std::uint8_t kFirst = 0x20;
constexpr std::uint8_t kTwoOctets = 0x80;

/// Octets of the header of a fragment with `left` fragments behind it.
std::size_t header_of(const Form& form, std::size_t left) {
  return (left <= kShort ? 1 : 2) + (form.numbered ? kNumber : 0);
}
std::size_t room_of(const Form& form, std::size_t left) {
  return form.payload - header_of(form, left);
}

std::uint32_t hash_of(Octets data) {
  constexpr unsigned half = 32;
  const std::string_view text(
      reinterpret_cast<const char*>(data.data()),  // NOLINT(*-reinterpret-cast)
      data.size());
  const std::uint64_t hash = std::hash<std::string_view>{}(text);
  return static_cast<std::uint32_t>(hash ^ hash >> half);
}

std::size_t fragments_for(const Form& form, std::size_t octets) {
  const std::size_t in_short = (kShort + 1) * room_of(form, 0);
  if (octets <= in_short) {
    const std::size_t room = room_of(form, 0);
    return std::max<std::size_t>(1, (octets + room - 1) / room);
  }
  const std::size_t room = room_of(form, kLong);
  return kShort + 1 + (octets - in_short + room - 1) / room;
}

}  // namespace

std::size_t longest_event(const Form& form) {
  const std::size_t all = (kShort + 1) * room_of(form, 0) + (kLong - kShort) * room_of(form, kLong);
  return std::min(all, kMostOctets);
}

// --- cutting -------------------------------------------------------------------------------------

Result<Fragments> Fragments::of(const Form& form, Octets event, std::uint32_t number) {
  if (event.size() > longest_event(form))
    return fail("an event of " + std::to_string(event.size()) + " octets: at most " +
                std::to_string(longest_event(form)) + " fit " + std::to_string(kMostFragments) +
                " fragments");
  return Fragments(form, event, number, fragments_for(form, event.size()));
}

std::optional<std::vector<std::uint8_t>> Fragments::next() {
  if (left_ == 0) return std::nullopt;
  const bool first = left_ == count_;
  const std::size_t behind = --left_;
  std::vector<std::uint8_t> out;
  out.reserve(form_.payload);
  const auto flags =
      static_cast<std::uint8_t>((form_.numbered ? kExtended : 0U) | (first ? kFirst : 0U));
  if (behind <= kShort) {
    out.push_back(static_cast<std::uint8_t>(flags | behind));
  } else {
    out.push_back(static_cast<std::uint8_t>(kTwoOctets | flags >> 1U | behind >> 8U));
    out.push_back(static_cast<std::uint8_t>(behind & 0xffU));
  }
  if (form_.numbered) {
    out.push_back(0);
    for (const unsigned shift : {24U, 16U, 8U, 0U})
      out.push_back(static_cast<std::uint8_t>(number_ >> shift));
  }
  const auto data = rest_.first(std::min(rest_.size(), room_of(form_, behind)));
  out.insert(out.end(), data.begin(), data.end());
  rest_ = rest_.subspan(data.size());
  return out;
}

// --- putting together ----------------------------------------------------------------------------

std::optional<Reassembly::Fragment> Reassembly::parse(Octets fragment) const {
  if (fragment.empty() || fragment.size() > form_.payload) return std::nullopt;
  Fragment out;
  std::uint8_t flags = fragment[0];
  if ((flags & kTwoOctets) == 0) {
    out.left = flags & kShort;
  } else {
    // Headers of three octets and more would be for events longer than 65,535 octets.
    if ((flags & kExtended) != 0 || fragment.size() < 2) return std::nullopt;
    out.left = (flags & 0x0fU) << 8U | fragment[1];
    flags = static_cast<std::uint8_t>(flags << 1U);
  }
  out.first = (flags & kFirst) != 0;
  const std::size_t size = (fragment[0] & kTwoOctets) == 0 ? 1 : 2;
  if (((flags & kExtended) != 0) != form_.numbered) return std::nullopt;
  if (form_.numbered) {
    // The number must be the only extension; FAMOUSO's forward error correction is left to
    // applications.
    if (fragment.size() < size + kNumber || fragment[size] != 0) return std::nullopt;
    for (std::size_t i = 1; i < kNumber; ++i) out.number = out.number << 8U | fragment[size + i];
  }
  // Only the shortest header that can hold the number is valid, because the position of the data in
  // the event is derived from the number.
  if (size != (out.left <= kShort ? 1U : 2U)) return std::nullopt;
  if (out.left != 0 && fragment.size() != form_.payload) return std::nullopt;
  out.data = fragment.subspan(header_of(form_, out.left));
  return out;
}

/// What is remembered of the fragments of an event, all of which are there.
std::vector<Reassembly::Print> Reassembly::prints_of(const Begun& begun) {
  std::vector<Print> out;
  if (!begun.last || begun.fragments.size() != *begun.last + 1) return out;
  for (const auto& [left, data] : begun.fragments)
    out.push_back({.hash = hash_of(data), .known = true});
  return out;
}

std::optional<Event> Reassembly::take(Source source, Octets fragment, std::uint64_t now) {
  expire(now);
  const auto parsed = parse(fragment);
  if (!parsed) {
    ++losses_.malformed;
    return std::nullopt;
  }
  return form_.numbered ? take_numbered(source, *parsed, now) : take_in_order(source, *parsed, now);
}

/// On a network that keeps the order, a source has one incomplete event at a time: its first
/// fragment begins the event, and a gap ends it.
std::optional<Event> Reassembly::take_in_order(Source source, const Fragment& fragment,
                                               std::uint64_t now) {
  const Key key{.source = source, .number = 0};
  auto event = begun_.find(key);
  if (fragment.first) {
    if (event != begun_.end()) give_up(event, losses_.incomplete);
    event = begin(key, now);
  } else if (event == begun_.end()) {
    return std::nullopt;  // the event's beginning was lost, and counted then
  } else if (event->second.fragments.begin()->first != fragment.left + 1) {
    give_up(event, losses_.incomplete);
    return std::nullopt;
  }
  return keep(event, fragment) ? complete(event) : std::nullopt;
}

std::optional<Event> Reassembly::take_numbered(Source source, const Fragment& fragment,
                                               std::uint64_t now) {
  const Key key{.source = source, .number = fragment.number};
  if (const auto done = done_.find(key); done != done_.end()) {
    if (take_duplicate(key, done->second, fragment)) return std::nullopt;
    start_again(source);
  }
  auto event = begun_.find(key);
  if (is_overtaken(key)) {
    ++losses_.late;
    if (event != begun_.end()) forget(event);
    remember(key, {.at = now, .prints = {}});  // so that its other fragments begin no event
    static_cast<void>(take_duplicate(key, done_.at(key), fragment));
    return std::nullopt;
  }
  if (event != begun_.end()) {
    const auto same = event->second.fragments.find(fragment.left);
    if (same != event->second.fragments.end()) {
      if (std::ranges::equal(same->second, fragment.data)) {
        ++losses_.duplicates;
        return std::nullopt;
      }
      start_again(source);
      event = begun_.end();
    }
  }
  if (event == begun_.end()) event = begin(key, now);
  if (!keep(event, fragment)) return std::nullopt;
  Done done{.at = now, .prints = prints_of(event->second), .complete = true};
  auto completed = complete(event);
  if (completed) remember(key, std::move(done));
  return completed;
}

void Reassembly::remember(const Key& key, Done done) {
  done_.emplace(key, std::move(done));
  done_order_.push_back(key);
  if (done_.size() <= limits_.remembered) return;
  done_.erase(done_order_.front());
  done_order_.pop_front();
}

/// A network that doubles frames does it soon. If all of an event comes again behind later ones of
/// its sender, or behind another one of which this was found, the sender may have started again and
/// sent the same. It is not taken for a new event, since it may be an old one, but it is counted.
bool Reassembly::take_duplicate(const Key& key, Done& done, const Fragment& fragment) {
  if (done.prints.size() <= fragment.left) {
    if (done.complete) return false;
    done.prints.resize(fragment.left + 1);
  }
  Print& print = done.prints[fragment.left];
  const std::uint32_t hash = hash_of(fragment.data);
  if (print.known && print.hash != hash) return false;
  const bool is_first = !std::exchange(print.known, true);
  print.hash = hash;
  if (is_first) return true;
  ++losses_.duplicates;
  print.again = true;
  if (!done.complete || !std::ranges::all_of(done.prints, &Print::again)) return true;
  for (Print& one : done.prints) one.again = false;
  const auto before = done_.find({.source = key.source, .number = key.number - 1});
  if (!is_overtaken(key) && (before == done_.end() || !before->second.repeated)) return true;
  done.repeated = true;
  ++losses_.repeated;
  return true;
}

void Reassembly::start_again(Source source) {
  for (auto it = begun_.begin(); it != begun_.end();) {
    const auto event = it++;
    if (event->first.source == source) give_up(event, losses_.incomplete);
  }
  std::erase_if(done_, [source](const auto& one) { return one.first.source == source; });
  std::erase_if(done_order_, [source](const Key& key) { return key.source == source; });
}

/// Event numbers wrap around: 0 follows the highest number.
bool Reassembly::is_overtaken(const Key& key) const {
  const auto follows = [&](std::uint32_t from) {
    const auto next = done_.lower_bound({.source = key.source, .number = from});
    return next != done_.end() && next->first.source == key.source &&
           next->first.number - key.number <= kOvertakes;
  };
  const std::uint32_t after = key.number + 1;
  return (after != 0 && follows(after)) || (key.number > ~kOvertakes && follows(0));
}

template <class Weight>
Reassembly::All::iterator Reassembly::victim(Weight weight, const Key* beside) {
  std::map<Source, std::size_t> of_source;
  for (const auto& [key, event] : begun_) of_source[key.source] += weight(event);
  auto found = begun_.end();
  for (auto it = begun_.begin(); it != begun_.end(); ++it) {
    if (beside != nullptr && it->first == *beside) continue;
    const auto better = [&](All::iterator than) {
      const std::size_t own = of_source[it->first.source];
      const std::size_t other = of_source[than->first.source];
      return own != other ? own > other : it->second.since < than->second.since;
    };
    if (found == begun_.end() || better(found)) found = it;
  }
  return found;
}

Reassembly::All::iterator Reassembly::begin(const Key& key, std::uint64_t now) {
  if (begun_.size() >= limits_.begun)
    give_up(victim([](const Begun&) { return std::size_t{1}; }, nullptr), losses_.crowded);
  return begun_.emplace(key, Begun{.fragments = {}, .last = {}, .octets = 0, .since = now}).first;
}

bool Reassembly::keep(All::iterator event, const Fragment& fragment) {
  Begun& begun = event->second;
  const bool beyond = (begun.last && fragment.left > *begun.last) ||
                      (fragment.first && !begun.fragments.empty() &&
                       begun.fragments.rbegin()->first > fragment.left);
  if (beyond || (fragment.first && begun.last) ||
      begun.octets + fragment.data.size() > kMostOctets) {
    give_up(event, losses_.malformed);
    return false;
  }
  const std::size_t cost = fragment.data.size() + kPerFragment;
  make_room(cost, event->first);
  if (octets_ + cost > limits_.octets) {
    give_up(event, losses_.crowded);
    return false;
  }
  if (fragment.first) begun.last = fragment.left;
  begun.octets += fragment.data.size();
  octets_ += cost;
  begun.fragments.emplace(fragment.left, std::vector(fragment.data.begin(), fragment.data.end()));
  return true;
}

std::optional<Event> Reassembly::complete(All::iterator event) {
  const Begun& begun = event->second;
  if (!begun.last || begun.fragments.size() != *begun.last + 1) return std::nullopt;
  Event octets;
  octets.reserve(begun.octets);
  for (const auto& [left, data] : begun.fragments | std::views::reverse)
    octets.insert(octets.end(), data.begin(), data.end());
  forget(event);
  return octets;
}

void Reassembly::give_up(All::iterator event, std::uint64_t& why) {
  ++why;
  forget(event);
}

void Reassembly::forget(All::iterator event) {
  octets_ -= event->second.octets + event->second.fragments.size() * kPerFragment;
  begun_.erase(event);
}

void Reassembly::expire(std::uint64_t now) {
  const auto is_old = [&](std::uint64_t since) {
    return now >= since && now - since >= limits_.lifetime_ns;
  };
  for (auto it = begun_.begin(); it != begun_.end();) {
    const auto event = it++;
    if (is_old(event->second.since)) give_up(event, losses_.incomplete);
  }
  while (!done_order_.empty() && is_old(done_.at(done_order_.front()).at)) {
    done_.erase(done_order_.front());
    done_order_.pop_front();
  }
}

void Reassembly::make_room(std::size_t octets, const Key& beside) {
  while (octets_ + octets > limits_.octets) {
    const auto other = victim([](const Begun& event) { return event.octets; }, &beside);
    if (other == begun_.end()) return;
    give_up(other, losses_.crowded);
  }
}

}  // namespace mlcca::relay::afp
