// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/new/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

#include "base/ascii.hpp"
#include "base/number.hpp"
#include "core/model/medium.hpp"
#include "core/model/words.hpp"
#include "description/read.hpp"
#include "description/values.hpp"
#include "tools/design/attribute_list.hpp"
#include "tools/design/queue_lengths.hpp"
#include "tools/values.hpp"

namespace mlcca::tools::design {
namespace {

constexpr Value kMillisecond = 1'000'000;
constexpr Value kDatagram = 1400;          // bytes, fits any Ethernet frame
constexpr std::uint32_t kFirstId = 0x100;  // the first identifier that is assigned
constexpr std::uint32_t kMostBitrate = 1'000'000;
constexpr std::uint32_t kUsualBitrate = 500'000;
constexpr Value kMostBytes = 65'535;

bool is_interface_name(std::string_view name) {
  constexpr std::size_t most = 15;
  return !name.empty() && name.size() <= most && std::ranges::all_of(name, is_of_interface_name) &&
         std::string_view(".@+-").find(name.front()) == std::string_view::npos;
}

std::vector<std::string> parts_of(std::string_view text, char between) {
  std::vector<std::string> out;
  for (;;) {
    const auto end = text.find(between);
    out.emplace_back(text.substr(0, end));
    if (end == std::string_view::npos) return out;
    text.remove_prefix(end + 1);
  }
}

std::optional<std::size_t> network_called(const Plan& plan, std::string_view name) {
  const auto found = std::ranges::find(plan.networks, name, &PlannedNetwork::name);
  if (found == plan.networks.end()) return std::nullopt;
  return static_cast<std::size_t>(found - plan.networks.begin());
}

std::string network_names(const Plan& plan) {
  std::string out;
  for (const auto& network : plan.networks) out += (out.empty() ? "" : ", ") + network.name;
  return out;
}

bool is_can(const Plan& plan, std::size_t network) {
  return plan.networks[network].kind == core::NetworkKind::can;
}

class PlanWriter {
 public:
  PlanWriter(const Plan& plan, std::uint64_t (*random)()) : plan_(plan), random_(random) {}

  std::string write() {
    out_ =
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!--\n"
        "  A first description. Numbers in sections marked \"Assumed\" are to be replaced by what\n"
        "  your networks and gateway give: measure them.\n-->\n";
    put("<System name=\"{}\">\n", plan_.name);
    for (const auto& channel : plan_.channels) write(channel);
    for (std::size_t n = 0; n < plan_.networks.size(); ++n) write_network(n);
    if (!plan_.gateway.empty()) gateway();
    for (const auto& channel : plan_.channels) ends(channel);
    out_ += "</System>\n";
    return std::move(out_);
  }

 private:
  template <class... T>
  void put(fmt::format_string<T...> format, T&&... values) {
    fmt::format_to(std::back_inserter(out_), format, std::forward<T>(values)...);
  }

  void write(const PlannedChannel& channel) {
    put("  <EventChannel name=\"{}\">\n    <SubjectUID>0x{:016x}</SubjectUID>\n", channel.name,
        subject());
    AttributeSet attributes;
    attributes.set(Attribute::period, channel.period).set(Attribute::max_payload, channel.bytes);
    out_ += attribute_list("Attributes", attributes, "    ");
    out_ += "  </EventChannel>\n";
  }

  std::uint64_t subject() {
    for (;;)
      if (const auto next = random_(); next != 0 && subjects_.insert(next).second) return next;
  }

  void write_network(std::size_t n) {
    const auto& network = plan_.networks[n];
    const bool can = is_can(plan_, n);
    put("  <Network name=\"{}\">\n    <Kind>{}</Kind>\n    <Profile>{}</Profile>\n", network.name,
        core::words::kNetworkKinds.of(network.kind), can ? "raw" : "famouso");
    if (can)
      put("    <Bus bitrate=\"{}\"/>\n", network.bitrate);
    else
      provision(network.kind == core::NetworkKind::mesh);
    for (std::size_t c = 0; can && c < plan_.channels.size(); ++c)
      if (is_on(plan_.channels[c], n)) binding(c);
    out_ += "  </Network>\n";
  }

