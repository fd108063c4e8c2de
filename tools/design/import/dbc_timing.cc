// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/import/dbc_timing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "base/ascii.hpp"
#include "base/number.hpp"
#include "base/text.hpp"
#include "tools/design/import/text.hpp"
#include "tools/values.hpp"

namespace mlcca::tools::design {
namespace {

constexpr double kMostMilliseconds = 86'400'000;  // a day
constexpr double kNanosecondsOfMs = 1e6;

// What a word in a send type says.
constexpr unsigned kIsCyclic = 1U;
constexpr unsigned kIsActive = 2U;
constexpr unsigned kIsOnEvents = 4U;
constexpr unsigned kIsNone = 8U;

struct SendWord {
  std::string_view text;  ///< small letters
  unsigned says;
};

/// The words of which send types consist. Of words that begin alike, the longer one is first.
constexpr auto kSendWords = std::to_array<SendWord>({
    {"cyclic", kIsCyclic},
    {"cycle", kIsCyclic},
    {"periodic", kIsCyclic},
    {"fixed", 0},
    {"enabled", kIsActive},
    {"ifactive", kIsActive},
    {"active", kIsActive},
    {"fast", kIsActive},
    {"spontaneous", kIsOnEvents},
    {"spontan", kIsOnEvents},
    {"event", kIsOnEvents},
    {"triggered", kIsOnEvents},
    {"trigger", kIsOnEvents},
    {"change", kIsOnEvents},
    {"write", kIsOnEvents},
    {"request", kIsOnEvents},
    {"demand", kIsOnEvents},
    {"repetition", 0},
    {"repitition", 0},
    {"repeat", 0},
    {"vectorleerstring", kIsNone},
    {"reserved", kIsNone},
    {"none", kIsNone},
    {"notused", kIsNone},
    {"notdefined", kIsNone},
    {"nomsgsendtype", kIsNone},
    {"nosigsendtype", kIsNone},
    {"nosendtype", kIsNone},
    {"delay", 0},
    {"and", 0},
    {"with", 0},
    {"on", 0},
    {"wd", 0},
    {"x", 0},
});

/// Types that are abbreviations.
constexpr auto kShortTypes = std::to_array<SendWord>({
    {"ce", kIsCyclic | kIsOnEvents},
    {"ca", kIsCyclic | kIsActive},
});

/// The letters of a type as small ones, without the marks of ASCII that separate words.
std::string letters_of(std::string_view type) {
  constexpr unsigned char first_beyond_ascii = 0x80;
  std::string out;
  for (const char c : type)
    if (is_large_letter(c))
      out += static_cast<char>(c - 'A' + 'a');
    else if (is_alphanumeric(c) || static_cast<unsigned char>(c) >= first_beyond_ascii)
      out += c;
  return out.empty() ? std::string(type) : out;
}

/// What all words of a type say; nullopt if one of them is not known.
std::optional<unsigned> said_by(std::string_view letters) {
  for (const auto& [text, says] : kShortTypes)
    if (letters == text) return says;
  unsigned out = 0;
  while (!letters.empty()) {
    const auto* const word = std::ranges::find_if(
        kSendWords, [&](const SendWord& w) { return letters.starts_with(w.text); });
    if (word == kSendWords.end()) return std::nullopt;
    out |= word->says;
    letters.remove_prefix(word->text.size());
  }
  return out;
}

/// ns of a number of milliseconds; nullopt if it is not above 0 or is more than a day.
std::optional<Value> time_of(std::string_view value) {
  const auto number = number_in<double>(value);
  if (!number || std::isnan(*number) || *number <= 0 || *number > kMostMilliseconds)
    return std::nullopt;
  return std::max<Value>(1, static_cast<Value>(std::llround(*number * kNanosecondsOfMs)));
}

std::optional<Value> stated_time(const DbcValue& value) {
  return value ? time_of(*value) : std::nullopt;
}

std::optional<Value> shorter_of(std::optional<Value> a, std::optional<Value> b) {
  if (!a || !b) return a ? a : b;
  return std::min(*a, *b);
}

std::optional<Value> shortest_of(const DbcSignalValues& values) {
  std::optional<Value> out;
  for (const auto& value : values.different) out = shorter_of(out, time_of(value));
  return out;
}

class TimingOf {
 public:
  TimingOf(const DbcMessage& message, Lacks& lacks) : from_(message), lacks_(lacks) {}

  DbcTiming take(Value default_period) {
    list_times();
    type_ = sending();
    cycles();
    active_cycle();
    distance();
    const bool is_cyclic = type_.known && !type_.active && (type_.cyclic || !type_.events);
    DbcTiming out;
    if (!least_ || !is_cyclic || varies_) out.arrival = core::Arrival::sporadic;
    out.period = least_.value_or(default_period);
    out.assumed = !least_;
    if (!least_) {
      out.remark = fmt::format("Assumed: the file states no cycle time of {}.", from_.name);
      lack("no-cycle",
           fmt::format("no cycle time is stated: sporadic, and Period {} is assumed "
                       "(--default-period)",
                       print_duration(out.period)),
           from_.name);
    }
    return out;
  }

