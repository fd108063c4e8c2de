// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/crossing_remarks.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include "base/many.hpp"
#include "core/model/text.hpp"
#include "tools/elements.hpp"

namespace mlcca::learn {
namespace {

using core::Profile;

std::string evidence(const Crossings::Found& found) {
  return fmt::format("{} of {} had its data up to {} before, with {}", found.agreed(),
                     many(found.of, "event"), about(found.crossing.longest_ns),
                     many(found.contents, "different content"));
}

class CrossingRemarks {
 public:
  CrossingRemarks(const Observer& observer, const std::vector<std::string>& names)
      : observer_(observer), names_(names) {}

  std::vector<std::string> run(const std::vector<Channel>& channels,
                               const std::vector<DraftChannel>& drafted) {
    for (const DraftChannel& row : drafted)
      if (row.control) heart_beats(row);
    for (std::uint32_t i = 0; i < names_.size(); ++i) other_control(i);
    for (std::size_t i = 0; i < channels.size(); ++i) renumbered(channels[i], drafted[i].name);
    alike();
    return std::move(out_);
  }

 private:
  [[nodiscard]] std::string name_of(const FlowKey& key) const {
    const auto& interface = observer_.interfaces()[key.interface];
    return names_[key.interface] + " " +
           (interface.medium == Medium::ethernet
                ? core::format_subject(key.number)
                : tools::number_text(interface.recognised->profile,
                                     static_cast<std::uint32_t>(key.number)));
  }

  /// Notes heart-beats that cross a gateway. A gate passes no control traffic there, so the draft
  /// has a channel for them.
  void heart_beats(const DraftChannel& row) {
    out_.push_back(fmt::format(
        "heart-beats {} go from {} to {}: the draft has the channel {} for them, since control "
        "traffic crosses no gateway",
        row.identifier, row.interface, fmt::join(row.crosses_to, ", "), row.name));
  }

  void other_control(std::uint32_t interface) {
    const auto& crossed = observer_.interfaces()[interface].crossed_control;
    if (crossed.empty()) return;
    std::vector<std::string> all;
    all.reserve(crossed.size());
    for (const auto& [which, count] : crossed)
      all.push_back(fmt::format("{} from {} ({})", tools::number_text(Profile::raw, which.first),
                                names_[which.second], count));
    out_.push_back(
        fmt::format("{}: control traffic came from another interface, and the draft does not have "
                    "it, since it crosses no gateway: {}",
                    names_[interface], fmt::join(all, ", ")));
  }

  void renumbered(const Channel& channel, const std::string& name) {
    for (const auto& [interface, place] : channel.places)
      if (place.renumbered)
        out_.push_back(fmt::format(
            "{} is {} under another identifier ({} % sure: {}): the draft has the channel {} for "
            "both",
            name_of({interface, place.number}), name_of({channel.interface, channel.number}),
            place.renumbered->percent(), evidence(*place.renumbered), name));
  }

  void alike() {
    constexpr std::size_t most = 8;
    const auto& all = observer_.alike();
    for (std::size_t i = 0; i < std::min(all.size(), most); ++i) {
      const auto& [copy, origin, found] = all[i];
      out_.push_back(
          found.renumbered
              ? fmt::format("{} may be {} under another identifier, which is not certain ({}): if "
                            "it is, describe it as one channel",
                            name_of(copy), name_of(origin), evidence(found))
              : fmt::format("{} had the same few contents as {} shortly before: if it is one "
                            "channel, describe it as one",
                            name_of(copy), name_of(origin)));
    }
    if (all.size() > most)
      out_.push_back(many(all.size() - most, "further pair was alike", "further pairs were alike"));
  }

  const Observer& observer_;
  const std::vector<std::string>& names_;
  std::vector<std::string> out_;
};

}  // namespace

std::vector<std::string> remarks_on_crossings(const Observer& observer,
                                              const std::vector<std::string>& names,
                                              const std::vector<Channel>& channels,
                                              const std::vector<DraftChannel>& drafted) {
  return CrossingRemarks(observer, names).run(channels, drafted);
}

}  // namespace mlcca::learn