  void binding(std::size_t c) {
    const auto& channel = plan_.channels[c];
    put("    <Binding channel=\"{}\"{}><Identifier form=\"standard\">0x{:03x}</Identifier>"
        "</Binding>\n",
        channel.name, channel.bytes > core::kClassicBytes ? " format=\"fd\"" : "", kFirstId + c);
  }

  static bool is_on(const PlannedChannel& channel, std::size_t network) {
    return channel.from == network || std::ranges::find(channel.to, network) != channel.to.end();
  }

  /// Writes a provision. For a mesh it is only a best case, because links are known at run time.
  void provision(bool dynamic) {
    constexpr Value latency = 5 * kMillisecond;
    AttributeSet gives;
    gives.set(Attribute::latency, latency, dynamic)
        .set(Attribute::jitter, latency, dynamic)
        .set(Attribute::period, kMillisecond, dynamic)
        .set(Attribute::omission, 1)
        .set(Attribute::max_payload, kDatagram);
    out_ += "    <!-- Assumed. -->\n";
    out_ += attribute_list("Provision", gives, "    ");
  }

  void gateway() {
    AttributeSet gives;
    gives.set(Attribute::latency, kMillisecond)
        .set(Attribute::jitter, kMillisecond)
        .set(Attribute::omission, 0);
    put("  <Gateway name=\"{}\">\n    <!-- Assumed. -->\n", plan_.gateway);
    out_ += attribute_list("Provision", gives, "    ");
    for (const auto& network : plan_.networks)
      put("    <Port network=\"{}\"{}><Interface name=\"{}\"/></Port>\n", network.name,
          network.queue_length == 0 ? ""
                                    : fmt::format(" queue-length=\"{}\"", network.queue_length),
          network.interface);
    out_ += "  </Gateway>\n";
  }

  void ends(const PlannedChannel& channel) {
    put("  <Publisher channel=\"{}\" network=\"{}\"/>\n", channel.name,
        plan_.networks[channel.from].name);
    for (const auto to : channel.to)
      put("  <Subscriber channel=\"{}\" network=\"{}\"/>\n", channel.name, plan_.networks[to].name);
  }

