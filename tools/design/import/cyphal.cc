// SPDX-License-Identifier: BSD-2-Clause
// Interprets registers: subjects, their types, and the bus.
#include "tools/design/import/cyphal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "base/number.hpp"
#include "base/text.hpp"
#include "tools/design/import/text.hpp"
#include "tools/design/import/yaml.hpp"
#include "tools/values.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::uint64_t kMostCyphalNode = 127;
constexpr std::uint64_t kUnsetPort = 65'535;
constexpr std::uint64_t kHeartbeatSubject = 7'509;
constexpr std::uint64_t kClassicMtu = 8;
constexpr std::uint64_t kFdMtu = 64;
constexpr std::uint64_t kMostRate = 1'000'000;      // bit/s, as a description has it
constexpr std::uint64_t kMostDataRate = 8'000'000;  // bit/s
constexpr std::uint64_t kMostPriority = 7;
constexpr double kNanosecondsOfSecond = 1e9;
constexpr double kLongestPeriod = 86'400;  // s
constexpr double kShortestPeriod = 1e-6;   // s

/// A subject that a node publishes or subscribes, as its registers state it.
struct SubjectPort {
  int line = 0;
  std::optional<std::uint64_t> id;
  std::string type;
  std::optional<Value> period;  ///< ns
  std::optional<std::uint8_t> priority;
};

/// The registers of a node.
struct NodeRegisters {
  std::optional<std::uint64_t> number;
  std::string description;
  std::optional<std::uint64_t> mtu;
  std::vector<std::uint64_t> rates;  ///< bit/s of the arbitration phase, then of the data phase
  std::map<std::string, SubjectPort> published;
  std::map<std::string, SubjectPort> subscribed;
};

class CyphalMeaning {
 public:
  CyphalMeaning(const YamlText& yaml, const std::string& file, const ImportOptions& options)
      : yaml_(yaml), file_(file), options_(options), joiner_(out_) {
    out_.file = file;
    out_.profile = core::Profile::cyphal;
    out_.is_part = true;
    out_.bitrate = options.bitrate;
    out_.data_bitrate = options.data_bitrate;
  }

  Result<ImportedNetwork> take() {
    for (const auto root : yaml_.roots()) document(yaml_.at(root));
    if (error_.empty() && out_.messages.empty())
      error_ = fmt::format(
          "{}: there is no subject in it: registers are such as \"uavcan.pub.NAME.id: 1220\"",
          file_);
    if (!error_.empty()) return fail(error_);
    lack("control", "passes as control traffic, and is no channel", 0,
         fmt::format("heartbeat of each node, subject {}", kHeartbeatSubject));
    return std::move(out_);
  }

 private:
  void lack(std::string_view kind, std::string_view what, int line, std::string item) {
    out_.lacks.add(kind, what, line, std::move(item));
  }

  void wrong(int line, const std::string& text) {
    if (error_.empty()) error_ = fmt::format("{}:{}: {}", file_, line, text);
  }

  /// Reads a document: the registers of one node, or nodes with their registers.
  void document(const YamlValue& root) {
    if (root.kind == YamlValue::Kind::list) return names_only(root.line);
    if (root.kind != YamlValue::Kind::map)
      return wrong(root.line, "must be registers with their values, or nodes with registers");
    const bool by_node = std::ranges::any_of(root.entries, [&](const YamlValue::Entry& entry) {
      return whole_number(yaml_.at(entry.key).text).has_value();
    });
    if (!by_node) return node(root, std::nullopt, root.line);
    for (const auto& entry : root.entries) {
      const auto& key = yaml_.at(entry.key);
      const auto number = whole_number(key.text);
      if (!number)
        return wrong(key.line, fmt::format("\"{}\": must be a node-ID, as other keys here are",
                                           cut(key.text, 80)));
      const auto& registers = yaml_.at(entry.value);
      if (registers.kind == YamlValue::Kind::list) return names_only(registers.line);
      if (registers.kind != YamlValue::Kind::map) {
        lack("no-answer", "a node without registers: left out", key.line,
             fmt::format("node {}", *number));
        continue;
      }
      node(registers, number, key.line);
    }
  }

  void names_only(int line) {
    wrong(line,
          "these are names of registers without values: give them to \"yakut register-batch\"");
  }

  void node(const YamlValue& registers, std::optional<std::uint64_t> number, int line) {
    NodeRegisters read;
    other_.clear();
    for (const auto& entry : registers.entries)
      take_register(yaml_.at(entry.key), yaml_.at(entry.value), read);
    if (number && options_.node != 0 && *number != options_.node)
      return wrong(line, fmt::format("--node {}: the file says that this is node {}", options_.node,
                                     *number));
    if (!number && options_.node != 0) number = options_.node;
    if (!number) number = read.number;
    if (!number)
      return wrong(line, "neither a key nor uavcan.node.id says which node it is: state --node");
    if (*number > kMostCyphalNode)
      return wrong(line,
                   fmt::format("node {}: Cyphal/CAN has nodes 0 to {}", *number, kMostCyphalNode));
    const auto name = fmt::format("node-{}", *number);
    for (const auto& [kind, what, at, item] : other_)
      lack(kind, what, at, fmt::format("{}: {}", name, item));
    bus(read, name);
    const auto place = place_of(name, static_cast<std::uint8_t>(*number), read.description);
    const auto format = format_of(read, name, line);
    for (const auto& [port, subject] : read.published) add(port, subject, place, true, format);
    for (const auto& [port, subject] : read.subscribed) add(port, subject, place, false, format);
  }

