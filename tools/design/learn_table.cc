// SPDX-License-Identifier: BSD-2-Clause
#include "tools/design/learn_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <utility>

#include "tools/elements.hpp"
#include "tools/times.hpp"
#include "tools/values.hpp"

namespace mlcca::tools::design {
namespace {

using Json = nlohmann::ordered_json;

const char* kind_of(const learn::DraftChannel& channel) {
  if (channel.on_events) return "cyclic and on events";
  if (channel.periodic) return "periodic";
  if (channel.few && !channel.bursts) return "too few to tell";
  return channel.bursts ? "bursts" : "aperiodic";
}

/// A single event has none.
bool has_gaps(const learn::DraftChannel& channel) { return channel.events > 1; }

/// Null if there is none.
Json gap(const learn::DraftChannel& channel, std::uint64_t ns) {
  return has_gaps(channel) ? Json(ns) : Json();
}

}  // namespace

std::string table_of(const learn::Draft& draft, Color color) {
  TextTable table({{"CHANNEL"},
                   {"EVENTS", Align::right},
                   {"PERIOD", Align::right},
                   {"JITTER", Align::right},
                   {"LONGEST GAP", Align::right},
                   {"OMISSION", Align::right},
                   {"BYTES", Align::right},
                   {"BYTES/S", Align::right},
                   {"KIND"},
                   {"CROSSES TO"}});
  for (const auto& channel : draft.channels)
    table.add(
        {{channel.name},
         {fmt::format("{}", channel.events)},
         {time_words(channel.period)},
         {channel.jitter == 0 ? "" : time_words(channel.jitter)},
         {has_gaps(channel) ? print_duration(channel.gaps.longest) : ""},
         {channel.periodic ? fmt::format("{}", channel.omission) : ""},
         {fmt::format("{}", channel.bytes)},
         {channel.bytes_per_second ? fmt::format("{:.0f}", *channel.bytes_per_second) : "too few"},
         {kind_of(channel)},
         {fmt::format("{}", fmt::join(channel.crosses_to, ", "))}});
  return table.text(color);
}

Json channels_of(const learn::Draft& draft) {
  Json channels = Json::array();
  for (const auto& channel : draft.channels) {
    Json publishers = Json::array();
    for (const auto& publisher : channel.publishers) publishers.push_back(publisher.name);
    channels.push_back(
        {{"name", channel.name},
         {"interface", channel.interface},
         {"identifier", channel.identifier},
         {"events", channel.events},
         {"periodic", channel.periodic},
         {"kind", kind_of(channel)},
         {"period_ns", channel.period},
         {"jitter_ns", channel.jitter},
         {"median_gap_ns", gap(channel, channel.gaps.median)},
         {"mean_gap_ns", gap(channel, channel.gaps.mean)},
         {"shortest_gap_ns", gap(channel, channel.gaps.shortest)},
         {"longest_gap_ns", gap(channel, channel.gaps.longest)},
         {"pauses", channel.gaps.pauses},
         {"longest_pause_ns", channel.gaps.longest_pause},
         {"omission", channel.periodic ? Json(channel.omission) : Json()},
         {"bytes", channel.bytes},
         {"bytes_per_second", channel.bytes_per_second ? Json(*channel.bytes_per_second) : Json()},
         {"publishers", std::move(publishers)},
         {"crosses_to", channel.crosses_to}});
  }
  return channels;
}

}  // namespace mlcca::tools::design
