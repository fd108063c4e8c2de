// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/check/drawing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "core/model/text.hpp"

namespace mlcca::tools::design {
namespace {

using core::Place;

/// Inside the quotes of a label. dot reads entities there too.
std::string in_quotes(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\' || c == '"') out += '\\';
    if (c == '&')
      out += "&amp;";
    else
      out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out;
}

/// Class for the page's style sheet, and attributes that need no colour.
struct EdgeStyle {
  const char* name;
  const char* attributes;
};

EdgeStyle style_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::fit:
      return {"fit", R"(color="#1a7f37" style=solid)"};
    case Outcome::run_time:
      return {"run-time", R"(color="#b26a00" style=dashed)"};
    case Outcome::unfit:
      break;
  }
  return {"unfit", R"(color="#c62828" style="bold,dotted" penwidth=2.5 arrowhead=tee)"};
}

/// What is wrong comes first.
int rank_of(Outcome outcome) {
  if (outcome == Outcome::unfit) return 0;
  return outcome == Outcome::run_time ? 1 : 2;
}

bool is_dynamic(const AttributeSet& provision, const core::UserValues& user) {
  bool dynamic = std::ranges::any_of(user, &core::UserValue::dynamic);
  for (std::size_t i = 0; i < kAttributes; ++i) {
    const auto a = attribute_at(i);
    dynamic = dynamic || (provision.has(a) && provision.is_dynamic(a));
  }
  return dynamic;
}

std::string interface_words(const core::InterfaceIdentity& identity) {
  for (const auto* text : {&identity.name, &identity.alias, &identity.id_path, &identity.serial})
    if (!text->empty()) return *text;
  return {};
}

class Graph {
 public:
  Graph(const SystemReport& report, std::size_t number) : r_(report), s_(report.system) {
    for (const auto& p : s_.publishers) publishers_[p.channel].push_back(&p);
    for (const auto& p : s_.subscribers) subscribers_[p.channel].push_back(&p);
    prefix_ = fmt::format("s{}-", number);
  }

  Drawing draw() {
    put("digraph system {{\n");
    put("graph [bgcolor=transparent rankdir=LR fontname=\"sans-serif\" nodesep=0.3 "
        "id=\"{}graph\"]\n",
        prefix_);
    put("node [fontname=\"sans-serif\" fontsize=11]\nedge [fontname=\"sans-serif\" fontsize=9]\n");
    add_places();
    out_.aggregated = !is_small();
    if (out_.aggregated)
      add_bundles();
    else
      add_singles();
    put("}}\n");
    return std::move(out_);
  }

 private:
  template <class... Arguments>
  void put(fmt::format_string<Arguments...> form, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(out_.source), form, std::forward<Arguments>(arguments)...);
  }

  // --- places ------------------------------------------------------------------------------------

  /// Networks and gateways share kMaxNodes.
  [[nodiscard]] std::size_t drawn_networks() const {
    return std::min(s_.networks.size(), kMaxNodes - drawn_gateways());
  }
  [[nodiscard]] std::size_t drawn_gateways() const {
    return std::min(s_.gateways.size(), kMaxNodes / 2);
  }
  [[nodiscard]] bool is_drawn(Place p) const {
    return p.index < (p.kind == Place::Kind::network ? drawn_networks() : drawn_gateways());
  }
  static std::string id_of(Place p) {
    return fmt::format("{}{}", p.kind == Place::Kind::network ? 'n' : 'g', p.index);
  }

  void add_place(Place place, const char* shape, const std::string& kind, bool dynamic) {
    const auto id = id_of(place);
    put("{} [id=\"{}{}\" class=\"{}{}\" shape={} style={} label=\"{}\\n{}{}\"]\n", id, prefix_, id,
        place.kind == Place::Kind::network ? "network" : "gateway", dynamic ? " dynamic" : "",
        shape, dynamic ? "dashed" : "solid", in_quotes(name_of(s_, place)), in_quotes(kind),
        dynamic ? "\\ndynamic" : "");
  }

  void add_places() {
    for (std::size_t i = 0; i < drawn_networks(); ++i) {
      const auto& n = s_.networks[i];
      add_place({Place::Kind::network, i}, "ellipse", std::string(core::to_text(n.kind)),
                is_dynamic(n.provision, n.user));
    }
    out_.left_out += s_.networks.size() - drawn_networks();
    for (std::size_t i = 0; i < drawn_gateways(); ++i) {
      const auto& g = s_.gateways[i];
      add_place({Place::Kind::gateway, i}, "box", "gateway", is_dynamic(g.provision, g.user));
      for (const auto& port : g.ports)
        add_port({Place::Kind::gateway, i}, port, &port == g.ports.data());
    }
    out_.left_out += s_.gateways.size() - drawn_gateways();
  }

  /// The first network of a gateway stands before it, the others behind: a way reads from left to
  /// right.
  void add_port(Place gateway, const core::Port& port, bool first) {
    const Place network{Place::Kind::network, port.network};
    if (!is_drawn(network) || edges_ == kMaxEdges) {
      ++out_.left_out;
      return;
    }
    auto ends = std::pair(id_of(gateway), id_of(network));
    if (first) std::swap(ends.first, ends.second);
    put("{} -> {} [id=\"{}port{}\" class=\"port\" dir=none color=\"#57606a\" penwidth=2 "
        "label=\"{}\"]\n",
        ends.first, ends.second, prefix_, edges_++, in_quotes(interface_words(port.identity)));
  }

  // --- every delivery ----------------------------------------------------------------------------

  [[nodiscard]] bool is_small() const {
    if (s_.publishers.size() + s_.subscribers.size() > 2 * kMaxSingle) return false;
    if (s_.components.size() > 2 * kMaxSingle) return false;
    std::size_t deliveries = 0;
    for (const auto& [channel, from] : publishers_)
      if (const auto to = subscribers_.find(channel); to != subscribers_.end())
        deliveries += from.size() * to->second.size();
    return deliveries <= kMaxSingle;
  }

  /// Who listens stands behind its network, anyone else before it.
  void add_seat(const std::string& id, const std::string& name, Place place, bool behind) {
    put("{} [id=\"{}{}\" class=\"end\" shape=box style=rounded fontsize=10 label=\"{}\"]\n", id,
        prefix_, id, in_quotes(name));
    if (!is_drawn(place)) return;
    auto ends = std::pair(id, id_of(place));
    if (behind) std::swap(ends.first, ends.second);
    put("{} -> {} [id=\"{}seat-{}\" class=\"seat\" dir=none style=dotted color=\"#8c959f\"]\n",
        ends.first, ends.second, prefix_, id);
  }

  template <class End>
  [[nodiscard]] std::string id_of_end(const End& end, char letter,
                                      const std::vector<End>& all) const {
    if (end.component != core::kNoComponent) return fmt::format("c{}", end.component);
    return fmt::format("{}{}", letter, &end - all.data());
  }

  void add_singles() {
    std::vector<bool> publishes(s_.components.size(), false);
    for (const auto& p : s_.publishers) {
      if (p.component != core::kNoComponent)
        publishes[p.component] = true;
      else
        add_seat(id_of_end(p, 'p', s_.publishers), p.name, p.place, false);
    }
    for (const auto& p : s_.subscribers)
      if (p.component == core::kNoComponent)
        add_seat(id_of_end(p, 's', s_.subscribers), p.name, p.place, true);
    for (std::size_t i = 0; i < s_.components.size(); ++i)
      add_seat(fmt::format("c{}", i), s_.components[i].name, s_.components[i].place, !publishes[i]);
    for (std::size_t c = 0; c < r_.inspection.channels.size(); ++c)
      for (const auto* from : publishers_[c])
        for (const auto* to : subscribers_[c])
          add_edge(id_of_end(*from, 'p', s_.publishers), id_of_end(*to, 's', s_.subscribers),
                   r_.inspection.channels[c].outcome, s_.channels[c].name);
  }

  void add_edge(const std::string& from, const std::string& to, Outcome outcome,
                const std::string& label) {
    const auto style = style_of(outcome);
    put("{} -> {} [id=\"{}e{}\" class=\"channel {}\" {} constraint=false label=\"{}\"]\n", from, to,
        prefix_, edges_++, style.name, style.attributes, in_quotes(label));
  }

  // --- many deliveries ---------------------------------------------------------------------------

  using Bundle = std::tuple<Outcome, Place, Place>;

  template <class Ends>
  static std::set<Place> places_of(const Ends& ends) {
    std::set<Place> out;
    for (const auto* end : ends) out.insert(end->place);
    return out;
  }

  void add_bundles() {
    std::map<Bundle, std::size_t> channels;
    for (std::size_t c = 0; c < r_.inspection.channels.size(); ++c) {
      const auto from = places_of(publishers_[c]);
      const auto to = places_of(subscribers_[c]);
      for (const Place a : from)
        for (const Place b : to) ++channels[{r_.inspection.channels[c].outcome, a, b}];
    }
    std::vector<std::pair<Bundle, std::size_t>> sorted(channels.begin(), channels.end());
    std::erase_if(sorted, [&](const auto& bundle) {
      const bool hidden =
          !is_drawn(std::get<1>(bundle.first)) || !is_drawn(std::get<2>(bundle.first));
      out_.left_out += hidden ? 1 : 0;
      return hidden;
    });
    // What is wrong is shown first, then what stands for most.
    std::ranges::stable_sort(sorted, [](const auto& a, const auto& b) {
      return std::tuple(rank_of(std::get<0>(a.first)), b.second) <
             std::tuple(rank_of(std::get<0>(b.first)), a.second);
    });
    if (sorted.size() > kMaxEdges) {
      out_.left_out += sorted.size() - kMaxEdges;
      sorted.resize(kMaxEdges);
    }
    for (const auto& [bundle, count] : sorted)
      add_edge(id_of(std::get<1>(bundle)), id_of(std::get<2>(bundle)), std::get<0>(bundle),
               counted(count, "channel"));
  }

  const SystemReport& r_;
  const core::System& s_;
  std::string prefix_;
  std::map<std::size_t, std::vector<const core::Publisher*>> publishers_;  ///< by channel
  std::map<std::size_t, std::vector<const core::Subscriber*>> subscribers_;
  std::size_t edges_ = 0;
  Drawing out_;
};

}  // namespace

Drawing draw(const SystemReport& system, std::size_t number) {
  return Graph(system, number).draw();
}

}  // namespace mlcca::tools::design
