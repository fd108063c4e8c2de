// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/import/eds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "base/many.hpp"
#include "tools/design/import/eds_read.hpp"
#include "tools/design/import/text.hpp"
#include "tools/values.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::uint32_t kInvalid = 0x80000000;  // bit of a COB-ID: not used
constexpr std::uint32_t kLongId = 0x20000000;   // bit of a COB-ID: 29 bits
constexpr std::uint32_t kShortId = 0x7ff;       // bits of an 11-bit COB-ID
constexpr std::uint32_t kPdos = 0x200;          // of each direction
constexpr std::uint32_t kMostMapped = 64;       // objects in a PDO
constexpr std::uint32_t kHeartbeat = 0x700;     // COB-ID without the node-id
constexpr std::uint32_t kMostNode = 127;
constexpr std::uint32_t kPdoBytes = 8;
constexpr Value kTenthOfMs = 100'000;  // ns, unit of inhibit times
constexpr Value kMs = 1'000'000;       // ns

/// Where the parameters of transmit or receive PDOs are in the object dictionary.
struct PdoKind {
  std::string_view name;
  std::uint32_t communication;
  std::uint32_t mapping;
  bool sent;
};
constexpr PdoKind kSent{"TPDO", 0x1800, 0x1a00, true};
constexpr PdoKind kReceived{"RPDO", 0x1400, 0x1600, false};

class EdsMeaning {
 public:
  EdsMeaning(EdsFile eds, const std::string& file, const ImportOptions& options, unsigned node)
      : eds_(std::move(eds)), options_(options), node_(node) {
    out_.file = file;
    out_.profile = core::Profile::canopen;
    out_.is_part = true;
  }

  ImportedNetwork take() {
    const auto& called = eds_.node_name.empty() ? eds_.product : eds_.node_name;
    out_.nodes.push_back({fmt::format("{}-{}", called.empty() ? "node" : called, node_),
                          eds_.product, std::nullopt});
    sync_period_ = number_or(0x1006, 0, 0, "time between SYNC messages");
    for (const auto* kind : {&kSent, &kReceived})
      for (std::uint32_t i = 0; i < kPdos; ++i) pdo(*kind, i);
    heartbeat();
    consumers();
    others();
    bit_rate();
    return std::move(out_);
  }

 private:
  [[nodiscard]] std::optional<std::uint32_t> number(std::uint32_t index, std::uint32_t sub) const {
    return eds_.number(index, sub, node_);
  }
  /// The number of an object, or `otherwise` if it is not stated; a text that is no number is
  /// noted.
  std::uint32_t number_or(std::uint32_t index, std::uint32_t sub, std::uint32_t otherwise,
                          const std::string& what) {
    const auto value = number(index, sub);
    if (!value && line_of(index, sub) != 0) unreadable(index, sub, what);
    return value.value_or(otherwise);
  }
  void unreadable(std::uint32_t index, std::uint32_t sub, const std::string& what) {
    const auto& entry = eds_.objects.at({index, sub});
    lack("no-number", "is no number: taken as not stated", entry.line,
         fmt::format("{}: '{}'", what, entry.value));
  }
  [[nodiscard]] int line_of(std::uint32_t index, std::uint32_t sub) const {
    const auto found = eds_.objects.find({index, sub});
    return found == eds_.objects.end() ? 0 : found->second.line;
  }

  void lack(std::string_view kind, std::string_view what, int line, std::string item) {
    out_.lacks.add(kind, what, line, std::move(item));
  }

  void pdo(const PdoKind& kind, std::uint32_t i) {
    const auto index = kind.communication + i;
    const auto cob = number(index, 1);
    const auto name = fmt::format("{}-{}{}", out_.nodes.front().name, kind.name, i + 1);
    const int line = line_of(index, 1);
    if (!cob) {
      if (line != 0)
        lack("no-cob-id", "is no number: left out", line,
             fmt::format("{}: '{}'", name, eds_.objects.at({index, 1}).value));
      return;
    }
    if ((*cob & kInvalid) != 0) return lack("unused", "a PDO that is switched off", line, name);
    if ((*cob & kLongId) != 0)
      return lack("identifier", "29 bits are no COB-ID of a network: left out", line, name);
    ImportedMessage next;
    next.name = name;
    next.line = line;
    next.id = *cob & kShortId;
    next.attributes.set(Attribute::max_payload, bytes(kind.mapping + i, line, name));
    if (kind.sent) {
      next.senders.push_back({0, std::nullopt, {}});
      period(index, line, next);
    } else {
      add_receiver(next, {0, std::nullopt, {}});
      next.attributes.set(Attribute::period, options_.default_period);
    }
    add(std::move(next));
  }