  const Plan& plan_;
  std::uint64_t (*random_)();
  std::string out_;
  std::set<std::uint64_t> subjects_;
};

}  // namespace

std::string problem_of_planned_name(std::string_view name) {
  return description::is_valid(description::type::kName, name)
             ? std::string()
             : description::explain(description::type::kName, name);
}

Result<void> add_network(Plan& plan, std::string_view text) {
  const auto parts = parts_of(text, ':');
  if (parts.size() < 3 || parts.size() > 4)
    return fail(fmt::format(
        "'{}': must be NAME:KIND:INTERFACE, for a CAN bus perhaps with :BITRATE", text));
  PlannedNetwork next{
      .name = parts[0], .kind = {}, .interface = parts[2], .bitrate = kUsualBitrate};
  if (auto problem = problem_of_planned_name(next.name); !problem.empty())
    return fail(std::move(problem));
  if (network_called(plan, next.name))
    return fail(fmt::format("'{}': the name is taken", next.name));
  if (next.name == plan.gateway)
    return fail(
        fmt::format("'{}': is the name of the gateway: give one of the two another name "
                    "(--gateway)",
                    next.name));
  const auto kind = core::words::kNetworkKinds.find(parts[1]);
  if (!kind || *kind == core::NetworkKind::ieee802154 || *kind == core::NetworkKind::other)
    return fail(fmt::format("'{}': must be can, udp-multicast, udp-broadcast or mesh", parts[1]));
  next.kind = *kind;
  if (!is_interface_name(next.interface))
    return fail(
        fmt::format("'{}': must be up to 15 letters, digits or _ . @ + -, as the kernel "
                    "names interfaces",
                    next.interface));
  for (const auto& other : plan.networks)
    if (other.interface == next.interface)
      return fail(fmt::format("'{}': is the interface of {}", next.interface, other.name));
  if (parts.size() == 4) {
    if (next.kind != core::NetworkKind::can) return fail("a bit rate is for a CAN bus");
    const auto rate = parse_bus_rate(parts[3], kMostBitrate);
    if (!rate) return std::unexpected(rate.error());
    next.bitrate = *rate;
  }
  if (plan.networks.size() >= kMostPlannedNetworks)
    return fail(fmt::format("at most {} networks: add others to the file", kMostPlannedNetworks));
  plan.networks.push_back(std::move(next));
  return {};
}

namespace {

Result<void> check_size(const Plan& plan, const PlannedChannel& channel) {
  for (std::size_t n = 0; n < plan.networks.size(); ++n)
    if (is_can(plan, n) && channel.bytes > core::kClassicBytes &&
        (channel.from == n || std::ranges::find(channel.to, n) != channel.to.end()))
      return fail(fmt::format("'{}': a classic frame on {} has at most 8 bytes", channel.name,
                              plan.networks[n].name));
  return {};
}

}  // namespace

Result<void> add_channel(Plan& plan, std::string_view text) {
  const auto parts = parts_of(text, ':');
  if (parts.size() != 5)
    return fail(
        fmt::format("'{}': must be NAME:PERIOD:BYTES:FROM:TO, such as speed:50ms:8:bus:lan", text));
  PlannedChannel next;
  next.name = parts[0];
  if (auto problem = problem_of_planned_name(next.name); !problem.empty())
    return fail(std::move(problem));
  if (std::ranges::find(plan.channels, next.name, &PlannedChannel::name) != plan.channels.end())
    return fail(fmt::format("'{}': the name is taken", next.name));
  const auto period = parse_attribute("Period=" + parts[1], Role::offered);
  if (!period) return std::unexpected(period.error());
  next.period = period->value;
  if (next.period == 0) return fail(fmt::format("'{}': a Period is more than 0", text));
  const auto bytes = number_in<Value>(parts[2]);
  if (!bytes || *bytes == 0 || *bytes > kMostBytes)
    return fail(fmt::format("'{}': a number of bytes, 1 to {}", parts[2], kMostBytes));
  next.bytes = *bytes;
  const auto network = [&](const std::string& name) -> Result<std::size_t> {
    const auto found = network_called(plan, name);
    if (found) return *found;
    return fail(
        fmt::format("'{}': there is no such network; there are {}", name, network_names(plan)));
  };
  const auto from = network(parts[3]);
  if (!from) return std::unexpected(from.error());
  next.from = *from;
  for (const auto& name : parts_of(parts[4], ',')) {
    const auto to = network(name);
    if (!to) return std::unexpected(to.error());
    if (std::ranges::find(next.to, *to) == next.to.end()) next.to.push_back(*to);
  }
  if (auto done = check_size(plan, next); !done) return done;
  if (plan.channels.size() >= kMostPlannedChannels)
    return fail(fmt::format("at most {} channels: add others to the file", kMostPlannedChannels));
  plan.channels.push_back(std::move(next));
  return {};
}

std::string description_of(const Plan& plan, std::uint64_t (*random)()) {
  return PlanWriter(plan, random).write();
}

std::string description_that_holds(Plan& plan, std::uint64_t (*random)()) {
  std::string text = description_of(plan, random);
  auto system = description::read_memory(text, "draft", {}, description::Users::any);
  if (!system) return text;  // the caller reports why it cannot be read
  system->sort_bindings();
  const auto queues = lengthen_queues(*system);
  for (const auto& [network, frames] : queues) plan.networks[network].queue_length = frames;
  return queues.empty() ? text : description_of(plan, random);
}

}  // namespace mlcca::tools::design
