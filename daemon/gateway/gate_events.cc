// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/gate_events.hpp"

#include <fmt/core.h>
#include <linux/can.h>

#include <algorithm>
#include <cstddef>

#include "base/many.hpp"
#include "core/model/text.hpp"
#include "daemon/gates/counters.hpp"

namespace mlcca {
namespace {

/// For example "123", "FD 1ABCDEF0", "0x44697374616e6365 on its way out".
std::string frame_name(const gate_sample& sample) {
  const char* const way = sample.direction == GATE_EGRESS ? " on its way out" : "";
  if (sample.format == 0) {
    gates::Mac mac;
    std::ranges::copy(sample.mac, mac.begin());
    return fmt::format("{}{} from {}", core::format_subject(sample.subject), way,
                       gates::sender_text(sample.station, mac));
  }
  const char* const remote = (sample.can_id & CAN_RTR_FLAG) != 0 ? "remote " : "";
  std::string format;
  if (sample.format == GATE_FD) format = "FD ";
  if (sample.format == GATE_XL) format = "XL ";
  return (sample.can_id & CAN_EFF_FLAG) != 0
             ? fmt::format("{}{}{:08X}{}", format, remote, sample.can_id & CAN_EFF_MASK, way)
             : fmt::format("{}{}{:03X}{}", format, remote, sample.can_id & CAN_SFF_MASK, way);
}

}  // namespace

/// An event of a slot that has been given to another grant meanwhile concerns no delivery any more.
void GateEvents::on_event(const gate_event& event) {
  if (event.kind == GATE_E_BOUND) {
    parts_.tags.poll();
    return;
  }
  const core::State& state = *parts_.scene.state;
  const auto channel = state.channel_of(event.subject);
  if (!channel) return;
  std::vector<const core::Verdict*> concerned;
  std::vector<std::size_t> publishers;
  for (const core::Verdict& v : state.decisions()[*channel].verdicts) {
    const auto rules = core::gate_state(state.system(), state.members(), v, parts_.scene.self);
    if (!v.granted || core::goes_elsewhere(v, rules) || !parts_.gates.is_of(event, rules)) continue;
    concerned.push_back(&v);
    if (std::ranges::find(publishers, v.publisher) == publishers.end())
      publishers.push_back(v.publisher);
  }
  if (concerned.empty()) return;
  if (event.kind == GATE_E_MISSING) parts_.health.note_missing(*channel);
  const std::string names = core::names_of(state.members(), publishers);
  for (const core::Verdict* v : concerned) parts_.silences.on_event(*v, event, names);
}

void GateEvents::on_sample(const gate_sample& sample) {
  const std::string interface = parts_.links.name_of(static_cast<int>(sample.ifindex));
  for (std::size_t p = 0; p < parts_.gates.size(); ++p) {
    if (parts_.gates.interface_name(p) != interface) continue;
    const std::string& network = parts_.gates.network_of(p);
    const UnknownFrames unknown = parts_.gates.unknown_frames(p);
    // The program reports a frame before it counts it.
    const std::uint64_t so_far =
        std::max<std::uint64_t>(sample.audit != 0 ? unknown.would_drop : unknown.dropped, 1);
    parts_.log.warning(
        Kind::dropped,
        fmt::format("a frame that names no known subject {} {} ({}): {}, {}; {} so far",
                    sample.audit != 0 ? "would be dropped on" : "was dropped on", interface,
                    network, frame_name(sample), many(sample.len, "byte"), so_far),
        {.network = network});
    return;
  }
}

void GateEvents::repeat_missing(const core::Verdict& verdict) {
  const core::State& state = *parts_.scene.state;
  const auto done = parts_.gates.report_again(
      core::gate_state(state.system(), state.members(), verdict, parts_.scene.self));
  if (!done) parts_.log.error(Kind::problem, done.error().text);
}

}  // namespace mlcca
