// SPDX-License-Identifier: BSD-2-Clause
#include "tests/description/twin/random_description.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "tests/description/twin/forms.hpp"
#include "tests/description/twin/random_values.hpp"

namespace mlcca::testing {
namespace {

enum class Frames : std::uint8_t { none, raw, famouso };

struct Network {
  std::string name;
  Frames frames = Frames::none;
};

struct Gateway {
  std::string name;
  std::vector<std::size_t> networks;
};

/// Networks come first, gateways after them.
using Place = std::size_t;

struct Channel {
  std::string name;  ///< empty: the subject
  std::uint64_t subject = 0;
};

std::string attribute(const std::string& name, const std::string& value) {
  return value.empty() ? "" : " " + name + "=\"" + value + "\"";
}

class Writer {
 public:
  explicit Writer(std::uint64_t seed) : random_(seed), numbers_(random_) {}

  std::string write() {
    choose_networks();
    choose_gateways();
    choose_quantities();
    choose_channels();
    write_channels();
    write_networks();
    write_gateways();
    for (const auto& channel : channels_) write_ends(channel);
    write_components();
    std::string out = "<System name=\"s\">\n";
    while (!parts_.empty()) {
      std::swap(parts_[random_.below(parts_.size())], parts_.back());
      out += parts_.back() + "\n";
      parts_.pop_back();
    }
    return out + "</System>\n";
  }

 private:
  // --- what there is -----------------------------------------------------------------------------

  void choose_networks() {
    const auto count = 1 + random_.below(4);
    for (std::size_t i = 0; i < count; ++i)
      networks_.push_back(
          {"n" + std::to_string(i), static_cast<Frames>(random_.one_in(2) ? 0 : random_.below(3))});
    const auto has = [&](Frames frames) {
      return std::ranges::find(networks_, frames, &Network::frames) != networks_.end();
    };
    has_famouso_ = has(Frames::famouso);
    long_frames_ = random_.one_in(2);
    most_payload_ = ~std::uint64_t{0} - 1;
    if (has_famouso_) most_payload_ = 24608;
    if (has(Frames::raw)) most_payload_ = long_frames_ ? 64 : 8;
    fragments_ = has_famouso_ && most_payload_ > 8;
  }

  void choose_gateways() {
    const auto count = random_.below(4);
    for (std::size_t i = 0; i < count; ++i) {
      Gateway gateway{"g" + std::to_string(i), {}};
      for (std::size_t n = 0; n < networks_.size(); ++n)
        if (!random_.one_in(3)) gateway.networks.push_back(n);
      if (gateway.networks.empty()) gateway.networks.push_back(random_.below(networks_.size()));
      gateways_.push_back(std::move(gateway));
    }
  }

  void choose_quantities() {
    quantities_ = built_in_quantities(most_payload_);
    const auto users = random_.one_in(3) ? random_.below(3) : 0;
    for (std::size_t i = 0; i < users; ++i) {
      quantities_.push_back(user_quantity(random_, "Own" + std::to_string(i)));
      parts_.push_back(quantities_.back().definition);
    }
    easy_ = random_.one_in(2);
    demanding_ = easy_ ? 12 : 2 + random_.below(5);
  }

  void choose_channels() {
    std::set<std::uint64_t> subjects;
    const auto count = 1 + random_.below(6);
    for (std::size_t i = 0; i < count; ++i) {
      Channel channel;
      while (channel.subject == 0 || !subjects.insert(channel.subject).second)
        channel.subject = random_.any() >> random_.below(64);
      if (!random_.one_in(4)) channel.name = "c" + std::to_string(i);
      channels_.push_back(channel);
    }
  }

  // --- text --------------------------------------------------------------------------------------

  std::string hex(std::uint64_t subject) {
    static constexpr std::string_view lower = "0123456789abcdef";
    static constexpr std::string_view upper = "0123456789ABCDEF";
    std::string text;
    const bool whole = random_.one_in(2);
    for (int shift = 60; shift >= 0; shift -= 4) {
      const auto digit = (subject >> static_cast<unsigned>(shift)) & 15;
      if (digit != 0 || !text.empty() || whole) text += (random_.one_in(2) ? lower : upper)[digit];
    }
    return "0x" + text;
  }

  std::string reference(const Channel& channel) {
    return channel.name.empty() || random_.one_in(3) ? hex(channel.subject) : channel.name;
  }

  std::string requirement(std::size_t one_in) {
    std::string out;
    for (const auto& quantity : quantities_)
      if (random_.one_in(one_in))
        out += "<Attribute>" + numbers_.attribute(random_, quantity) + "</Attribute>";
    return out;
  }

  std::string attributes(std::size_t one_in) {
    return random_.one_in(4) ? "" : "<Attributes>" + requirement(one_in) + "</Attributes>";
  }

