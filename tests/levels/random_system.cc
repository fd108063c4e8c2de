// SPDX-License-Identifier: BSD-2-Clause
#include "tests/levels/random_system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ranges>
#include <set>
#include <string_view>
#include <vector>

#include "tests/description/twin/forms.hpp"
#include "tests/description/twin/random_values.hpp"

namespace mlcca::testing {
namespace {

constexpr std::uint64_t kNever = 1000000;
constexpr std::array<std::string_view, 5> kProfiles = {"famouso", "raw", "j1939", "cyphal",
                                                       "canopen"};
constexpr std::array<std::string_view, 3> kDatagrams = {"udp-multicast", "udp-broadcast",
                                                        "ieee802154"};

std::string stated(const std::string& name, const std::string& unit, std::uint64_t value,
                   int magnitude = 0, bool dynamic = false) {
  const auto dimension =
      unit.empty() && magnitude == 0
          ? std::string()
          : fmt::format("<Dimension><SIUnit>{}</SIUnit><Magnitude>{}</Magnitude></Dimension>", unit,
                        magnitude);
  return fmt::format("<Attribute{}><Name>{}</Name>{}<Value>{}</Value></Attribute>",
                     dynamic ? " dynamic=\"true\"" : "", name, dimension, value);
}

/// An attribute that the description defines: values from 0, and how bad a large one is.
struct Own {
  std::string name;
  std::string composition;
  int magnitude = 0;
};

constexpr std::uint64_t kPayloads = 40;

class Writer {
 public:
  explicit Writer(std::uint64_t seed) : random_(seed), seed_(seed) {}

  std::string write() {
    networks_ = 1 + random_.below(3);
    gateways_ = networks_ == 1 ? random_.below(2) : 1 + random_.below(3);
    choose_own();
    tight_ = random_.one_in(3);
    jittery_ = random_.one_in(4);
    slow_ = random_.one_in(4);
    scarce_ = !slow_ && random_.one_in(4);
    for (std::size_t n = 0; n < networks_; ++n) {
      mesh_.push_back(random_.one_in(2));
      udp_.push_back(!mesh_.back() && random_.one_in(6));
      profiles_.push_back(random_.one_in(3) ? random_.below(kProfiles.size()) : 0);
    }
    ports_.resize(gateways_);
    for (auto& ports : ports_)
      for (std::size_t n = 0; n < networks_; ++n)
        if (!random_.one_in(4)) ports.insert(n);
    for (auto& ports : ports_)
      if (ports.empty()) ports.insert(random_.below(networks_));
    numbered_ =
        std::ranges::any_of(std::views::iota(std::size_t{0}, networks_),
                            [&](std::size_t n) { return is_bus(n) && !is_without_nodes(n); });
    short_ = std::ranges::any_of(std::views::iota(std::size_t{0}, networks_),
                                 [&](std::size_t n) { return is_bus(n) && is_without_nodes(n); });
    long_ = random_.one_in(4) && std::ranges::none_of(std::views::iota(std::size_t{0}, networks_),
                                                      [&](std::size_t n) { return is_bus(n); });
    const auto channels = 1 + random_.below(5);
    for (std::size_t c = 0; c < channels; ++c) sets_.push_back(random_.one_in(4) ? 2 : 1);
    std::string out = fmt::format("<System name=\"s{}\">\n", seed_);
    for (const Own& own : own_)
      out += fmt::format(
          "<UserAttribute name=\"{}\"><Dimension><Magnitude>{}</Magnitude></Dimension>"
          "<Better>{}</Better><Composition>{}</Composition></UserAttribute>\n",
          own.name, own.magnitude, own.composition == "minimum" ? "larger" : "smaller",
          own.composition);
    for (std::size_t c = 0; c < channels; ++c) out += channel(c);
    for (std::size_t n = 0; n < networks_; ++n) out += network(n);
    for (std::size_t g = 0; g < gateways_; ++g) out += gateway(g);
    for (std::size_t c = 0; c < channels; ++c) out += ends(c);
    return out + routes_ + "</System>\n";
  }

