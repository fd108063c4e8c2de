// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/senders.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include "base/many.hpp"
#include "core/gates/plan.hpp"
#include "core/profiles/profile.hpp"
#include "tools/elements.hpp"

namespace mlcca::learn {
namespace {

constexpr std::size_t kMostListed = 16;

class Senders {
 public:
  Senders(const Observer& observer, const std::vector<std::string>& names)
      : observer_(observer), names_(names) {}

  std::vector<std::string> run(std::vector<Channel>& channels) {
    for (Channel& channel : channels) leave_out_nobody(channel);
    std::erase_if(channels, [](const Channel& channel) { return channel.sources.empty(); });
    for (const auto& [interface, nobody] : nobody_)
      out_.push_back(fmt::format(
          "{}: {} of {} from nodes that no publisher can be, which a gate drops: nodes are {}",
          names_[interface], many(nobody.events, "event"), listed(nobody.numbers),
          core::traits_of(observer_.profile_of(interface)).nodes));
    for (Channel& channel : channels) {
      leave_out_second(channel);
      leave_out_others(channel);
    }
    return std::move(out_);
  }

 private:
  struct Nobody {
    std::uint64_t events = 0;
    std::vector<std::string> numbers;
  };

  [[nodiscard]] std::string number_of(const FlowKey& key) const {
    return tools::number_text(observer_.profile_of(key.interface),
                              static_cast<std::uint32_t>(key.number));
  }
  static std::string listed(const std::vector<std::string>& all) {
    const auto shown = std::min(all.size(), kMostListed);
    return fmt::format(
        "{}{}", fmt::join(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(shown), ", "),
        all.size() == shown ? "" : fmt::format(" and {} more", all.size() - shown));
  }

  void leave_out_nobody(Channel& channel) {
    std::erase_if(channel.sources, [this](const Source& source) {
      const FlowKey& key = source.key;
      if (!observer_.has_nodes(key.interface) ||
          std::cmp_less_equal(key.node,
                              core::traits_of(observer_.profile_of(key.interface)).last_node))
        return false;
      Nobody& nobody = nobody_[key.interface];
      nobody.events += source.seen->flow.events();
      const std::string number = number_of(key);
      if (std::ranges::find(nobody.numbers, number) == nobody.numbers.end())
        nobody.numbers.push_back(number);
      return true;
    });
  }

  /// An identifier has only one sender on a bus. If the gateway would be a second one, for a
  /// program on it or for crossing frames, the one of the two with more events stays.
  void leave_out_second(Channel& channel) {
    std::set<FlowKey> others;
    for (const Source& there : channel.sources)
      for (const Source& other : channel.sources)
        if (!others.contains(there.key) && !others.contains(other.key) &&
            are_one_sender(channel, there.key, other.key)) {
          const bool less = other.seen->flow.events() < there.seen->flow.events();
          const Source& out = less ? other : there;
          others.insert(out.key);
          out_.push_back(fmt::format(
              "{} {}: {} sends it there, and it comes from {}, too, but an identifier has one "
              "sender on a bus: the draft is without {}, of which a gate drops {}",
              names_[there.key.interface], number_of(there.key), word_for(there.key),
              place_of(other.key), less ? "the latter" : "the former",
              many(out.seen->flow.events(), "event")));
        }
    std::erase_if(channel.sources,
                  [&](const Source& source) { return others.contains(source.key); });
  }
  [[nodiscard]] bool are_one_sender(const Channel& channel, const FlowKey& there,
                                    const FlowKey& other) const {
    if (there.local || there == other || observer_.is_ethernet(there.interface) ||
        observer_.is_ethernet(other.interface) ||
        (observer_.has_nodes(there.interface) && there.node != other.node))
      return false;
    const InterfaceTraffic& place = channel.places.at(there.interface);
    return place.crossing.has_value() || place.local;
  }
  [[nodiscard]] std::string place_of(const FlowKey& key) const {
    return key.local ? "this host" : names_[key.interface];
  }

  /// Of the senders on CAN, those with most events stay. On Ethernet one entry stands for all
  /// others.
  void leave_out_others(Channel& channel) {
    std::vector<const Source*> senders;
    for (const Source& source : channel.sources)
      if (!observer_.is_ethernet(source.key.interface)) senders.push_back(&source);
    if (senders.size() <= core::kMostBusEntries) return;
    std::ranges::stable_sort(senders, std::ranges::greater{},
                             [](const Source* one) { return one->seen->flow.events(); });
    std::set<FlowKey> others;
    std::vector<std::string> words;
    for (std::size_t i = core::kMostBusEntries; i < senders.size(); ++i) {
      others.insert(senders[i]->key);
      words.push_back(word_for(senders[i]->key));
    }
    const FlowKey first = senders.front()->key;
    const std::string& name = names_[first.interface];
    out_.push_back(fmt::format(
        "{0} {1}: {2} senders, of which a gate distinguishes {3}: the draft has those with most "
        "events, and a gate drops what comes from {4}; with --profile {0}=raw each has a channel "
        "of its own",
        name, number_of(first), senders.size(), core::kMostBusEntries, listed(words)));
    std::erase_if(channel.sources,
                  [&](const Source& source) { return others.contains(source.key); });
  }

  [[nodiscard]] std::string word_for(const FlowKey& key) const {
    if (key.local) return "this host";
    return observer_.has_nodes(key.interface) ? fmt::format("node {}", key.node)
                                              : "a node on " + names_[key.interface];
  }

  const Observer& observer_;
  const std::vector<std::string>& names_;
  std::map<std::uint32_t, Nobody> nobody_;
  std::vector<std::string> out_;
};

}  // namespace

std::vector<std::string> leave_out_senders(const Observer& observer,
                                           const std::vector<std::string>& names,
                                           std::vector<Channel>& channels) {
  return Senders(observer, names).run(channels);
}

}  // namespace mlcca::learn
