// SPDX-License-Identifier: BSD-2-Clause
// Interprets a DBC file: periods, identifiers, senders.
#include "tools/design/import/dbc.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "base/number.hpp"
#include "base/text.hpp"
#include "core/model/medium.hpp"
#include "core/profiles/profile.hpp"
#include "tools/design/import/dbc_timing.hpp"
#include "tools/design/import/text.hpp"
#include "tools/values.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::uint32_t kFdBytes = 64;
constexpr std::uint32_t kLongJ1939 = 1785;
constexpr std::uint8_t kNullAddress = 0xfe;
constexpr std::uint32_t kUpToKilobits = 10'000;  // a smaller Baudrate is in kbit/s
constexpr std::string_view kUnnamed = "unnamed-sender";

bool says(const DbcValue& value, std::string_view part) {
  if (!value) return false;
  const auto same = [](char a, char b) {
    const auto small = [](char c) { return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c; };
    return small(a) == small(b);
  };
  return !std::ranges::search(*value, part, same).empty() || part.empty();
}

class DbcMeaning {
 public:
  DbcMeaning(DbcFile file, const std::string& name, const ImportOptions& options)
      : dbc_(std::move(file)), options_(options) {
    out_.file = name;
    out_.lacks = std::move(dbc_.lacks);
  }

  ImportedNetwork take() {
    out_.profile =
        options_.profile.value_or(is_j1939() ? core::Profile::j1939 : core::Profile::raw);
    for (const auto& node : dbc_.nodes) add(node);
    for (const auto& message : dbc_.messages)
      if (has_groups())
        add_group(message);
      else
        add_frame(message);
    finish();
    return std::move(out_);
  }

 private:
  /// Whether messages are parameter groups, as those of J1939 are, and not frames.
  [[nodiscard]] bool has_groups() const {
    return !core::traits_of(out_.profile).dbc_protocol.empty();
  }

  void lack(std::string_view kind, std::string_view what, int line, std::string item) {
    out_.lacks.add(kind, what, line, std::move(item));
  }

  /// Whether every message is a parameter group of J1939.
  [[nodiscard]] bool is_j1939() const {
    const bool stated = says(dbc_.protocol, "j1939");
    return std::ranges::all_of(dbc_.messages, [&](const DbcMessage& m) {
      return (m.id & core::kExtendedFlag) != 0 && (stated || says(m.format, "J1939PG"));
    });
  }

  void add(const DbcNode& node) {
    ImportedNode next;
    next.name = node.long_name && !node.long_name->empty() ? *node.long_name : node.name;
    next.description = node.comment;
    next.number = address_of(node);
    out_.nodes.push_back(std::move(next));
  }

  /// The address of a node of J1939. 0 is an address if it is stated for the node: as a default it
  /// means that there is none. The null address is none, too.
  std::optional<std::uint8_t> address_of(const DbcNode& node) {
    if (!node.address) return std::nullopt;
    const bool is_stated = node.address_line != 0;
    const auto number = number_in<unsigned>(*node.address);
    if (!has_groups()) {
      if (is_stated)
        lack("address", "is of J1939, and no node of this network has one: left out",
             node.address_line, fmt::format("{}: {}", node.name, cut(*node.address, 40)));
      return std::nullopt;
    }
    if (number && *number == kNullAddress) return std::nullopt;
    if (!number || *number > kNullAddress) {
      if (is_stated)
        lack("address", "is no address of J1939 (0 to 253): left out", node.address_line,
             fmt::format("{}: {}", node.name, cut(*node.address, 40)));
      return std::nullopt;
    }
    if (*number == 0 && !is_stated) return std::nullopt;
    return static_cast<std::uint8_t>(*number);
  }

  /// Sets Period and size, and notes what was assumed. True if the Period is.
  bool describe(const DbcMessage& from, ImportedMessage& to) {
    to.name = from.long_name && !from.long_name->empty() ? *from.long_name : from.name;
    to.description = from.comment;
    to.line = from.line;
    to.receivers = receivers_of(from.receivers);
    to.attributes.set(Attribute::max_payload, from.bytes);
    auto timing = timing_of(from, options_.default_period, out_.lacks);
    to.attributes.set(Attribute::period, timing.period);
    to.arrival = timing.arrival;
    to.remark = std::move(timing.remark);
    if (from.multiplexed)
      lack("multiplexed", "one channel has all that a message is multiplexed of", from.line,
           from.name);
    return timing.assumed;
  }