 private:
  void lack(std::string_view kind, std::string_view what, std::string item) {
    lacks_.add(kind, what, from_.line, std::move(item));
  }
  [[nodiscard]] std::string with_time(Value time) const {
    return fmt::format("{}: {}", from_.name, print_duration(time));
  }

  /// Notes times that are no valid numbers.
  void list_times() {
    const std::pair<const char*, const DbcValue*> all[] = {
        {"cycle time", &from_.cycle}, {"fast cycle time", &from_.fast}, {"distance", &from_.delay}};
    for (const auto& [name, value] : all)
      if (*value) list_time(name, **value);
    const std::pair<const char*, const DbcSignalValues*> of_signals[] = {
        {"cycle time of a signal", &from_.signal_cycles},
        {"fast cycle time of a signal", &from_.signal_fast}};
    for (const auto& [name, values] : of_signals)
      for (const auto& value : values->different) list_time(name, value);
  }
  void list_time(const char* name, std::string_view value) {
    if (value.empty() || time_of(value)) return;
    if (const auto number = number_in<double>(value); number && *number == 0) return;
    lack("no-time", "is no number of milliseconds up to a day: left out",
         fmt::format("{}: {} \"{}\"", from_.name, name, cut(value, 40)));
  }

  /// The send type of the message; without one those of its signals. Signals that are sent on
  /// events send a cyclic message on events, too.
  DbcSendType sending() {
    DbcSendType of_signals;
    for (const auto& value : from_.signal_send_types.different) {
      const auto one = noted(value, "of a signal");
      of_signals.known = of_signals.known && one.known;
      of_signals.stated = of_signals.stated || one.stated;
      of_signals.cyclic = of_signals.cyclic || one.cyclic;
      of_signals.active = of_signals.active || one.active;
      of_signals.events = of_signals.events || one.events;
    }
    // Where a signal is always sent in the cycle, that others are so while active is no pause.
    of_signals.active = of_signals.active && !of_signals.cyclic;
    if (!from_.send_type) return of_signals;
    DbcSendType out = noted(*from_.send_type, "");
    if (!out.stated && out.known) return of_signals;
    out.known = out.known && of_signals.known;
    out.events = out.events || of_signals.events;
    return out;
  }
  DbcSendType noted(std::string_view text, std::string_view of) {
    const auto out = send_type_of(text);
    if (!out.known)
      lack("send-type", "is not known: sporadic, with the shortest time that is stated",
           fmt::format("{}: \"{}\"{}{}", from_.name, cut(text, 40), of.empty() ? "" : " ", of));
    return out;
  }

  void cycles() {
    least_ = stated_time(from_.cycle);
    const auto of_signals = shortest_of(from_.signal_cycles);
    if (least_ && of_signals && *of_signals < *least_) {
      lack("signal-cycle",
           "a signal has a shorter cycle than its message, and the Period is that: sporadic",
           with_time(*of_signals));
      least_ = of_signals;
      varies_ = true;
    }
    if (!least_) least_ = of_signals;
  }

  /// The cycle while the message or a signal is active.
  void active_cycle() {
    const auto fast = shorter_of(stated_time(from_.fast), shortest_of(from_.signal_fast));
    if (!fast || fast == least_) return;
    varies_ = true;
    if (!least_ || *fast < *least_) {
      lack("fast",
           "the Period is the shorter cycle that the message has while it is active: sporadic",
           with_time(*fast));
      least_ = fast;
    } else {
      lack("slow",
           "has a longer cycle while it is active, and the Period is the shorter one: sporadic",
           with_time(*fast));
    }
  }

  void distance() {
    const auto delay = stated_time(from_.delay);
    // Without a known type it may be of events, too.
    const bool is_used = type_.events || !type_.stated || !type_.known || !least_;
    if (delay && is_used && (!least_ || *delay < *least_)) {
      lack("distance", "the Period is the least distance of what is sent on events: sporadic",
           with_time(*delay));
      least_ = delay;
      varies_ = true;
    } else if (delay) {
      lack("unused-distance",
           "the least distance is left out: nothing is sent on events, or the cycle is shorter",
           with_time(*delay));
    } else if (type_.events && least_) {
      lack("events",
           "is sent on events too, and no distance is stated: what comes sooner than the "
           "Period is dropped as excess",
           from_.name);
    }
  }

  const DbcMessage& from_;
  Lacks& lacks_;
  DbcSendType type_;
  std::optional<Value> least_;  ///< the shortest time between two messages
  bool varies_ = false;         ///< the time between two messages may be longer than that
};

}  // namespace

DbcSendType send_type_of(std::string_view type) {
  const auto says = said_by(letters_of(type));
  DbcSendType out;
  // What is both used and not used is not known.
  out.known = says && ((*says & kIsNone) == 0 || *says == kIsNone);
  if (!out.known) return out;
  out.cyclic = (*says & kIsCyclic) != 0;
  out.active = (*says & kIsActive) != 0;
  out.events = (*says & kIsOnEvents) != 0;
  out.stated = out.cyclic || out.active || out.events;
  return out;
}

DbcTiming timing_of(const DbcMessage& message, Value default_period, Lacks& lacks) {
  return TimingOf(message, lacks).take(default_period);
}

}  // namespace mlcca::tools::design