  std::size_t place_of(const std::string& name, std::uint8_t number,
                       const std::string& description) {
    const auto known = std::ranges::find(out_.nodes, std::optional(number), &ImportedNode::number);
    if (known != out_.nodes.end()) return static_cast<std::size_t>(known - out_.nodes.begin());
    out_.nodes.push_back({name, description, number});
    return out_.nodes.size() - 1;
  }

  /// The elements of a register as `yakut register-batch` prints it: a value, a list of elements,
  /// or both below their type (--detailed).
  [[nodiscard]] std::vector<std::string_view> elements(const YamlValue& value) const {
    std::vector<std::string_view> out;
    const auto* from = &value;
    if (from->kind == YamlValue::Kind::map) {
      const auto typed = std::ranges::find_if(from->entries, [&](const YamlValue::Entry& entry) {
        return !yaml_.at(entry.key).text.starts_with('_');
      });
      if (typed == from->entries.end()) return out;
      from = yaml_.find(yaml_.at(typed->value), "value");
      if (from == nullptr) return out;
    }
    if (from->kind == YamlValue::Kind::scalar) out.emplace_back(from->text);
    for (const auto item : from->items)
      if (const auto& element = yaml_.at(item); element.kind == YamlValue::Kind::scalar)
        out.emplace_back(element.text);
    return out;
  }

  [[nodiscard]] std::vector<std::uint64_t> numbers(const YamlValue& value) const {
    std::vector<std::uint64_t> out;
    for (const auto element : elements(value))
      if (const auto number = whole_number(element)) out.push_back(*number);
    return out;
  }

  void take_register(const YamlValue& key, const YamlValue& value, NodeRegisters& into) {
    const std::string_view name = key.text;
    const auto all = numbers(value);
    const auto number = all.empty() ? std::nullopt : std::optional(all.front());
    if (name == "uavcan.node.id") {
      into.number = number;
    } else if (name == "uavcan.node.description") {
      if (const auto texts = elements(value); !texts.empty()) into.description = texts.front();
    } else if (name == "uavcan.can.mtu") {
      into.mtu = number;
    } else if (name == "uavcan.can.bitrate") {
      into.rates = all;
    } else if (name.starts_with("uavcan.pub.")) {
      port_register(key, value, into.published);
    } else if (name.starts_with("uavcan.sub.")) {
      port_register(key, value, into.subscribed);
    } else if (name.starts_with("uavcan.srv.") || name.starts_with("uavcan.cln.")) {
      if (name.ends_with(".id")) other("services", "services do not pass a gate", key, name);
    } else {
      other("registers", "have no counterpart", key, name);
    }
  }

  void other(std::string_view kind, std::string_view what, const YamlValue& key,
             std::string_view item) {
    other_.push_back({kind, what, key.line, std::string(item.substr(0, kMostItemText))});
  }

  /// Reads a register "uavcan.pub.NAME.FIELD" or "uavcan.sub.NAME.FIELD".
  void port_register(const YamlValue& key, const YamlValue& value,
                     std::map<std::string, SubjectPort>& ports) {
    constexpr std::size_t front = std::string_view("uavcan.pub.").size();
    const auto rest = std::string_view(key.text).substr(front);
    const auto dot = rest.rfind('.');
    if (dot == std::string_view::npos || dot == 0)
      return other("registers", "have no counterpart", key, key.text);
    const auto field = rest.substr(dot + 1);
    const auto texts = elements(value);
    const auto text = texts.empty() ? std::string_view() : texts.front();
    const auto port = [&]() -> SubjectPort& {
      auto& there = ports[std::string(rest.substr(0, dot))];
      if (there.line == 0 || field == "id") there.line = key.line;
      return there;
    };
    if (field == "id") {
      port().id = whole_number(text);
    } else if (field == "type") {
      port().type = text;
    } else if (field == "period" || field == "rate" || field == "frequency") {
      port().period = period_of(text, field == "period");
      if (!port().period)
        other("no-period", "is no time from 1 us to a day: not used", key, key.text);
    } else if (field == "prio" || field == "priority") {
      const auto number = whole_number(text);
      if (number && *number <= kMostPriority)
        port().priority = static_cast<std::uint8_t>(*number);
      else
        other("registers", "have no counterpart", key, key.text);
    } else {
      other("registers", "have no counterpart", key, key.text);
    }
  }