  /// The size of the mapped objects; 8 if the file does not state it or it cannot be read.
  Value bytes(std::uint32_t mapping, int line, const std::string& name) {
    bool readable = true;
    const auto mapped = [&](std::uint32_t sub) {
      const auto value = number(mapping, sub);
      if (!value && line_of(mapping, sub) != 0) {
        readable = false;
        const auto& entry = eds_.objects.at({mapping, sub});
        lack("mapping", "is no number: 8 bytes are assumed", entry.line,
             fmt::format("{}: '{}'", name, entry.value));
      }
      return value.value_or(0);
    };
    const auto count = std::min(mapped(0), kMostMapped);
    std::uint32_t bits = 0;
    for (std::uint32_t sub = 1; sub <= count; ++sub) bits += mapped(sub) & 0xffU;
    if (!readable) return kPdoBytes;
    if (bits == 0 || bits > 8 * kPdoBytes) {
      lack("no-mapping", "no mapping of 1 to 64 bits is stated: 8 bytes are assumed", line, name);
      return kPdoBytes;
    }
    return (bits + 7) / 8;
  }

  /// The times of a PDO that is sent (CiA 301, objects 1800 and following).
  struct PdoTimes {
    std::uint32_t type = 0;  ///< transmission type
    Value inhibit = 0;       ///< ns, the shortest time between two; 0: none
    Value timer = 0;         ///< ns, after which it is sent without an event; 0: never
  };

  void period(std::uint32_t index, int line, ImportedMessage& to) {
    constexpr std::uint32_t last_synchronous = 240;
    const PdoTimes times{.type = number_or(index, 2, 0xff, to.name + ", transmission type"),
                         .inhibit = number_or(index, 3, 0, to.name + ", inhibit time") * kTenthOfMs,
                         .timer = number_or(index, 5, 0, to.name + ", event timer") * kMs};
    const bool synchronous = times.type <= last_synchronous;
    const Value least = synchronous ? after_sync(times, line, to) : on_events(times, line, to);
    to.attributes.set(Attribute::period, least != 0 ? least : options_.default_period);
    if (least != 0) return;
    to.arrival = core::Arrival::sporadic;
    to.remark = fmt::format("Assumed: {} stated of {}.",
                            synchronous ? "no time between SYNC messages is"
                                        : "neither an event timer nor an inhibit time is",
                            to.name);
    lack("no-cycle",
         fmt::format("no time is stated: sporadic, and Period {} is assumed (--default-period)",
                     print_duration(options_.default_period)),
         line, to.name);
  }

  /// Types 0 to 240 are sent after a SYNC: 0 if something has happened, others after each so many.
  /// Returns the Period; 0: no time of SYNC is stated.
  Value after_sync(const PdoTimes& times, int line, ImportedMessage& to) {
    constexpr Value us = 1000;
    if (times.type == 0) to.arrival = core::Arrival::sporadic;
    note_unused("an inhibit time", times.inhibit, line, to);
    note_unused("an event timer", times.timer, line, to);
    return sync_period_ * us * std::max<Value>(times.type, 1);
  }

  /// Further types are sent on events, with 254 and 255 also when the timer has run out, and with
  /// 252 and 253 when they are asked for. Returns the Period; 0: no time is stated.
  Value on_events(const PdoTimes& times, int line, ImportedMessage& to) {
    constexpr std::uint32_t first_on_request = 252;
    constexpr std::uint32_t first_on_event = 254;
    constexpr std::uint32_t last = 255;
    if (times.type > last || times.type < first_on_request)
      lack("transmission-type", "is reserved: taken as one of what is sent on events", line,
           fmt::format("{}: {}", to.name, times.type));
    else if (times.type < first_on_event)
      lack("on-request",
           "is sent when a remote frame asks for it: state remote-frames of its Binding", line,
           to.name);
    const bool has_timer = times.type >= first_on_event && times.type <= last;
    if (!has_timer) note_unused("an event timer", times.timer, line, to);
    const Value timer = has_timer ? times.timer : 0;
    if (timer != 0 && times.inhibit == 0) {
      lack("events",
           "no inhibit time is stated: what comes sooner than the event timer is dropped "
           "as excess",
           line, to.name);
      return timer;
    }
    if (timer == times.inhibit && timer != 0) return timer;
    to.arrival = core::Arrival::sporadic;
    if (timer == 0) return times.inhibit;
    if (timer < times.inhibit)
      lack("short-timer",
           "the event timer is shorter than the inhibit time, and the Period is that: sporadic",
           line, fmt::format("{}: {}", to.name, print_duration(timer)));
    else
      lack("distance",
           "the Period is the inhibit time, as events may come sooner than the timer: sporadic",
           line, fmt::format("{}: {}", to.name, print_duration(times.inhibit)));
    return std::min(timer, times.inhibit);
  }

  void note_unused(std::string_view what, Value time, int line, const ImportedMessage& of) {
    if (time != 0)
      lack("unused-time", "is stated and has no meaning for the transmission type: left out", line,
           fmt::format("{}: {}, {}", of.name, what, print_duration(time)));
  }

