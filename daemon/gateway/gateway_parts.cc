// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/gateway_parts.hpp"

#include <fmt/core.h>

#include <utility>

#include "core/model/progress.hpp"
#include "daemon/gateway/losses.hpp"

namespace mlcca {

GatewayParts::GatewayParts(Options given, Outside around)
    : options(std::move(given)),
      outside(std::move(around)),
      meshes(
          outside.loop, [this](std::size_t network) { reconciler.note_links_of(network); },
          [this](const std::string& network, const std::string& line, bool problem) {
            if (problem)
              outside.log.warning(Kind::interface, line, {.network = network});
            else
              outside.log.info(Kind::interface, line, {.network = network});
          }),
      rollout(make_rollout()),
      membership(make_membership()),
      safeguards(outside.control, outside.log, options.bpf_root),
      reconciler({scene, outside.gates, outside.links, outside.log, recorder, tags, turn, meshes,
                  presence, membership.get(), pulse}),
      reloads({options, [this] { return reader(); }, outside.reading, outside.clock, outside.gates,
               scene, outside.log, deliveries, delivery_health, drops, recorder, turn, admissions,
               buses, meshes,
               [this](const DeliveryEvents::Granted& before) {
                 return reconciler.put_in_force(before, TagBindings::Known::by_gates);
               },
               [this] { return summary(); },
               [this](uid_t user, std::uint64_t rows) {
                 quotas.charge(user, rows, outside.clock.monotonic_ns());
               },
               pulse}),
      health({scene, outside.gates, outside.control, outside.links, meshes, recorder, forwarding,
              safeguards, reloads, tags, admissions, delivery_health, presence, outside.clock,
              modes, membership.get()}),
      aside(outside.loop) {
  outside.gates.on_step(pulse);
  turn.add(buses);
  turn.add(tags);
  turn.on_lost([this](const auto& lost) { admissions.take_back(lost); });
  on_commit([](const auto&) {});
  if (membership) {
    admissions.need_agreements();
    admissions.on_gone([this](const auto& gone) { membership->admissions_gone(gone); });
  }
  turn.on_changed([this](const core::DecisionChange& change) {
    drops.verdicts_changed(change);
    delivery_health.restart(change.channel);
    if (membership) membership->note_changed(change.channel);
  });
  drops.on_polled([this](const auto& polled) { delivery_health.judge(polled); });
}

std::string GatewayParts::summary() const {
  const core::State& state = *scene.state;
  return fmt::format("{} of {}: {} granted, {} refused, {}{}",
                     state.system().gateways[scene.self].name, state.system().name, state.granted(),
                     state.refused(), modes.name(), outside.control.is_open() ? "" : ", closed");
}

void GatewayParts::on_commit(Turn::Committed committed) {
  if (!membership) {
    turn.on_commit(std::move(committed));
    return;
  }
  turn.on_commit([this, committed = std::move(committed)](const Result<void>& done) {
    membership->committed(done);
    committed(done);
  });
}

ReadDescription GatewayParts::reader() const {
  if (!rollout) return outside.read;
  return rollout->reader(outside.read, membership ? membership->begun_member() : nullptr);
}

std::unique_ptr<Rollout> GatewayParts::make_rollout() {
  if (outside.cluster == nullptr) return nullptr;
  return std::make_unique<Rollout>(Rollout::Parts{
      .scene = scene,
      .log = outside.log,
      .reading = outside.reading,
      .texts = *outside.texts,
      .patience = patience,
      .clock = outside.clock,
      .read = outside.read_text,
      .misfit =
          [this](Described& described) {
            const auto done = reloads.complete(described);
            return done ? std::string() : done.error().lines.front();
          },
      .losses =
          [this](Described& described) {
            const core::Progress alive(pulse);
            const auto& own = recorder.contents().admissions;
            return lost_grants(*scene.state, *described.state,
                               [&own](core::AdmissionId id) { return own.find(id) != nullptr; });
          },
      .load = [this](ReadDescription read,
                     auto done) { return reloads.begin(std::move(read), std::move(done)); },
      .reload = [this](auto done) { return reloads.begin(reader(), std::move(done)); },
      .wake = [] {}});
}

std::unique_ptr<Membership> GatewayParts::make_membership() {
  if (outside.cluster == nullptr) return nullptr;
  return std::make_unique<Membership>(Membership::Parts{.scene = scene,
                                                        .control = outside.control,
                                                        .log = outside.log,
                                                        .recorder = recorder,
                                                        .turn = turn,
                                                        .link = *outside.cluster,
                                                        .clock = outside.clock,
                                                        .loop = outside.loop,
                                                        .lease = options.lease_ns,
                                                        .pulse = pulse,
                                                        .quotas = quotas,
                                                        .presence = presence,
                                                        .forwarding = forwarding,
                                                        .rollout = *rollout,
                                                        .admissions = admissions,
                                                        .adopted = adopted});
}

}  // namespace mlcca