 private:
  std::string seconds(const std::string& name, std::uint64_t microseconds, bool dynamic = false) {
    return stated(name, "<Seconds>1</Seconds>", microseconds, -6, dynamic);
  }
  std::string bytes(std::uint64_t count) { return stated("MaxPayload", "<Bytes>1</Bytes>", count); }
  std::string rate(std::uint64_t bytes_per_second, bool dynamic = false) {
    return stated("Bandwidth", "<Bytes>1</Bytes><Seconds>-1</Seconds>", bytes_per_second, 0,
                  dynamic);
  }

  /// Their frames name no sender and have no fragments.
  [[nodiscard]] bool is_without_nodes(std::size_t n) const {
    const auto& profile = kProfiles.at(profiles_[n]);
    return profile == "raw" || profile == "canopen";
  }
  [[nodiscard]] bool is_bus(std::size_t n) const { return !mesh_[n] && !udp_[n]; }

  void choose_own() {
    static const std::vector<std::string> compositions = {"sum", "maximum", "minimum", "survival"};
    const auto count = random_.one_in(3) ? 1 + random_.below(2) : 0;
    for (std::uint64_t i = 0; i < count; ++i) {
      const auto& composition = random_.one_of(compositions);
      const bool survival = composition == "survival";
      own_.push_back({fmt::format("Own{}", i), composition,
                      survival ? -9 : static_cast<int>(random_.below(5)) - 2});
    }
  }
  std::string own_value(const Own& own, std::uint64_t value, bool dynamic = false) {
    if (own.composition == "survival") return stated(own.name, "", value, -3, dynamic);
    return stated(own.name, "", value, own.magnitude + static_cast<int>(random_.below(2)), dynamic);
  }

  std::string requirement() {
    static const std::vector<std::uint64_t> periods = {1000, 2000, 5000, 20000, 50000};
    std::string out;
    // Messages of J1939 take half a second and more.
    if (!random_.one_in(16)) out += seconds("Period", slow_ ? 5'000'000 : random_.one_of(periods));
    static const std::vector<std::uint64_t> longs = {100, 103, 300, 1500, 65000, 70000};
    if (!random_.one_in(16))
      out +=
          bytes(long_ && random_.one_in(2) ? random_.one_of(longs)
                                           : random_.below(random_.one_in(6) && !short_ ? 40 : 9));
    if (random_.one_in(4))
      out += seconds("Latency", (200 + random_.below(tight_ ? 2000 : 40000)) * (slow_ ? 100 : 1));
    if (random_.one_in(6))
      out += seconds("Deadline", (500 + random_.below(tight_ ? 4000 : 40000)) * (slow_ ? 100 : 1));
    if (random_.one_in(6)) out += stated("Omission", "", random_.below(4));
    if (random_.one_in(10)) out += rate(100 + random_.below(20000));
    if (random_.one_in(jittery_ ? 2 : 20))
      out += seconds("Jitter", random_.below(tight_ ? 900 : 9000));
    if (random_.one_in(12)) out += stated("PacketLoss", "", random_.below(200), -3);
    for (const Own& own : own_)
      if (random_.one_in(2)) out += own_value(own, 1 + random_.below(6));
    return out;
  }

  std::string channel(std::size_t c) {
    std::string sets;
    for (std::size_t set = 0; set < sets_[c]; ++set)
      sets += fmt::format("<Attributes{}>{}</Attributes>",
                          sets_[c] > 1 ? fmt::format(" priority=\"{}\"", 9 - set) : std::string(),
                          requirement());
    const auto importance = random_.one_in(5) ? random_.below(200) : 0;
    return fmt::format(
        "<EventChannel name=\"c{}\"{}><SubjectUID>0x{}</SubjectUID>{}</EventChannel>\n", c,
        importance != 0 ? fmt::format(" importance=\"{}\"", importance) : std::string(), c + 1,
        sets);
  }

