// SPDX-License-Identifier: BSD-2-Clause
// Lines of babeld's local interface: "add|change|flush interface|neighbour|route|xroute NAME",
// followed by pairs of a word and its value. A reply ends with ok, no or bad.
#include "tools/sources/babel.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "base/loop_timer.hpp"
#include "base/number.hpp"
#include "base/throttle.hpp"
#include "tools/sources/line_client.hpp"

namespace mlcca::net {
namespace babel {
namespace {

constexpr std::uint32_t kInfinity = 0xffff;
constexpr std::uint32_t kIdeal = 256;
constexpr Value kAll = 1'000'000'000;

/// Removes and returns the next word.
std::string_view word(std::string_view& text) {
  const auto begin = std::min(text.find_first_not_of(' '), text.size());
  const auto end = std::min(text.find(' ', begin), text.size());
  const auto found = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return found;
}

std::string text_of(const std::map<std::string_view, std::string_view>& fields,
                    std::string_view key) {
  const auto it = fields.find(key);
  return it == fields.end() ? std::string{} : std::string(it->second);
}

/// The cost in a field; infinite if it is missing or no number.
std::uint32_t cost_of(const std::map<std::string_view, std::string_view>& fields,
                      std::string_view key) {
  return number_in<std::uint32_t>(text_of(fields, key)).value_or(kInfinity);
}

}  // namespace

std::optional<Value> loss_of(std::uint32_t cost) {
  if (cost < kIdeal) return std::nullopt;
  if (cost >= kInfinity) return kAll;
  return kAll - kAll * kIdeal / cost;
}

std::optional<std::string> host_of(std::string_view prefix) {
  const auto slash = prefix.find('/');
  if (slash == std::string_view::npos) return std::nullopt;
  const auto host = prefix.substr(0, slash);
  const bool v6 = host.find(':') != std::string_view::npos;
  if (prefix.substr(slash + 1) != (v6 ? "128" : "32")) return std::nullopt;
  return std::string(host);
}

Line State::take(std::string_view line) {
  if (line.ends_with('\r')) line.remove_suffix(1);
  const auto verb = word(line);
  if (verb == "ok") return Line::ok;
  if (verb == "no" || verb == "bad") return Line::refused;
  const bool gone = verb == "flush";
  if (!gone && verb != "add" && verb != "change") return Line::other;
  const auto kind = word(line);
  const std::string id(word(line));
  static constexpr std::array kinds{"interface", "neighbour", "route", "xroute"};
  if (id.empty() || std::ranges::find(kinds, kind) == kinds.end()) return Line::other;
  if (id.size() > kMaxWord) return Line::too_much;
  Fields fields;
  for (auto key = word(line); !key.empty(); key = word(line)) {
    const auto value = word(line);
    if (fields.size() >= kMaxWords / 2 || value.size() > kMaxWord) return Line::too_much;
    fields[key] = value;
  }
  if (gone)
    flush(kind, id);
  else if (!take_entry(kind, id, fields))
    return Line::too_much;
  return Line::fact;
}

bool State::take_entry(std::string_view kind, const std::string& id, const Fields& fields) {
  if (kind == "interface") return take_interface(id, fields);
  if (kind == "neighbour") return take_neighbour(id, fields);
  if (kind == "route") return take_route(id, fields);
  return take_own_prefix(id, fields);
}

void State::flush(std::string_view kind, const std::string& id) {
  if (kind == "interface") interfaces_.erase(id);
  if (kind == "neighbour") neighbours_.erase(id);
  if (kind == "route") routes_.erase(id);
  if (kind == "xroute") own_hosts_.erase(id);
}

namespace {

template <class Map>
bool put(Map& map, const std::string& id, typename Map::mapped_type value, std::size_t most) {
  if (map.size() >= most && !map.contains(id)) return false;
  map.insert_or_assign(id, std::move(value));
  return true;
}

}  // namespace

bool State::take_interface(const std::string& name, const Fields& fields) {
  if (text_of(fields, "up") == "true")
    return put(interfaces_, name,
               {.ipv6 = text_of(fields, "ipv6"), .ipv4 = text_of(fields, "ipv4")}, kMaxInterfaces);
  interfaces_.erase(name);
  return true;
}

bool State::take_neighbour(const std::string& id, const Fields& fields) {
  return put(neighbours_, id,
             {.address = text_of(fields, "address"),
              .interface = text_of(fields, "if"),
              .rxcost = cost_of(fields, "rxcost"),
              .txcost = cost_of(fields, "txcost"),
              .cost = cost_of(fields, "cost")},
             kMaxNeighbours);
}

bool State::take_route(const std::string& id, const Fields& fields) {
  auto host = host_of(text_of(fields, "prefix"));
  if (!host) {
    routes_.erase(id);
    return true;
  }
  return put(routes_, id,
             {.host = std::move(*host),
              .via = text_of(fields, "via"),
              .refmetric = cost_of(fields, "refmetric"),
              .installed = text_of(fields, "installed") == "yes"},
             kMaxRoutes);
}

bool State::take_own_prefix(const std::string& id, const Fields& fields) {
  auto host = host_of(text_of(fields, "prefix"));
  if (host) return put(own_hosts_, id, std::move(*host), kMaxRoutes);
  own_hosts_.erase(id);
  return true;
}

/// The first described host route of this machine.
std::string State::own_host() const {
  for (const auto& [name, host] : own_hosts_)
    if (described_.contains(host)) return host;
  return {};
}

std::string State::own_name(const std::string& interface, const std::string& host) const {
  const auto it = interfaces_.find(interface);
  if (it == interfaces_.end()) return {};
  for (const auto& address : {it->second.ipv6, it->second.ipv4})
    if (described_.contains(address)) return address;
  return host.empty() ? it->second.ipv6 : host;
}

State::Names State::neighbours_by_host() const {
  Names out;
  // A route without further cost behind the neighbour is the neighbour's own.
  for (const auto& [id, route] : routes_)
    if (route.refmetric == 0 && described_.contains(route.host))
      out.try_emplace(route.via, route.host);
  return out;
}

std::string State::neighbour_name(const std::string& address, const Names& hosts) const {
  if (described_.contains(address)) return address;
  const auto host = hosts.find(address);
  return host == hosts.end() ? address : host->second;
}

core::mesh::Snapshot State::snapshot() const {
  core::mesh::Snapshot out;
  const Names hosts = neighbours_by_host();
  const std::string host = own_host();
  std::map<std::string, std::string> own_side;  // our end of the link to each neighbour, by its
                                                // address
  for (const auto& [id, neighbour] : neighbours_) {
    const std::string own = own_name(neighbour.interface, host);
    if (own.empty() || neighbour.address.empty()) continue;
    own_side[neighbour.address] = own;
    core::mesh::Sample there;
    there.from = own;
    there.to = neighbour_name(neighbour.address, hosts);
    there.kind = core::mesh::RateKind::derived;
    there.weight = neighbour.cost;
    core::mesh::Sample back = there;
    std::swap(back.from, back.to);
    // Our count of a neighbour's hellos is rxcost; its count of ours, which it reports, is txcost.
    there.loss = loss_of(neighbour.txcost);
    back.loss = loss_of(neighbour.rxcost);
    out.links.push_back(std::move(there));
    out.links.push_back(std::move(back));
  }
  for (const auto& [id, route] : routes_) {
    const auto own = own_side.find(route.via);
    if (!route.installed || own == own_side.end()) continue;
    out.next_hops.push_back(
        {.from = own->second, .to = route.host, .via = neighbour_name(route.via, hosts)});
  }
  return out;
}

}  // namespace babel

namespace {

constexpr std::uint64_t kPatience = 5'000'000;  // µs

/// Receives changes as they happen and requests a dump every second: an answer shows that babeld
/// still runs and that its reports still hold.
class Babel final : public LinkSource {
 public:
  Babel(Endpoint endpoint, core::mesh::DescribedNodes described, sd_event* loop, Report report)
      : text_(endpoint.text),
        described_(std::move(described)),
        loop_(loop),
        report_(std::move(report)),
        state_(described_),
        client_(std::move(endpoint), kPollInterval, kPatience,
                {.connected = [this] { begin(); },
                 .line = [this](std::string_view line) { take(line); },
                 .ended = [this](const std::string& why) { lost(why); }}) {}

