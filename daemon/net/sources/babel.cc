// SPDX-License-Identifier: BSD-2-Clause
// Lines of babeld's local interface: "add|change|flush interface|neighbour|route|xroute NAME" and
// then pairs of a word and its value. A reply ends with ok, no or bad.
#include "daemon/net/sources/babel.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

#include "daemon/net/sources/line_client.hpp"

namespace mlcca::net {
namespace babel {
namespace {

constexpr std::uint32_t kInfinity = 0xffff;
constexpr std::uint32_t kIdeal = 256;
constexpr Value kAll = 1'000'000'000;

/// The next word; `text` loses it.
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

/// A cost; what is missing or no number is infinite.
std::uint32_t cost_of(const std::map<std::string_view, std::string_view>& fields,
                      std::string_view key) {
  const std::string text = text_of(fields, key);
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool number = error == std::errc{} && end == text.data() + text.size();
  return number ? value : kInfinity;
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
  if (id.empty()) return Line::other;
  Fields fields;
  for (auto key = word(line); !key.empty(); key = word(line)) fields[key] = word(line);
  if (gone)
    flush(kind, id);
  else if (kind == "interface")
    take_interface(id, fields);
  else if (kind == "neighbour")
    take_neighbour(id, fields);
  else if (kind == "route")
    take_route(id, fields);
  else if (kind == "xroute")
    own_prefixes_[id] = text_of(fields, "prefix");
  else
    return Line::other;
  return Line::news;
}

void State::flush(std::string_view kind, const std::string& id) {
  if (kind == "interface") interfaces_.erase(id);
  if (kind == "neighbour") neighbours_.erase(id);
  if (kind == "route") routes_.erase(id);
  if (kind == "xroute") own_prefixes_.erase(id);
}

void State::take_interface(const std::string& name, const Fields& fields) {
  if (text_of(fields, "up") == "true")
    interfaces_[name] = {.ipv6 = text_of(fields, "ipv6"), .ipv4 = text_of(fields, "ipv4")};
  else
    interfaces_.erase(name);
}

void State::take_neighbour(const std::string& id, const Fields& fields) {
  neighbours_[id] = {.address = text_of(fields, "address"),
                     .interface = text_of(fields, "if"),
                     .rxcost = cost_of(fields, "rxcost"),
                     .txcost = cost_of(fields, "txcost"),
                     .cost = cost_of(fields, "cost")};
}

void State::take_route(const std::string& id, const Fields& fields) {
  routes_[id] = {.prefix = text_of(fields, "prefix"),
                 .via = text_of(fields, "via"),
                 .refmetric = cost_of(fields, "refmetric"),
                 .installed = text_of(fields, "installed") == "yes"};
}

std::string State::own_name(const std::string& interface) const {
  const auto it = interfaces_.find(interface);
  if (it == interfaces_.end()) return {};
  for (const auto& address : {it->second.ipv6, it->second.ipv4})
    if (described_.contains(address)) return address;
  for (const auto& [name, prefix] : own_prefixes_)
    if (const auto host = host_of(prefix); host && described_.contains(*host)) return *host;
  return it->second.ipv6;
}

std::string State::neighbour_name(const std::string& address) const {
  if (described_.contains(address)) return address;
  // A route that costs nothing beyond the neighbour is the neighbour's own.
  for (const auto& [id, route] : routes_) {
    if (route.via != address || route.refmetric != 0) continue;
    if (const auto host = host_of(route.prefix); host && described_.contains(*host)) return *host;
  }
  return address;
}

core::mesh::Snapshot State::snapshot() const {
  core::mesh::Snapshot out;
  std::map<std::string, std::string> own_side;  // of each neighbour, by its address
  for (const auto& [id, neighbour] : neighbours_) {
    const std::string own = own_name(neighbour.interface);
    if (own.empty() || neighbour.address.empty()) continue;
    own_side[neighbour.address] = own;
    core::mesh::Sample there;
    there.from = own;
    there.to = neighbour_name(neighbour.address);
    there.kind = core::mesh::RateKind::derived;
    there.weight = neighbour.cost;
    core::mesh::Sample back = there;
    std::swap(back.from, back.to);
    // What we count of a neighbour's hellos is our rxcost; what it counts of ours it tells us.
    there.loss = loss_of(neighbour.txcost);
    back.loss = loss_of(neighbour.rxcost);
    out.links.push_back(std::move(there));
    out.links.push_back(std::move(back));
  }
  for (const auto& [id, route] : routes_) {
    const auto host = host_of(route.prefix);
    const auto own = own_side.find(route.via);
    if (!route.installed || !host || own == own_side.end()) continue;
    out.next_hops.push_back({.from = own->second, .to = *host, .via = neighbour_name(route.via)});
  }
  return out;
}

}  // namespace babel

namespace {

constexpr std::uint64_t kPatience = 5'000'000;  // µs

/// Is told of changes as they happen, and asks for everything each second: an answer shows that
/// babeld is still there and means what it has said.
class Babel final : public LinkSource {
 public:
  Babel(Endpoint endpoint, std::set<std::string> described, sd_event* loop, Report report)
      : text_(endpoint.text),
        described_(std::move(described)),
        loop_(loop),
        report_(std::move(report)),
        state_(described_),
        client_(std::move(endpoint), kLookAgain, kPatience,
                {.connected = [this] { begin(); },
                 .line = [this](std::string_view line) { take(line); },
                 .ended = [this](const std::string& why) { lost(why); }}) {}

  Result<void> start() {
    if (auto timer = timer_.start(loop_, [this] { ask(); }); !timer) return timer;
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
      case babel::Line::news:
        // Changes are told at once, the lines of a dump together.
        if (dumped_ && !asked_) tell();
        break;
      case babel::Line::ok:
        answered();
        break;
    }
  }

  void answered() {
    if (!greeted_) {
      greeted_ = true;
      asked_ = true;
      client_.send("monitor\n");
      return;
    }
    asked_ = false;
    dumped_ = true;
    timer_.set(kLookAgain);
    tell();
  }

  void ask() {
    if (!dumped_ || asked_) return;
    asked_ = true;
    client_.send("dump\n");
  }

  void tell() {
    auto snapshot = state_.snapshot();
    stamp(snapshot, time_of(loop_));
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
  std::set<std::string> described_;
  sd_event* loop_;
  Report report_;
  babel::State state_;
  bool greeted_ = false;
  bool asked_ = false;   ///< for everything, and the answer is not complete
  bool dumped_ = false;  ///< everything is known
  Timer timer_;
  LineClient client_;
};

}  // namespace

Result<std::unique_ptr<LinkSource>> open_babel(const core::mesh::Source& source,
                                               const core::mesh::Mesh& mesh, sd_event* loop,
                                               LinkSource::Report report) {
  auto endpoint = parse_endpoint(source.endpoint);
  if (!endpoint) return std::unexpected(endpoint.error());
  std::set<std::string> described;
  for (const auto& node : mesh.nodes) described.insert(node.address);
  auto babel =
      std::make_unique<Babel>(std::move(*endpoint), std::move(described), loop, std::move(report));
  if (auto started = babel->start(); !started) return std::unexpected(started.error());
  return babel;
}

}  // namespace mlcca::net