  std::string provision(std::uint64_t one_in, bool gateway) {
    std::string out;
    const auto states = [&] { return random_.one_in(one_in); };
    const auto best_case = [&] { return random_.one_in(scarce_ ? 16 : 8); };
    if (states()) out += seconds("Latency", random_.below(gateway ? 200 : 4000), best_case());
    if (states()) out += seconds("Jitter", random_.below(gateway ? 200 : 4000), best_case());
    if (!gateway && states()) out += seconds("Period", 100 + random_.below(10000), best_case());
    if (!random_.one_in(4)) out += stated("Omission", "", random_.below(3), 0, best_case());
    if (scarce_ || random_.one_in(3))
      out += rate((scarce_ ? 500 : 2000) + random_.below(scarce_ ? 8000 : 50000), best_case());
    if (!gateway && states()) out += bytes(8 + random_.below(payloads_));
    if (random_.one_in(4)) out += stated("PacketLoss", "", random_.below(50), -3, best_case());
    for (const Own& own : own_)
      if (!random_.one_in(4))
        out += own_value(own, random_.below(own.composition == "minimum" ? 9 : 4), best_case());
    return "<Provision>" + out + "</Provision>";
  }

  std::string network(std::size_t n) { return mesh_[n] ? mesh(n) : udp_[n] ? udp(n) : bus(n); }

  std::string udp(std::size_t n) {
    const auto& kind = kDatagrams.at(random_.below(kDatagrams.size()));
    if (long_) payloads_ = kind == "ieee802154" ? 90 : 65'000;
    auto out =
        fmt::format("<Network name=\"n{}\"><Kind>{}</Kind>{}{}</Network>\n", n, kind,
                    random_.one_in(2) ? "<Profile>famouso</Profile>" : "", provision(1, false));
    payloads_ = kPayloads;
    return out;
  }

  std::string binding(std::size_t n, std::size_t c) {
    const auto number = 0x100 + sets_.size() - c;
    const auto& profile = kProfiles.at(profiles_[n]);
    if (profile == "famouso") return fmt::format("<ETag>{:#x}</ETag>", number);
    if (profile == "j1939")
      return fmt::format("<PGN{}>{}</PGN>",
                         random_.one_in(2) ? fmt::format(" priority=\"{}\"", random_.below(8)) : "",
                         65000 + number);
    if (profile == "cyphal")
      return fmt::format("<SubjectID{}>{}</SubjectID>",
                         random_.one_in(2) ? fmt::format(" priority=\"{}\"", random_.below(8)) : "",
                         number);
    if (profile == "canopen") return fmt::format("<COBID>{:#x}</COBID>", 0x180 + number - 0x100);
    return fmt::format("<Identifier form=\"{}\">{:#x}</Identifier>",
                       random_.one_in(3) ? "extended" : "standard", number);
  }

  std::string bus(std::size_t n) {
    static const std::vector<std::uint32_t> rates = {50000, 125000, 500000, 1000000};
    const bool computed = !random_.one_in(5);
    auto out = fmt::format("<Network name=\"n{}\"><Kind>can</Kind><Profile>{}</Profile>", n,
                           kProfiles.at(profiles_[n]));
    if (computed)
      out += fmt::format("<Bus bitrate=\"{}\"{}{}{}{}/>",
                         scarce_ ? rates.front() : random_.one_of(rates),
                         random_.one_in(8) ? " background-load=\"0.05\"" : "",
                         random_.one_in(8) ? " errors=\"1\" error-interval=\"0.02\"" : "",
                         random_.one_in(4) ? " unknown-senders=\"true\"" : "",
                         random_.one_in(4) ? " data-bitrate=\"2000000\"" : "");
    if (!computed || !random_.one_in(3)) out += provision(computed ? 5 : 1, false);
    for (std::size_t c = 0; c < sets_.size(); ++c)
      out += fmt::format(
          "<Binding channel=\"c{}\"{}>{}</Binding>", c,
          random_.one_in(20) && kProfiles.at(profiles_[n]) != "j1939" ? " format=\"fd\"" : "",
          binding(n, c));
    return out + "</Network>\n";
  }