  /// Lengthens an assumed Period in which the transport protocol cannot carry the message of a
  /// parameter group: to whole seconds, as learn does.
  void lengthen(const DbcMessage& from, ImportedMessage& to) {
    constexpr Value second = 1'000'000'000;
    const auto* const transport = core::traits_of(out_.profile).fragmentation;
    if (transport == nullptr || from.bytes <= core::kClassicBytes) return;
    const Value pauses = transport->frames(from.bytes, core::kClassicBytes) - 1;
    const Value least = (pauses * transport->longest_pause / second + 1) * second;
    if (to.attributes[Attribute::period] >= least) return;
    to.attributes.set(Attribute::period, least);
    lack("transport", "the transport protocol takes longer than the assumed Period: lengthened",
         from.line, fmt::format("{}: {}", from.name, print_duration(least)));
  }

  void add_frame(const DbcMessage& from) {
    if (from.bytes > kFdBytes)
      return lack("too-long", "more than 64 bytes are no frame: left out", from.line,
                  fmt::format("{}: {} bytes", from.name, from.bytes));
    ImportedMessage next;
    next.extended = (from.id & core::kExtendedFlag) != 0;
    next.id = from.id & ~core::kExtendedFlag;
    if (next.id > core::kExtendedBits)
      return lack("identifier", "more than 29 bits are no identifier: left out", from.line,
                  fmt::format("{}: 0x{:x}", from.name, from.id));
    if (!next.extended && next.id > core::kStandardBits) {
      lack("assumed-extended", "more than 11 bits: taken as an extended identifier", from.line,
           fmt::format("{}: 0x{:x}", from.name, next.id));
      next.extended = true;
    }
    if (!known_.try_emplace({next.id, next.extended}, 0).second)
      return lack("repeated", "another message has the identifier: left out", from.line, from.name);
    next.format = format_of(from);
    static_cast<void>(describe(from, next));
    if (!is_bindable(out_, next)) return;
    frame_senders(from, next);
    out_.messages.push_back(std::move(next));
  }

  core::FrameFormat format_of(const DbcMessage& from) {
    const bool stated_fd = says(from.format, "_FD");
    if (from.bytes > core::kClassicBytes && !stated_fd)
      lack("assumed-fd", "more than 8 bytes: taken as an FD frame", from.line,
           fmt::format("{}: {} bytes", from.name, from.bytes));
    if (stated_fd || from.bytes > core::kClassicBytes) return core::FrameFormat::fd;
    const bool fd_bus = says(dbc_.bus_type, "FD");
    if (!fd_bus || from.format) return core::FrameFormat::classic;
    lack("assumed-any", "the bus has FD frames, and this message does not say: both pass",
         from.line, from.name);
    return core::FrameFormat::any;
  }

  /// Sets the sender of a message: an identifier has only one.
  void frame_senders(const DbcMessage& from, ImportedMessage& to) {
    if (from.senders.empty()) return unnamed(from, to, std::nullopt);
    to.senders.push_back({from.senders.front(), std::nullopt, {}});
    for (std::size_t i = 1; i < from.senders.size(); ++i)
      lack("further-senders", "an identifier has one sender: this node publishes nothing of it",
           from.line, fmt::format("{}: {}", from.name, dbc_.nodes[from.senders[i]].name));
    remove_receiver(to, from.senders.front());
  }

  void unnamed(const DbcMessage& from, ImportedMessage& to, std::optional<std::uint8_t> number) {
    if (!unnamed_) {
      unnamed_ = out_.nodes.size();
      out_.nodes.push_back({std::string(kUnnamed), "senders that the file does not name", {}});
    }
    to.senders.push_back({*unnamed_, number, {}});
    lack("no-sender", "no sender is named: published by unnamed-sender", from.line, from.name);
  }

  /// Adds a message to its parameter group.
  void add_group(const DbcMessage& from) {
    if ((from.id & core::kExtendedFlag) == 0)
      return lack("identifier", "11 bits are no parameter group: left out", from.line, from.name);
    const std::uint32_t id = from.id & ~core::kExtendedFlag;
    if (id > core::kExtendedBits || from.bytes > kLongJ1939)
      return lack("too-long", "more than 29 bits or 1785 bytes are no parameter group: left out",
                  from.line, from.name);
    constexpr std::uint32_t first_broadcast = 240;  // PDU2
    ImportedMessage next;
    next.extended = true;
    next.id = (id >> 8U) & 0x3ffffU;
    next.priority = static_cast<std::uint8_t>(id >> 26U);
    if (((id >> 16U) & 0xffU) < first_broadcast) {
      const auto destination = static_cast<std::uint8_t>(id >> 8U);
      next.id &= 0x3ff00U;
      if (destination != kNullAddress) next.destination = destination;
    }
    if (describe(from, next)) lengthen(from, next);
    group_senders(from, static_cast<std::uint8_t>(id), next);
    if (!is_bindable(out_, next)) return;
    auto& group = groups_[next.id];
    for (const auto known : group) {
      auto& other = out_.messages[known];
      if (other.destination == next.destination) return merge(next, other);
      if (!other.destination || !next.destination)
        return lack("overlap", "another message has the parameter group to any address: left out",
                    from.line, fmt::format("{} with {}", next.name, other.name));
    }
    group.push_back(out_.messages.size());
    out_.messages.push_back(std::move(next));
  }