  void heartbeat() {
    const bool unknown = !number(0x1017, 0) && line_of(0x1017, 0) != 0;
    if (unknown)
      lack("heartbeat",
           fmt::format("its time is no number: Period {} is assumed (--default-period)",
                       print_duration(options_.default_period)),
           line_of(0x1017, 0), fmt::format("'{}'", eds_.objects.at({0x1017, 0}).value));
    const auto time = unknown ? options_.default_period : number(0x1017, 0).value_or(0) * kMs;
    if (time == 0) return;
    ImportedMessage next;
    next.name = out_.nodes.front().name + "-heartbeat";
    next.line = line_of(0x1017, 0);
    next.id = kHeartbeat + node_;
    next.attributes.set(Attribute::max_payload, 1).set(Attribute::period, time);
    next.senders.push_back({0, std::nullopt, {}});
    add(std::move(next));
  }

  /// Notes whose heart-beats this node expects. Only a person can turn that time into an Omission.
  void consumers() {
    // Some files omit the number of entries.
    const auto count =
        std::min(number_or(0x1016, 0, kMostNode, "number of heart-beats to wait for"), kMostNode);
    for (std::uint32_t sub = 1; sub <= kMostNode; ++sub) {
      if (sub > count) {
        if (const int line = line_of(0x1016, sub); line != 0)
          lack("consumer-count", "is beyond the number of heart-beats that is stated: left out",
               line, fmt::format("[1016sub{:x}]", sub));
        continue;
      }
      const auto value =
          number_or(0x1016, sub, 0, fmt::format("heart-beat to wait for, [1016sub{:x}]", sub));
      const auto node = (value >> 16U) & 0xffU;
      if (node == 0 || node > kMostNode || node == node_ || (value & 0xffffU) == 0) continue;
      ImportedMessage next;
      next.name = fmt::format("node-{}-heartbeat", node);
      next.line = line_of(0x1016, sub);
      next.id = kHeartbeat + node;
      add_receiver(next, {0, std::nullopt, {}});
      next.attributes.set(Attribute::max_payload, 1)
          .set(Attribute::period, options_.default_period);
      lack("consumer-time", "state how many heart-beats may be missed (Omission)", next.line,
           fmt::format("{}: {} ms", next.name, value & 0xffffU));
      add(std::move(next));
    }
  }

  void add(ImportedMessage next) {
    for (const auto& other : out_.messages)
      if (other.id == next.id)
        return lack("repeated", "another message has the COB-ID: left out", next.line, next.name);
    if (is_bindable(out_, next)) out_.messages.push_back(std::move(next));
  }

  void others() {
    struct Service {
      std::uint32_t index;
      std::string_view what;
    };
    for (const auto& service :
         {Service{0x1005, "SYNC"}, Service{0x1012, "TIME"}, Service{0x1014, "EMCY"}})
      if (const int line = line_of(service.index, 0); line != 0)
        lack("control", "passes as control traffic, and is no channel", line,
             std::string(service.what));
    std::size_t sdos = 0;
    for (std::uint32_t i = 0; i < 0x100; ++i)
      sdos += (line_of(0x1200 + i, 1) != 0 ? 1U : 0U) + (line_of(0x1280 + i, 1) != 0 ? 1U : 0U);
    if (sdos != 0)
      lack("sdo", "do not pass a gate: bind their COB-IDs if they shall", 0,
           many(sdos, "SDO channel"));
  }

  void bit_rate() {
    constexpr std::uint32_t most = 1000;
    out_.bitrate = options_.bitrate;
    if (out_.bitrate == 0 && eds_.kilobits && *eds_.kilobits > 0 && *eds_.kilobits <= most)
      out_.bitrate = *eds_.kilobits * 1000;
  }

  EdsFile eds_;
  const ImportOptions& options_;
  unsigned node_;
  std::uint32_t sync_period_ = 0;  ///< us
  ImportedNetwork out_;
};

}  // namespace

Result<ImportedNetwork> import_eds(std::string_view text, const std::string& file,
                                   const ImportOptions& options) {
  return read_as_utf8(text, [&](std::string_view readable) -> Result<ImportedNetwork> {
    auto read = read_eds(readable, file);
    if (!read) return std::unexpected(std::move(read.error()));
    const auto node = options.node != 0 ? options.node : read->node.value_or(0);
    if (node == 0 || node > kMostNode)
      return fail(
          fmt::format("{}: it states no NodeID of 1 to 127, as the EDS of a kind of device: "
                      "state --node",
                      file));
    auto out = EdsMeaning(std::move(*read), file, options, node).take();
    if (out.messages.empty())
      return fail(fmt::format("{}: there is no PDO that is switched on, and no heart-beat", file));
    return out;
  });
}

}  // namespace mlcca::tools::design