  std::string mesh(std::size_t n) {
    static const std::vector<std::string> ways = {"",
                                                  "",
                                                  "",
                                                  " interference=\"k-hop\" hops=\"1\"",
                                                  " interference=\"channel\"",
                                                  " limit=\"0.5\" packet-time=\"0.0001\""};
    auto out =
        fmt::format("<Network name=\"n{}\"><Kind>mesh</Kind><Mesh{}>", n, random_.one_of(ways));
    if (!random_.one_in(4)) {
      out += "<PerHop>";
      if (!random_.one_in(4)) out += seconds("Latency", 100 + random_.below(4000));
      if (!random_.one_in(4)) out += seconds("Jitter", random_.below(2000));
      if (random_.one_in(2)) out += stated("Omission", "", random_.below(3));
      if (random_.one_in(2)) out += stated("PacketLoss", "", random_.below(2));
      out += "</PerHop>";
    }
    std::vector<std::string> nodes = {"own"};
    for (std::size_t g = 0; g < gateways_; ++g)
      if (ports_[g].contains(n)) nodes.push_back(fmt::format("g{}", g));
    for (std::size_t i = 0; i < nodes.size(); ++i)
      out += fmt::format("<Node name=\"{}\" address=\"02:00:00:00:00:0{}\"{}/>", nodes[i], i,
                         i > 0 ? fmt::format(" gateway=\"{}\"", nodes[i]) : std::string());
    bool linked = false;
    for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
      if (random_.one_in(8)) continue;
      linked = true;
      out += fmt::format(
          "<Link from=\"{}\" to=\"{}\" rate=\"{}\"{}{}{}/>", nodes[i], nodes[i + 1],
          random_.one_in(8) ? 2000 + random_.below(20000) : 1000000 + random_.below(20000000),
          random_.one_in(6) ? " loss=\"0.05\"" : "",
          random_.one_in(3) ? fmt::format(" channel=\"{}\"", 1 + i % 2) : "",
          random_.one_in(6) ? " kind=\"effective\"" : "");
    }
    if (nodes.size() > 2 && random_.one_in(3)) {
      linked = true;  // a ring
      out += fmt::format("<Link from=\"{}\" to=\"{}\" rate=\"{}\"{}/>", nodes.back(), nodes[0],
                         1000000 + random_.below(20000000),
                         random_.one_in(3) ? " both-ways=\"false\"" : "");
    }
    const bool elsewhere = random_.one_in(4);
    if (elsewhere) out += "<Source kind=\"file\" endpoint=\"/nowhere\"/>";
    if (linked && (elsewhere || random_.one_in(2))) out += "<Source kind=\"description\"/>";
    out += "</Mesh>";
    if (random_.one_in(2)) out += provision(4, false);
    return out + "</Network>\n";
  }

  std::string gateway(std::size_t g) {
    auto out = fmt::format("<Gateway name=\"g{}\">{}", g, provision(1, true));
    for (const std::size_t n : ports_[g])
      out += fmt::format("<Port network=\"n{0}\"{2}{3}><Interface name=\"g{1}i{0}\"/></Port>", n, g,
                         random_.one_in(3) ? " sender=\"nobody-here\"" : "",
                         is_bus(n) ? queue() : std::string());
    return out + "</Gateway>\n";
  }

  std::string queue() {
    std::string out;
    if (random_.one_in(3)) out += " queue=\"priority\"";
    if (random_.one_in(6)) out += fmt::format(" fifo-depth=\"{}\"", 1 + random_.below(4));
    if (random_.one_in(6)) out += fmt::format(" queue-length=\"{}\"", 1 + random_.below(20));
    return out;
  }

