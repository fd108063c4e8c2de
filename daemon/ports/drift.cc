// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/ports/drift.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <ranges>
#include <utility>

#include "base/many.hpp"
#include "bpf/gate.h"
#include "daemon/gates/close_unpinned.hpp"
#include "daemon/gates/early.hpp"
#include "daemon/net/filter_order.hpp"

namespace mlcca {
namespace {

/// What runs before our programs, in words; empty if nothing does.
Result<std::string> before(int ifindex, const gates::PortGate& gate) {
  std::string text;
  const auto add = [&](bool ingress, const std::string& what) {
    text +=
        fmt::format("{}{} at {}", text.empty() ? "" : ", ", what, ingress ? "ingress" : "egress");
  };
  const auto ahead = gate.ahead();
  if (!ahead) return std::unexpected(ahead.error());
  for (const gates::Ahead& a : *ahead)
    add(a.direction == gates::Direction::ingress, fmt::format("TCX program {}", a.program));
  if (gate.hook() != gates::Hook::clsact) return text;
  for (const bool ingress : {true, false}) {
    const auto filters = net::filters_before(ifindex, ingress, GATE_TC_PRIORITY, GATE_TC_HANDLE);
    if (!filters) return std::unexpected(filters.error());
    for (const net::Filter& f : *filters)
      add(ingress, fmt::format("{} filter{}{} (preference {}, handle {:#x}{})", f.kind,
                               f.name.empty() ? "" : " ", f.name, f.priority, f.handle,
                               f.program != 0 ? fmt::format(", program {}", f.program) : ""));
  }
  return text;
}

/// XDP programs of other owners, in words; empty if there are none. They run before tc in any case,
/// and a driver has room for only one.
std::string before_tc(int ifindex, const gates::PortGate& gate) {
  const auto others =
      gates::other_early_programs(static_cast<std::uint32_t>(ifindex), gate.early());
  if (others.empty()) return {};
  return fmt::format(
      "before the gate of {} runs XDP program {}, which is not ours and stays: what that takes, "
      "redirects or sends back is not judged",
      gate.name(), fmt::join(others, ", "));
}

/// The frames that the gate has let out: admitted ones, and those that passed in audit mode, which
/// are counted here or at ingress.
std::uint64_t let_out(const gates::PortGate& gate) {
  const auto reasons = gate.reasons(gates::Direction::egress);
  const auto audit = gate.would_drop(gates::Direction::egress);
  return std::accumulate(audit.begin(), audit.end(), reasons[GATE_R_PASSED] + reasons[GATE_R_ECHO]);
}

}  // namespace

void Drift::forget_all_but(const std::vector<int>& gated) {
  std::erase_if(seen_,
                [&](const auto& entry) { return !std::ranges::binary_search(gated, entry.first); });
}

std::vector<int> Drift::repair(const Gates& gates, const net::InterfaceTable& links) {
  const auto gated = std::views::keys(gates);
  forget_all_but({gated.begin(), gated.end()});
  std::vector<int> lost;
  for (const auto& [ifindex, gate] : gates)
    if (!repair(ifindex, *gate, links)) lost.push_back(ifindex);
  return lost;
}

bool Drift::repair(int ifindex, gates::PortGate& gate, const net::InterfaceTable& links) {
  if (!links.contains(ifindex)) return true;
  Seen& seen = seen_[ifindex];
  gated_.insert(ifindex);
  if (gate.judge_again()) {
    report_repaired(
        seen,
        fmt::format(
            "another program altered the gate of {}: it let everything pass until now, and judges "
            "again",
            gate.name()));
  }
  if (gate.hold_again()) {
    report_repaired(
        seen,
        fmt::format("another program altered which daemon holds the gate of {}: it was closed "
                    "until now, and holds what is granted again",
                    gate.name()));
  }
  keep_pinned(gate, seen);
  const auto there = gate.attached();
  if (seen.unseen.is_new(
          there ? ""
                : fmt::format("the gate of {} cannot be inspected, and is commanded as before: {}",
                              gate.name(), there.error().text)))
    report_(Kind::drift, seen.unseen.text(), true);
  if (!there) return true;
  keep_early(ifindex, gate, seen);
  if (*there) {
    if (!seen.unpinned.lasts()) keep_first(ifindex, gate, seen);
    return true;
  }
  const bool replaced = gates::is_gated(static_cast<std::uint32_t>(ifindex), gate.hook());
  const auto repaired = gate.reattach();
  if (!repaired) {
    report_(
        Kind::drift,
        "the gate of " + gate.name() + " is gone and cannot be put back: " + repaired.error().text,
        true);
    return false;
  }
  report_repaired(
      seen,
      replaced
          ? fmt::format("another daemon had put its gate in the place of that of {}, which is "
                        "back: two daemons with --bpf-root of their own close each other's "
                        "gates",
                        gate.name())
          : fmt::format("another program removed the gate of {}: it was open until now, and is "
                        "attached again",
                        gate.name()));
  return true;
}

void Drift::report_repaired(Seen& seen, const std::string& line) {
  ++seen.repaired;
  report_(Kind::drift, line, true);
}

/// Pins come first, because what is put back afterwards is pinned as well.
void Drift::keep_pinned(const gates::PortGate& gate, Seen& seen) {
  const auto again = gate.keep_pinned();
  if (seen.unpinned.is_new(
          again ? ""
                : fmt::format(
                      "the gate of {} is not pinned, and a daemon that starts would begin with "
                      "a closed one: {}",
                      gate.name(), again.error().text)))
    report_(Kind::drift, seen.unpinned.text(), true);
  if (!again || again->empty()) return;
  report_repaired(
      seen, fmt::format(
                "another program unpinned {} of the gate of {}: pinned again, and nothing else has "
                "changed",
                fmt::join(*again, ", "), gate.name()));
}

/// A missing XDP program lets nothing pass, because both filters check all frames.
void Drift::keep_early(int ifindex, gates::PortGate& gate, Seen& seen) {
  const std::string others = before_tc(ifindex, gate);
  const std::string reported = std::exchange(seen.early, others);
  const bool lost = gate.lost_early();
  // Our program also takes a place that another program has left.
  const auto put =
      lost || (others.empty() && !reported.empty()) ? gate.put_early_back() : Result<void>();
  if (lost) {
    const bool back = gate.drops_early();
    if (back) ++seen.repaired;
    report_(Kind::drift,
            fmt::format("another program removed ours from the driver of {}: what is refused was "
                        "dropped behind packet sockets until now, and {}{}",
                        gate.name(), back ? "is dropped early again" : "still is",
                        back || put ? "" : ": " + put.error().text),
            true);
  }
  if (reported == others) return;
  report_(Kind::drift,
          others.empty()
              ? fmt::format("no other XDP program runs before the gate of {} any more", gate.name())
              : others,
          !others.empty());
}

/// Puts our programs first where that takes nothing away from others. A program in front may let
/// frames pass that ours never see.
void Drift::keep_first(int ifindex, gates::PortGate& gate, Seen& seen) {
  auto found = before(ifindex, gate);
  std::string standing;
  if (!found) {
    standing = found.error().text;
  } else if (!found->empty()) {
    if (*found == seen.unmovable) return;
    const auto moved = gate.go_first();
    const auto left = before(ifindex, gate);
    if (moved && left && left->empty()) {
      report_repaired(
          seen, fmt::format("before the gate of {} ran {}: what that let pass until now was not "
                            "judged; the gate is first again",
                            gate.name(), *found));
    } else {
      standing = fmt::format(
          "before the gate of {} runs {}, and it cannot be put first{}: what "
          "that lets pass is not judged",
          gate.name(), *found, moved ? "" : " (" + moved.error().text + ")");
    }
  }
  seen.unmovable = standing.empty() || !found ? "" : *found;
  const std::string reported = std::exchange(seen.standing, standing);
  if (reported == standing) return;
  report_(Kind::drift,
          standing.empty() ? fmt::format("nothing runs before the gate of {} any more", gate.name())
                           : standing,
          !standing.empty());
}

void Drift::report_taken_off(const gates::PortGate& gate) {
  report_(
      Kind::drift,
      fmt::format("the gate of {}, which is not described, was taken off: nothing is judged there "
                  "any more",
                  gate.name()),
      true);
}

void Drift::report_moved(const net::Links::Moved& link) {
  if (gated_.erase(link.ifindex) == 0) return;
  report_(Kind::drift,
          link.name + " was moved to another network namespace: there it has no gate of ours",
          true);
}

void Drift::check_bypass(const Gates& gates, net::Links& links, std::int64_t now_s) {
  for (const auto& [ifindex, gate] : gates) check_bypass(ifindex, *gate, links, now_s);
}

void Drift::check_bypass(int ifindex, const gates::PortGate& gate, net::Links& links,
                         std::int64_t now_s) {
  if (!gate.judges_everything()) return;
  Seen& seen = seen_[ifindex];
  Bypass::Counts counts;
  counts.let_out_before = let_out(gate);
  const auto waiting = net::waiting_in_queue(ifindex);
  const auto traffic = links.traffic(ifindex);
  if (!waiting || !traffic) return;
  counts.waiting = waiting->frames;
  counts.sent = traffic->sent_frames + traffic->send_drops + waiting->dropped;
  counts.let_out_after = let_out(gate);
  reported_past_.sample(gate.name(), seen.past, now_s);
  seen.past += seen.bypass.update(counts);
  if (const auto bypassed = reported_past_.sample(gate.name(), seen.past, now_s))
    report_(Kind::bypass,
            fmt::format("{} has sent {} that its gate has not seen: a program sends past the "
                        "queueing layer (AF_PACKET with PACKET_QDISC_BYPASS)",
                        gate.name(), many(*bypassed, "frame")),
            true);
}

void Drift::report(int ifindex, const gates::PortGate& gate, control::Interface& to) const {
  to.hook = gates::to_text(gate.hook());
  const auto it = seen_.find(ifindex);
  if (it == seen_.end()) return;
  const Seen& seen = it->second;
  for (const std::string& part :
       {seen.unseen.text(), seen.standing, seen.unpinned.text(), seen.early})
    if (!part.empty()) to.drift += (to.drift.empty() ? "" : "; ") + part;
  to.repaired = seen.repaired;
  to.bypassed = seen.past;
}

}  // namespace mlcca
