// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/controller.hpp"

#include <fmt/core.h>

#include <utility>

#include "core/model/progress.hpp"
#include "core/model/text.hpp"
#include "daemon/gateway/requests/table.hpp"

namespace mlcca {

Controller::Controller(Options options, Outside outside)
    : parts_(std::move(options), std::move(outside)), start_(parts_), jobs_(parts_) {}

// NOLINTNEXTLINE(readability-make-member-function-const): it changes the parts
bool Controller::begin_stop() {
  if (!parts_.membership) return true;
  parts_.membership->leave();
  return parts_.membership->may_end();
}

void Controller::stop() {
  parts_.outside.control.close_all();
  parts_.forwarding.stop();
  parts_.outside.log.notice(Kind::stopped,
                            "stopped: the gates stay in the kernel and deny everything");
  parts_.turn.commit();
  if (!parts_.history) return;
  parts_.history->flush(parts_.outside.clock.unix_ns());
  static_cast<void>(parts_.audit_keeper.keep(*parts_.history));
}

void Controller::gates_reported() {
  if (const auto read = parts_.outside.control.read_reports(); !read)
    parts_.outside.log.error(Kind::problem, read.error().text);
}

void Controller::act() {
  const core::Progress alive(parts_.pulse);
  parts_.reconciler.follow_links_of_meshes();
  parts_.reconciler.note_presence();
  if (parts_.membership)
    parts_.membership->act();
  else
    static_cast<void>(parts_.turn.settle());
  parts_.local_ends.report_waiting();
  parts_.forwarding.act();  // before clients get their answers
  parts_.turn.commit();
}

void Controller::beat() {
  GateControl& control = parts_.outside.control;
  const std::uint64_t now = parts_.outside.clock.monotonic_ns();
  const Lapse reason =
      control.until() != 0 && control.until() <= now ? Lapse::lease : Lapse::heartbeat;
  auto alive = control.beat(now);
  if (control.lapsed()) parts_.reconciler.links_changed();
  // No heart-beat was given for longer than the grace, so our knowledge may be outdated. Reconcile
  // first, then open.
  if (control.lapsed() && parts_.outside.links.problem().empty()) {
    if (parts_.membership) parts_.membership->expire();
    parts_.reconciler.reconcile();
    alive = control.clear_lapse(parts_.outside.clock.monotonic_ns());
    parts_.health.note_lapse(reason);
    parts_.outside.log.error(
        Kind::lapsed,
        fmt::format("the kernel had closed all gates because {}; they follow the verdicts again",
                    words_of(reason, core::format_value(Attribute::latency, control.grace()))));
  }
  if (!alive)
    parts_.outside.log.critical(Kind::problem,
                                "the gates close soon: no heart-beat, " + alive.error().text);
}

// --- requests ------------------------------------------------------------------------------------

serve::Answer Controller::answer(const control::Request& request, const serve::Peer& peer) {
  const requests::Privilege privilege = requests::privilege_of(request);
  if (privilege == requests::Privilege::member && !peer.may_change)
    return {{request.id,
             error_of(control::ErrorKind::forbidden,
                      fmt::format("only root and members of the group {} may change anything",
                                  parts_.options.group))}};
  const bool counts = requests::trace_of(request) != requests::Trace::none;
  if (counts && !requests::takes_away(*parts_.context, request))
    if (const auto why = parts_.quotas.refuse_change(peer.uid, parts_.outside.clock.monotonic_ns(),
                                                     requests::least_rows_of(request)))
      return {{request.id, failed("nothing was changed: " + *why)}};
  const core::Progress alive(parts_.pulse);
  const bool acts = privilege != requests::Privilege::anyone;
  const EventLog::Acting acting(parts_.outside.log,
                                acts ? std::optional(actor_of(peer)) : std::nullopt);
  Response response = requests::handle(*parts_.context, {peer, request.slices}, request);
  if (counts) parts_.quotas.charge(peer.uid, acting.rows(), parts_.outside.clock.monotonic_ns());
  if (!response.held) parts_.forwarding.act();
  return {{request.id, std::move(response.body)},
          response.held,
          response.owned,
          response.follows,
          std::move(response.slices),
          response.least_bytes};
}

control::Actor Controller::actor_of(const serve::Peer& peer) {
  return {.uid = peer.uid,
          .user = parts_.users.of(peer.uid),
          .pid = static_cast<std::uint32_t>(peer.pid)};
}

void Controller::on_slice(const Aside::Ready& ready) {
  parts_.reloads.on_ready(ready);
  parts_.aside.on_ready(ready);
  if (parts_.membership) parts_.membership->on_ready(ready);
}

}  // namespace mlcca