  /// The period in ns of a number that is seconds (`is_period`) or events a second.
  static std::optional<Value> period_of(std::string_view text, bool is_period) {
    const auto number = number_in<double>(text);
    if (!number || !(*number > 0)) return std::nullopt;
    const double seconds = is_period ? *number : 1 / *number;
    if (seconds < kShortestPeriod || seconds > kLongestPeriod) return std::nullopt;
    return static_cast<Value>(std::llround(seconds * kNanosecondsOfSecond));
  }

  /// Takes what the node states about the bus. The first node that states something counts.
  void bus(const NodeRegisters& read, const std::string& name) {
    const auto take = [&](std::size_t index, std::uint64_t most, std::uint32_t stated,
                          std::uint32_t& to) {
      if (stated != 0 || read.rates.size() <= index) return;
      const auto rate = read.rates[index];
      if (rate == 0 || rate > most) return;
      if (to == 0) to = static_cast<std::uint32_t>(rate);
      if (to != rate)
        lack("bit-rates", "differ between nodes of one network: the first one counts", 0,
             fmt::format("{}: {}", name, print_bitrate(static_cast<std::uint32_t>(rate))));
    };
    take(0, kMostRate, options_.bitrate, out_.bitrate);
    take(1, kMostDataRate, options_.data_bitrate, out_.data_bitrate);
  }

  core::FrameFormat format_of(const NodeRegisters& read, const std::string& name, int line) {
    if (!read.mtu || (*read.mtu != kClassicMtu && *read.mtu != kFdMtu))
      lack("no-mtu", "uavcan.can.mtu is neither 8 nor 64: classic frames are assumed", line, name);
    return read.mtu == kFdMtu ? core::FrameFormat::fd : core::FrameFormat::classic;
  }

  void add(const std::string& port, const SubjectPort& from, std::size_t place, bool publishes,
           core::FrameFormat format) {
    const auto& node = out_.nodes[place];
    const auto called = fmt::format("{}: {}", node.name, port);
    if (!from.id) return lack("no-id", "states no subject-id: left out", from.line, called);
    if (*from.id == kUnsetPort)
      return lack("unset", "has no subject (65535): left out", from.line, called);
    if (*from.id > kUnsetPort)
      return lack("no-binding", "cannot be bound on such a network: left out", from.line,
                  fmt::format("{}: SubjectID {}", called, *from.id));
    ImportedMessage next;
    next.name = fmt::format("{}-{}", port, *from.id);
    next.type = from.type;
    next.line = from.line;
    next.id = static_cast<std::uint32_t>(*from.id);
    next.format = format;
    next.priority = from.priority;
    describe(from, publishes, called, next);
    const ImportedEnd end{.node = place, .number = {}, .attributes = {}};
    (publishes ? next.senders : next.receivers).push_back(end);
    if (is_bindable(out_, next)) joiner_.add(std::move(next), {});
  }

  /// Sets size and Period, and notes what was assumed.
  void describe(const SubjectPort& from, bool publishes, const std::string& called,
                ImportedMessage& to) {
    const auto size = cyphal_size(from.type);
    // One frame without its tail byte.
    const Value frame = (to.format == core::FrameFormat::fd ? kFdMtu : kClassicMtu) - 1;
    to.attributes.set(Attribute::max_payload, size.value_or(frame));
    to.attributes.set(Attribute::period, from.period.value_or(options_.default_period));
    if (!publishes) return;
    if (!size)
      lack("no-size",
           "the size of the type is not known here: one frame is assumed, 7 bytes (FD: 63)",
           from.line,
           fmt::format("{}: {}", called, from.type.empty() ? "no type is stated" : from.type));
    if (!from.period)
      lack("no-cycle",
           fmt::format("registers state no period: sporadic, and Period {} is assumed "
                       "(--default-period)",
                       print_duration(options_.default_period)),
           from.line, called);
    if (!from.period) to.arrival = core::Arrival::sporadic;
    if (!size && !from.period)
      to.remark = fmt::format("Assumed: size and Period of {}.", to.name);
    else if (!size || !from.period)
      to.remark = fmt::format("Assumed: the {} of {}.", size ? "Period" : "size", to.name);
  }

  /// An item for the lacks, kept until the number of the node is known.
  struct Other {
    std::string_view kind;
    std::string_view what;
    int line;
    std::string item;
  };
  static constexpr std::size_t kMostItemText = 80;

  const YamlText& yaml_;
  const std::string& file_;
  const ImportOptions& options_;
  ImportedNetwork out_;
  Joiner joiner_;
  std::string error_;
  std::vector<Other> other_;
};

}  // namespace

Result<ImportedNetwork> import_cyphal(std::string_view text, const std::string& file,
                                      const ImportOptions& options) {
  return read_as_utf8(text, [&](std::string_view readable) -> Result<ImportedNetwork> {
    const auto yaml = read_yaml(readable, file);
    if (!yaml) return std::unexpected(yaml.error());
    return CyphalMeaning(*yaml, file, options).take();
  });
}

}  // namespace mlcca::tools::design