  Result<void> start() {
    if (auto timer = timer_.start(loop_, [this] { ask(); }); !timer) return timer;
    if (auto started = throttle_.start(loop_, [this] { report(); }); !started) return started;
    return client_.start(loop_);
  }

 private:
  void begin() {
    state_ = babel::State(described_);
    greeted_ = false;
    dumped_ = false;
  }

  void take(std::string_view line) {
    switch (state_.take(line)) {
      case babel::Line::other:
        break;
      case babel::Line::refused:
        client_.end("it refuses to be monitored");
        break;
      case babel::Line::too_much:
        client_.end("it states more than is read of it: at most " +
                    std::to_string(babel::kMaxNeighbours) + " neighbours and " +
                    std::to_string(babel::kMaxRoutes) + " routes to single hosts");
        break;
      case babel::Line::fact:
        // Changes are reported at once, the lines of a dump together at its end.
        if (dumped_ && !asked_) throttle_.ask();
        break;
      case babel::Line::ok:
        answered();
        break;
    }
  }

  void answered() {
    client_.complete();
    if (!greeted_) {
      greeted_ = true;
      asked_ = true;
      client_.send("monitor\n");
      return;
    }
    asked_ = false;
    dumped_ = true;
    timer_.set(kPollInterval);
    throttle_.ask();
  }

  void ask() {
    if (!dumped_ || asked_) return;
    asked_ = true;
    client_.send("dump\n");
  }

  void report() {
    if (!dumped_ || asked_) return;  // the end of the answer will report
    auto snapshot = state_.snapshot();
    stamp(snapshot, loop_time(loop_));
    report_(std::move(snapshot));
  }

  void lost(const std::string& why) {
    asked_ = false;
    dumped_ = false;
    report_({.links = {},
             .next_hops = {},
             .problem = "babeld at " + text_ + ": " + (why.empty() ? "has closed" : why)});
  }

  std::string text_;
  core::mesh::DescribedNodes described_;
  sd_event* loop_;
  Report report_;
  babel::State state_;
  bool greeted_ = false;
  bool asked_ = false;   ///< a dump was requested and is not complete
  bool dumped_ = false;  ///< a complete dump was received
  LoopTimer timer_;
  Throttle throttle_;
  LineClient client_;
};

}  // namespace

Result<std::unique_ptr<LinkSource>> open_babel(const core::mesh::Source& source,
                                               const core::mesh::Mesh& mesh, sd_event* loop,
                                               LinkSource::Report report) {
  auto endpoint = parse_endpoint(source.endpoint);
  if (!endpoint) return std::unexpected(endpoint.error());
  auto babel =
      std::make_unique<Babel>(std::move(*endpoint), described_nodes(mesh), loop, std::move(report));
  if (auto started = babel->start(); !started) return std::unexpected(started.error());
  return babel;
}

}  // namespace mlcca::net