  void group_senders(const DbcMessage& from, std::uint8_t source, ImportedMessage& to) {
    const bool states_source = source < kNullAddress;
    if (from.senders.empty() && states_source) return unnamed(from, to, source);
    for (const auto node : from.senders) {
      ImportedEnd end{node, std::nullopt, {}};
      if (states_source && from.senders.size() == 1) end.number = source;
      if (end.number == out_.nodes[node].number) end.number.reset();
      if (!end.number && !out_.nodes[node].number) {
        lack("no-address", "no source address is stated: state node of a Publisher", from.line,
             fmt::format("{}: {}", from.name, dbc_.nodes[node].name));
        continue;
      }
      if (!sends_as(to.senders, number(end))) to.senders.push_back(end);
      remove_receiver(to, node);
    }
    if (from.senders.empty())
      lack("no-sender", "neither a sender nor an address is stated: nobody publishes it", from.line,
           from.name);
  }

  [[nodiscard]] std::optional<std::uint8_t> number(const ImportedEnd& end) const {
    return end.number ? end.number : out_.nodes[end.node].number;
  }
  /// Whether an end of the group has that number.
  [[nodiscard]] bool sends_as(const std::vector<ImportedEnd>& ends,
                              std::optional<std::uint8_t> wanted) const {
    return std::ranges::any_of(ends, [&](const ImportedEnd& end) { return number(end) == wanted; });
  }

  /// Merges messages of one parameter group: the larger size, the shorter period, and all ends. It
  /// is sporadic if one of them is, or if one has a longer cycle.
  void merge(const ImportedMessage& next, ImportedMessage& into) {
    lack("one-group", "is of the same parameter group as another message, and one channel with it",
         next.line, fmt::format("{} with {}", next.name, into.name));
    if (next.priority != into.priority) into.priority.reset();
    const auto take = [&](Attribute a, bool larger) {
      if ((next.attributes[a] > into.attributes[a]) == larger)
        into.attributes.set(a, next.attributes[a]);
    };
    if (next.arrival == core::Arrival::sporadic ||
        next.attributes[Attribute::period] != into.attributes[Attribute::period])
      into.arrival = core::Arrival::sporadic;
    take(Attribute::max_payload, true);
    take(Attribute::period, false);
    for (const auto& sender : next.senders)
      if (!sends_as(into.senders, number(sender))) into.senders.push_back(sender);
    for (const auto& receiver : next.receivers) add_receiver(into, receiver);
    for (const auto& sender : into.senders) remove_receiver(into, sender.node);
  }

  void finish() {
    constexpr std::uint32_t most = 1'000'000;
    constexpr std::uint32_t most_data = 8'000'000;
    out_.bitrate = rate_of(options_.bitrate, dbc_.baudrate, most);
    out_.data_bitrate = rate_of(options_.data_bitrate, dbc_.data_baudrate, most_data);
  }

  /// The bit rate of an option or of the file; 0 if neither states one that CAN can have.
  std::uint32_t rate_of(std::uint32_t option, const DbcValue& value, std::uint32_t most) {
    if (!value || value->empty()) return option;
    const auto number = number_in<std::uint32_t>(*value);
    const std::uint32_t factor = number && *number < kUpToKilobits ? 1000 : 1;
    if (!number || *number > most / factor) {
      lack("no-bit-rate", "is no bit rate of CAN: left out", 0, std::string(cut(*value, 40)));
      return option;
    }
    return option != 0 ? option : *number * factor;
  }

  DbcFile dbc_;
  const ImportOptions& options_;
  ImportedNetwork out_;
  std::optional<std::size_t> unnamed_;
  std::map<std::pair<std::uint32_t, bool>, int> known_;
  std::map<std::uint32_t, std::vector<std::size_t>> groups_;  ///< indices of messages by PGN
};

}  // namespace

Result<ImportedNetwork> import_dbc(std::string_view text, const std::string& file,
                                   const ImportOptions& options) {
  bool converted = false;
  const auto readable = utf8_of(text, converted);
  auto read = read_dbc(readable, file);
  if (!read) return std::unexpected(std::move(read.error()));
  if (converted) read->lacks.add("encoding", "is no UTF-8", 0, "read as Windows-1252");
  return DbcMeaning(std::move(*read), file, options).take();
}

}  // namespace mlcca::tools::design
