// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/remarks.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <set>

#include "core/model/text.hpp"
#include "core/profiles/profile.hpp"
#include "tools/elements.hpp"
#include "tools/learn/channels.hpp"

namespace mlcca::learn {
namespace {

using core::Profile;

constexpr std::size_t kMostNamed = 8;                  // channels in a line
constexpr std::uint64_t kManyGaps = 10;                // in gaps of a channel
constexpr std::uint64_t kShortestEnd = 1'000'000'000;  // ns

class Remarks {
 public:
  Remarks(const Observer& observer, const std::vector<std::string>& names)
      : observer_(observer), names_(names) {}

  std::vector<std::string> run() {
    for (std::uint32_t i = 0; i < names_.size(); ++i) {
      profile(i);
      ends(i);
      stamps(i);
      services(i);
    }
    return std::move(out_);
  }

 private:
  using Numbers = std::vector<std::string>;

  [[nodiscard]] const Observer::Interface& at(std::uint32_t interface) const {
    return observer_.interfaces()[interface];
  }
  [[nodiscard]] std::string number_of(const FlowKey& key) const {
    return observer_.is_ethernet(key.interface)
               ? core::format_subject(key.number)
               : tools::number_text(observer_.profile_of(key.interface),
                                    static_cast<std::uint32_t>(key.number));
  }
  /// The numbers of the flows of an interface that have channels and for which `is` is true.
  template <class Is>
  [[nodiscard]] Numbers numbers(std::uint32_t interface, const Is& is) const {
    Numbers out;
    if (observer_.is_ethernet(interface) && observer_.profile_of(interface) != Profile::famouso)
      return out;
    for (const auto& [key, seen] : observer_.flows()) {
      if (key.interface != interface || seen.control || !is(key, seen)) continue;
      const std::string number = number_of(key);
      if (out.empty() || out.back() != number) out.push_back(number);
    }
    return out;
  }
  static std::string listed(const Numbers& all) {
    const auto shown = std::min(all.size(), kMostNamed);
    return fmt::format("{}{}", fmt::join(all.begin(), all.begin() + static_cast<int>(shown), ", "),
                       all.size() == shown ? "" : fmt::format(" and {} more", all.size() - shown));
  }

  void profile(std::uint32_t interface) {
    const auto& perhaps = at(interface).recognised->perhaps;
    if (perhaps)
      out_.push_back(
          fmt::format("{0}: it may be {1}, which is not certain: if it is, state --profile {0}={1}",
                      names_[interface], tools::profile_word(*perhaps)));
  }

  /// Notes channels that were present only part of the time: that may be a fault, or a state of the
  /// plant.
  void ends(std::uint32_t interface) {
    const Timeline& timeline = at(interface).timeline;
    const auto is_long = [](const Flow& flow, std::uint64_t ns) {
      return ns >= kShortestEnd && ns / kManyGaps >= flow.median_gap() &&
             ns / 2 >= flow.longest_gap();
    };
    const Numbers ended = numbers(interface, [&](const FlowKey&, const Seen& seen) {
      const Flow& flow = seen.flow;
      return flow.last_clock() == timeline.clock() && timeline.last() > flow.last() &&
             is_long(flow, timeline.last() - flow.last()) && times_of(flow, timeline).periodic;
    });
    if (!ended.empty())
      out_.push_back(fmt::format(
          "{}: nothing more came of {} while others went on: the draft expects {} to go "
          "on, too",
          names_[interface], listed(ended), ended.size() == 1 ? "it" : "them"));
    const Numbers begun = numbers(interface, [&](const FlowKey&, const Seen& seen) {
      const Flow& flow = seen.flow;
      return flow.first_clock() == 0 && flow.first() > timeline.first() &&
             is_long(flow, flow.first() - timeline.first()) && times_of(flow, timeline).periodic;
    });
    if (!begun.empty())
      out_.push_back(fmt::format("{}: {} began only when others had been there for long",
                                 names_[interface], listed(begun)));
  }

  void stamps(std::uint32_t interface) {
    const Numbers alike = numbers(interface, [](const FlowKey&, const Seen& seen) {
      return seen.flow.gaps() != 0 && seen.flow.longest_gap() == 0;
    });
    if (!alike.empty())
      out_.push_back(
          fmt::format("{}: all events of {} have one time stamp: how often they come is "
                      "not known, and the Period is assumed",
                      names_[interface], listed(alike)));
  }

  /// Notes SDOs, which a gate does not pass unless they are described.
  void services(std::uint32_t interface) {
    if (observer_.is_ethernet(interface) || observer_.profile_of(interface) != Profile::canopen)
      return;
    const Numbers all =
        numbers(interface, [](const FlowKey& key, const Seen&) { return is_service(key.number); });
    if (!all.empty())
      out_.push_back(fmt::format(
          "{}: SDOs were seen ({}): the draft has channels for them, since any entry of a node can "
          "be written by them, and a gate takes them for no control traffic; remove those that "
          "only "
          "a tool needed",
          names_[interface], listed(all)));
  }

  const Observer& observer_;
  const std::vector<std::string>& names_;
  std::vector<std::string> out_;
};

}  // namespace

std::vector<std::string> remarks_on(const Observer& observer,
                                    const std::vector<std::string>& names) {
  return Remarks(observer, names).run();
}

}  // namespace mlcca::learn