  /// Seats from which every other can be reached, more or less.
  std::string seat(bool publishes, std::size_t node) {
    if (gateways_ != 0 && random_.one_in(4)) {
      const auto g = random_.below(gateways_);
      at_ = kNever;
      return fmt::format(" gateway=\"g{}\"{}{}", g,
                         publishes && numbered_ ? fmt::format(" node=\"{}\"", node) : std::string(),
                         publishes ? fmt::format(" user=\"nobody-here-{}\"", node) : std::string());
    }
    at_ = random_.below(networks_);
    std::string out = fmt::format(" network=\"n{}\"", at_);
    if (mesh_[at_]) return out + " mesh-node=\"own\"";
    if (publishes && numbered_) out += fmt::format(" node=\"{}\"", node);
    return out;
  }

  std::string own_attributes() {
    return random_.one_in(4) ? "<Attributes>" + requirement() + "</Attributes>" : std::string();
  }

  std::string ends(std::size_t c) {
    std::string out;
    const auto publishers = random_.one_in(12) ? 0 : random_.one_in(5) ? 2 : 1;
    const auto subscribers = random_.one_in(12) ? 0 : 1 + random_.below(2);
    std::vector<std::uint64_t> from;
    for (int i = 0; i < publishers; ++i) {
      const auto at = seat(true, 16 + 8 * c + static_cast<std::size_t>(i));
      if (at_ != kNever && is_bus(at_) && is_without_nodes(at_) &&
          std::ranges::find(from, at_) != from.end())
        continue;  // an identifier has one sender on a bus
      out += fmt::format("<Publisher name=\"p{}x{}\" channel=\"c{}\"{}", c, i, c, at);
      out += ">" + own_attributes() + "</Publisher>\n";
      from.push_back(at_);
    }
    for (std::uint64_t i = 0; i < subscribers; ++i) {
      out += fmt::format("<Subscriber name=\"q{}x{}\" channel=\"c{}\"", c, i, c);
      out += seat(false, 0) + ">" + own_attributes() + "</Subscriber>\n";
      for (const auto start : from) declare(start, at_);
    }
    return out;
  }

  /// The twin knows no other way than one that is declared.
  void declare(std::uint64_t from, std::uint64_t to) {
    if (from == kNever || to == kNever || from == to || random_.one_in(2)) return;
    if (!declared_.insert(std::minmax(from, to)).second) return;
    for (std::size_t g = 0; g < gateways_; ++g) {
      if (!ports_[g].contains(from) || !ports_[g].contains(to)) continue;
      routes_ +=
          fmt::format("<Route from=\"n{}\" to=\"n{}\"><Hop place=\"g{}\"/></Route>\n", from, to, g);
      return;
    }
  }

  Random random_;
  std::uint64_t seed_;
  std::size_t networks_ = 0;
  std::size_t gateways_ = 0;
  std::vector<Own> own_;
  bool tight_ = false;
  bool slow_ = false;    ///< periods are long
  bool scarce_ = false;  ///< there is not room for all
  bool jittery_ = false;
  bool numbered_ = false;               ///< some network's frames carry their node
  bool short_ = false;                  ///< some network has no fragments
  std::uint64_t payloads_ = kPayloads;  ///< that a network may state, beyond 8
  bool long_ = false;                   ///< no network is a bus, and events may be long
  std::vector<bool> mesh_;
  std::vector<bool> udp_;
  std::vector<std::size_t> profiles_;  ///< of buses
  std::vector<std::set<std::size_t>> ports_;
  std::vector<std::size_t> sets_;
  std::uint64_t at_ = kNever;
  std::set<std::pair<std::uint64_t, std::uint64_t>> declared_;
  std::string routes_;
};

}  // namespace

std::string random_system(std::uint64_t seed) { return in_some_forms(Writer(seed).write(), seed); }

}  // namespace mlcca::testing