  std::string provision(std::size_t without) {
    std::string out;
    for (const auto& quantity : quantities_) {
      if (!quantity.providable || random_.one_in(without)) continue;
      static const std::vector<std::string> marks = {"", "", "", "", "true", "1", "false"};
      const bool extreme = (quantity.survival && fragments_) || (easy_ && !random_.one_in(3));
      out += "<Attribute" + attribute("dynamic", random_.one_of(marks)) + ">" +
             (extreme ? Numbers::attribute(random_, quantity, easy_ || random_.one_in(2))
                      : numbers_.attribute(random_, quantity)) +
             "</Attribute>";
    }
    return "<Provision" + attribute("dynamic", random_.one_in(8) ? "true" : "") + ">" + out +
           "</Provision>";
  }

  // --- elements ----------------------------------------------------------------------------------

  void write_channels() {
    for (const auto& channel : channels_) {
      static const std::vector<std::string> sides = {"", "", "drop", "deliver"};
      const std::string side = random_.one_of(sides);
      const auto text =
          "<EventChannel" + attribute("name", channel.name) + attribute("safe-side", side) +
          attribute("arrival", side != "drop" && random_.one_in(4) ? "sporadic" : "") +
          "><SubjectUID>" + hex(channel.subject) + "</SubjectUID>" + attributes(demanding_) +
          "</EventChannel>";
      if (random_.one_in(4))
        in_component_ += text;
      else
        parts_.push_back(text);
    }
  }

  void write_networks() {
    static const std::vector<std::string> kinds = {"mesh", "udp-multicast", "ieee802154", "other"};
    for (const auto& network : networks_) {
      std::string out = "<Network" + attribute("name", network.name) + "><Kind>";
      if (network.frames == Frames::none)
        out += random_.one_of(kinds) + "</Kind>";
      else
        out += std::string("can</Kind><Profile>") +
               (network.frames == Frames::raw ? "raw" : "famouso") + "</Profile>";
      out += provision(20);
      for (std::size_t i = 0; i < channels_.size() && network.frames != Frames::none; ++i)
        out += binding(network, i);
      parts_.push_back(out + "</Network>");
    }
  }

  std::string binding(const Network& network, std::size_t i) {
    static const std::vector<std::string> formats = {"", "classic", "fd", "any"};
    const bool raw = network.frames == Frames::raw;
    std::string format = random_.one_of(formats);
    if (raw) format = !long_frames_ ? "" : random_.one_in(2) ? "fd" : "any";
    return "<Binding channel=\"" + reference(channels_[i]) + "\"" + attribute("format", format) +
           ">" +
           (raw ? "<Identifier form=\"standard\">0x" + std::to_string(i + 1) + "</Identifier>"
                : "<ETag>0x10" + std::to_string(i) + "</ETag>") +
           "</Binding>";
  }

  void write_gateways() {
    for (const auto& gateway : gateways_) {
      std::string out = "<Gateway" + attribute("name", gateway.name) + ">" + provision(6);
      for (const auto network : gateway.networks)
        out += "<Port network=\"" + networks_[network].name + "\"" +
               attribute("managed", random_.one_in(8) ? "true" : "") +
               attribute("sender", random_.one_in(8) ? "1000" : "") + "><Interface name=\"" +
               gateway.name + "p" + std::to_string(network) + "\"/></Port>";
      parts_.push_back(out + "</Gateway>");
    }
  }

  // --- places and routes -------------------------------------------------------------------------

  [[nodiscard]] bool is_gateway(Place place) const { return place >= networks_.size(); }
  [[nodiscard]] const Gateway& gateway_at(Place place) const {
    return gateways_[place - networks_.size()];
  }
  [[nodiscard]] const std::string& name_of(Place place) const {
    return is_gateway(place) ? gateway_at(place).name : networks_[place].name;
  }

  [[nodiscard]] std::vector<Place> neighbours(Place place) const {
    if (is_gateway(place)) return gateway_at(place).networks;
    std::vector<Place> out;
    for (Place g = networks_.size(); g < networks_.size() + gateways_.size(); ++g)
      if (std::ranges::find(gateway_at(g).networks, place) != gateway_at(g).networks.end())
        out.push_back(g);
    return out;
  }

  /// Where a FAMOUSO node may be stated, which a publisher needs if its events may cross such a
  /// bus.
  [[nodiscard]] bool speaks_famouso(Place place) const {
    const auto speaks = [&](Place n) { return networks_[n].frames == Frames::famouso; };
    return is_gateway(place) ? std::ranges::any_of(gateway_at(place).networks, speaks)
                             : speaks(place);
  }

