// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/periodic_jobs.hpp"

#include <malloc.h>

#include <string>
#include <utility>

namespace mlcca {

/// Each job of a round does a bounded amount: one item of many, or a few short ones.
PeriodicJobs::PeriodicJobs(GatewayParts& parts)
    : parts_(parts), rounds_([this] { return parts_.outside.clock.monotonic_ns(); }) {
  const auto once = [this](auto work) {
    rounds_.add([work] {
      work();
      return false;
    });
  };
  once([this] { poll_surroundings(); });
  rounds_.add([this] { return repair_next(); });
  rounds_.add([this] { return parts_.admissions.end_some(); });
  rounds_.add([this] { return parts_.buses.poll_some(); });
  rounds_.add([this] { return parts_.drops.poll_some_channels(); });
  rounds_.add([this] { return parts_.drops.tidy(); });
  rounds_.add([this] { return parts_.drops.poll_some_ports(); });
  once([this] { parts_.silences.poll(); });
  once([this] { parts_.modes.poll(); });
  once([this] {
    if (parts_.history) parts_.audit_keeper.poll(*parts_.history);
  });
  rounds_.add([this] { return poll_next_bypass(); });
  once([this] { parts_.tags.poll(); });
  once([this] { parts_.tags.ask(); });
  rounds_.add([this] { return write_some_history(); });
}

/// Polls what does not depend on the number of channels or ports. All rules of can-gw are read in
/// one answer.
void PeriodicJobs::poll_surroundings() {
  parts_.safeguards.poll();
  if (!parts_.outside.links.problem().empty() || parts_.outside.gates.needs_recheck())
    parts_.reconciler.links_changed();
  parts_.outside.gates.begin_repair();
  repaired_ = checked_ = 0;
  parts_.recorder.keep();
  parts_.forwarding.poll();
  if (parts_.membership) parts_.membership->poll();
  parts_.aside.poll();
  parts_.reloads.poll();
}

bool PeriodicJobs::repair_next() {
  if (const auto gate = parts_.outside.gates.next_gate(repaired_)) {
    repaired_ = *gate;
    // The changes take effect at once: otherwise a client whose turn comes in between would get
    // reports of changes that have no effect on an interface without a gate.
    if (!parts_.outside.gates.repair(*gate)) parts_.reconciler.reconcile();
    return true;
  }
  if (parts_.outside.gates.wants_gate()) parts_.reconciler.reconcile();
  return false;
}

bool PeriodicJobs::poll_next_bypass() {
  const auto gate = parts_.outside.gates.next_gate(checked_);
  checked_ = gate.value_or(0);
  if (gate) parts_.outside.gates.check_bypass(*gate, parts_.outside.clock.monotonic_s());
  return gate.has_value();
}

bool PeriodicJobs::write_some_history() {
  if (!parts_.history) return false;
  const std::uint64_t now = parts_.outside.clock.unix_ns();
  const bool more =
      parts_.patience.wait_for([this, now] { return parts_.history->flush_some(now); });
  for (std::string& line : parts_.history->take_troubles())
    parts_.outside.log.warning(Kind::problem, std::move(line));
  // The events of a start or reload fill some MiB until they are written.
  if (!more && writes_much_history_) ::malloc_trim(0);
  writes_much_history_ = more;
  return more;
}

}  // namespace mlcca
