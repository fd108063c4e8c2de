// SPDX-License-Identifier: BSD-2-Clause
#include "tests/levels/random_system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <vector>

#include "tests/description/twin/random_values.hpp"

namespace mlcca::testing {
namespace {

constexpr std::uint64_t kNever = 1000000;

std::string stated(const std::string& name, const std::string& unit, std::uint64_t value,
                   int magnitude = 0, bool dynamic = false) {
  const auto dimension =
      unit.empty()
          ? std::string()
          : fmt::format("<Dimension><SIUnit>{}</SIUnit><Magnitude>{}</Magnitude></Dimension>", unit,
                        magnitude);
  return fmt::format("<Attribute{}><Name>{}</Name>{}<Value>{}</Value></Attribute>",
                     dynamic ? " dynamic=\"true\"" : "", name, dimension, value);
}

class Writer {
 public:
  explicit Writer(std::uint64_t seed) : random_(seed), seed_(seed) {}

  std::string write() {
    networks_ = 1 + random_.below(3);
    gateways_ = networks_ == 1 ? random_.below(2) : 1 + random_.below(3);
    own_ = random_.one_in(4);
    tight_ = random_.one_in(3);
    for (std::size_t n = 0; n < networks_; ++n) mesh_.push_back(random_.one_in(2));
    ports_.resize(gateways_);
    for (auto& ports : ports_)
      for (std::size_t n = 0; n < networks_; ++n)
        if (!random_.one_in(4)) ports.insert(n);
    for (auto& ports : ports_)
      if (ports.empty()) ports.insert(random_.below(networks_));
    const auto channels = 1 + random_.below(5);
    for (std::size_t c = 0; c < channels; ++c) sets_.push_back(random_.one_in(4) ? 2 : 1);
    std::string out = fmt::format("<System name=\"s{}\">\n", seed_);
    if (own_)
      out += fmt::format(
          "<UserAttribute name=\"Own\"><Better>smaller</Better><Composition>{}</Composition>"
          "</UserAttribute>\n",
          random_.one_in(2) ? "sum" : "maximum");
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

  std::string requirement() {
    static const std::vector<std::uint64_t> periods = {1000, 2000, 5000, 20000, 50000};
    std::string out;
    if (!random_.one_in(16)) out += seconds("Period", random_.one_of(periods));
    if (!random_.one_in(16)) out += bytes(random_.below(random_.one_in(6) ? 40 : 9));
    if (random_.one_in(4)) out += seconds("Latency", 200 + random_.below(tight_ ? 2000 : 40000));
    if (random_.one_in(6)) out += seconds("Deadline", 500 + random_.below(tight_ ? 4000 : 40000));
    if (random_.one_in(6)) out += stated("Omission", "", random_.below(4));
    if (random_.one_in(10)) out += rate(100 + random_.below(20000));
    if (own_ && random_.one_in(2)) out += stated("Own", "", 1 + random_.below(6));
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
    const auto best_case = [&] { return random_.one_in(8); };
    if (states()) out += seconds("Latency", random_.below(gateway ? 200 : 4000), best_case());
    if (states()) out += seconds("Jitter", random_.below(gateway ? 200 : 4000), best_case());
    if (!gateway && states()) out += seconds("Period", 100 + random_.below(10000), best_case());
    if (!random_.one_in(4)) out += stated("Omission", "", random_.below(3), 0, best_case());
    if (random_.one_in(3)) out += rate(2000 + random_.below(50000), best_case());
    if (!gateway && states()) out += bytes(8 + random_.below(40));
    if (own_ && !random_.one_in(4)) out += stated("Own", "", random_.below(4), 0, best_case());
    return "<Provision>" + out + "</Provision>";
  }

  std::string network(std::size_t n) { return mesh_[n] ? mesh(n) : bus(n); }

  std::string bus(std::size_t n) {
    static const std::vector<std::uint32_t> rates = {50000, 125000, 500000, 1000000};
    const bool computed = !random_.one_in(5);
    auto out = fmt::format("<Network name=\"n{}\"><Kind>can</Kind><Profile>famouso</Profile>", n);
    if (computed)
      out += fmt::format("<Bus bitrate=\"{}\"{}{}/>", random_.one_of(rates),
                         random_.one_in(4) ? " unknown-senders=\"true\"" : "",
                         random_.one_in(4) ? " data-bitrate=\"2000000\"" : "");
    if (!computed || !random_.one_in(3)) out += provision(computed ? 5 : 1, false);
    for (std::size_t c = 0; c < sets_.size(); ++c)
      out += fmt::format("<Binding channel=\"c{}\"{}><ETag>0x10{}</ETag></Binding>", c,
                         random_.one_in(20) ? " format=\"fd\"" : "", sets_.size() - c);
    return out + "</Network>\n";
  }

  std::string mesh(std::size_t n) {
    auto out = fmt::format("<Network name=\"n{}\"><Kind>mesh</Kind><Mesh>", n);
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
      out += fmt::format("<Link from=\"{}\" to=\"{}\" rate=\"{}\"/>", nodes[i], nodes[i + 1],
                         1000000 + random_.below(20000000));
    }
    if (linked && !random_.one_in(2)) out += "<Source kind=\"description\"/>";
    out += "</Mesh>";
    if (random_.one_in(2)) out += provision(4, false);
    return out + "</Network>\n";
  }

  std::string gateway(std::size_t g) {
    auto out = fmt::format("<Gateway name=\"g{}\">{}", g, provision(1, true));
    for (const std::size_t n : ports_[g])
      out += fmt::format("<Port network=\"n{0}\"{2}><Interface name=\"g{1}i{0}\"/></Port>", n, g,
                         random_.one_in(3) ? " sender=\"nobody-here\"" : "");
    return out + "</Gateway>\n";
  }

  /// Seats from which everybody can be reached, more or less.
  std::string seat(bool publishes, std::size_t node) {
    if (gateways_ != 0 && random_.one_in(4)) {
      const auto g = random_.below(gateways_);
      at_ = kNever;
      const bool named = std::ranges::any_of(ports_[g], [&](std::size_t n) { return !mesh_[n]; });
      return fmt::format(" gateway=\"g{}\"{}{}", g,
                         publishes && named ? fmt::format(" node=\"{}\"", node) : std::string(),
                         publishes ? fmt::format(" user=\"nobody-here-{}\"", node) : std::string());
    }
    at_ = random_.below(networks_);
    std::string out = fmt::format(" network=\"n{}\"", at_);
    if (mesh_[at_]) return out + " mesh-node=\"own\"";
    if (publishes) out += fmt::format(" node=\"{}\"", node);
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
      out += fmt::format("<Publisher name=\"p{}x{}\" channel=\"c{}\"", c, i, c);
      out += seat(true, 16 + 8 * c + static_cast<std::size_t>(i));
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
  bool own_ = false;
  bool tight_ = false;
  std::vector<bool> mesh_;
  std::vector<std::set<std::size_t>> ports_;
  std::vector<std::size_t> sets_;
  std::uint64_t at_ = kNever;
  std::set<std::pair<std::uint64_t, std::uint64_t>> declared_;
  std::string routes_;
};

}  // namespace

std::string random_system(std::uint64_t seed) { return Writer(seed).write(); }

}  // namespace mlcca::testing