  /// Extends `path` to some way without a loop; false if there is none.
  bool walk(std::vector<Place>& path, Place to) {
    if (path.back() == to) return true;
    auto next = neighbours(path.back());
    while (!next.empty()) {
      std::swap(next[random_.below(next.size())], next.back());
      const Place place = next.back();
      next.pop_back();
      if (std::ranges::find(path, place) != path.end()) continue;
      path.push_back(place);
      if (walk(path, to)) return true;
      path.pop_back();
    }
    return false;
  }

  void declare_route(Place from, Place to) {
    if (from == to || !declared_.insert(std::minmax(from, to)).second) return;
    if (random_.one_in(2)) std::swap(from, to);
    std::vector<Place> path = {from};
    walk(path, to);
    std::string out = "<Route from=\"" + name_of(from) + "\" to=\"" + name_of(to) + "\">";
    for (std::size_t i = 1; i + 1 < path.size(); ++i)
      out += "<Hop place=\"" + name_of(path[i]) + "\"/>";
    parts_.push_back(out + "</Route>");
  }

  // --- publishers and subscribers ----------------------------------------------------------------

  void write_ends(const Channel& channel) {
    std::vector<Place> reachable;
    const Place anchor = random_.below(networks_.size() + gateways_.size());
    for (Place place = 0; place < networks_.size() + gateways_.size(); ++place) {
      std::vector<Place> path = {anchor};
      if (walk(path, place)) reachable.push_back(place);
    }
    std::vector<Place> able = reachable;
    if (has_famouso_) std::erase_if(able, [&](Place place) { return !speaks_famouso(place); });
    std::vector<Place> senders;
    const auto publishers = random_.one_in(easy_ ? 40 : 8) ? 0 : 1 + random_.below(2);
    for (std::size_t i = 0; i < publishers; ++i) {
      if (able.empty()) break;
      const Place place = random_.one_of(able);
      const bool raw = !is_gateway(place) && networks_[place].frames == Frames::raw;
      if (raw && std::ranges::find(senders, place) != senders.end()) continue;
      senders.push_back(place);
      const auto node = has_famouso_ ? std::to_string(i) : std::string();
      const auto user = is_gateway(place) ? std::to_string(1000 + i) : std::string();
      write_end("Publisher", channel, place, attribute("node", node) + attribute("user", user));
    }
    const auto subscribers = random_.one_in(8) ? 0 : 1 + random_.below(2);
    for (std::size_t i = 0; i < subscribers; ++i) {
      const Place place = senders.empty() || random_.one_in(3) ? random_.one_of(reachable)
                                                               : random_.one_of(senders);
      for (const Place sender : senders) declare_route(sender, place);
      write_end("Subscriber", channel, place, "");
    }
  }

  void write_end(const std::string& element, const Channel& channel, Place place,
                 const std::string& sender) {
    const auto name =
        random_.one_in(2) ? element.substr(0, 1) + std::to_string(++named_) : std::string();
    const auto start = "<" + element + " channel=\"" + reference(channel) + "\"" + sender +
                       attribute("name", name);
    const auto seat = attribute(is_gateway(place) ? "gateway" : "network", name_of(place));
    const auto content =
        ">" + (random_.one_in(3) ? attributes(demanding_ + 1) : "") + "</" + element + ">";
    if (random_.one_in(4))
      components_[place] += start + content;
    else
      parts_.push_back(start + seat + content);
  }

  /// One at each place.
  void write_components() {
    if (components_.empty() && !in_component_.empty()) components_[0];
    for (const auto& [place, content] : components_) {
      const auto name = "k" + std::to_string(place);
      const auto seat = attribute(is_gateway(place) ? "gateway" : "network", name_of(place));
      const bool placed = random_.one_in(2);
      parts_.push_back("<Component name=\"" + name + "\"" + (placed ? "" : seat) + ">" +
                       std::exchange(in_component_, {}) + content + "</Component>");
      if (placed) parts_.push_back("<Placement component=\"" + name + "\"" + seat + "/>");
    }
  }

  Random random_;
  Numbers numbers_;
  std::vector<Network> networks_;
  std::vector<Gateway> gateways_;
  std::vector<Quantity> quantities_;
  std::vector<Channel> channels_;
  std::map<Place, std::string> components_;  ///< their publishers and subscribers
  std::string in_component_;                 ///< channels that stand in the first of them
  std::set<std::pair<Place, Place>> declared_;
  std::vector<std::string> parts_;
  std::size_t demanding_ = 1;  ///< a channel states each attribute once in so many
  std::size_t named_ = 0;
  std::uint64_t most_payload_ = 0;
  bool easy_ = false;  ///< asks little and provides the best of much: often fit
  bool long_frames_ = false;
  bool has_famouso_ = false;
  bool fragments_ = false;
};

}  // namespace

std::string random_description(std::uint64_t seed) {
  return in_some_forms(Writer(seed).write(), seed);
}

}  // namespace mlcca::testing
