// SPDX-License-Identifier: BSD-2-Clause
// The parts of Controller that only a gateway of a cluster needs.
#include <utility>

#include "daemon/gateway/controller.hpp"
#include "daemon/gateway/requests/adopted.hpp"

namespace mlcca {

/// An earlier daemon, which took part in a cluster, may have left a limit of time in the kernel.
/// This daemon shares nothing, so it removes the limit.
Result<void> Controller::forget_cap() {
  if (membership_ || outside_.control.until() == 0) return {};
  return outside_.control.set_until(0);
}

void Controller::on_commit(Turn::Committed committed) {
  if (!membership_) {
    turn_.on_commit(std::move(committed));
    return;
  }
  turn_.on_commit([this, committed = std::move(committed)](const Result<void>& done) {
    membership_->committed(done);
    committed(done);
  });
}

/// With a store, the store says which of several gateways carries a channel.
void Controller::note_presence() {
  if (!membership_) presence_.apply(*scene_.state);
}

ReadDescription Controller::reader() const {
  if (!rollout_) return outside_.read;
  return rollout_->reader(outside_.read, membership_ ? membership_->begun_member() : nullptr);
}

std::unique_ptr<Rollout> Controller::make_rollout() {
  if (outside_.cluster == nullptr) return nullptr;
  return std::make_unique<Rollout>(Rollout::Parts{
      .scene = scene_,
      .log = outside_.log,
      .reading = outside_.reading,
      .texts = *outside_.texts,
      .patience = patience_,
      .clock = outside_.clock,
      .read = outside_.read_text,
      .misfit =
          [this](Described& described) {
            const auto done = reloads_.complete(described);
            return done ? std::string() : done.error().lines.front();
          },
      .load = [this](ReadDescription read,
                     auto done) { return reloads_.begin(std::move(read), std::move(done)); },
      .reload = [this](auto done) { return reloads_.begin(reader(), std::move(done)); },
      .wake = [] {}});
}

std::unique_ptr<Membership> Controller::make_membership() {
  if (outside_.cluster == nullptr) return nullptr;
  return std::make_unique<Membership>(Membership::Parts{
      .scene = scene_,
      .control = outside_.control,
      .log = outside_.log,
      .recorder = recorder_,
      .turn = turn_,
      .link = *outside_.cluster,
      .clock = outside_.clock,
      .loop = outside_.loop,
      .lease = options_.lease_ns,
      .pulse = pulse_,
      .charge =
          [this](uid_t user, std::uint64_t rows) {
            quotas_.charge(user, rows, outside_.clock.monotonic_ns());
          },
      .able = [this] { return presence_.can_carry(); },
      .before_commit = [this] { forwarding_.act(); },
      .rollout = *rollout_,
      .release = [this](const auto& ids, const auto& why) { return admissions_.release(ids, why); },
      .admissions = admissions_,
      .hands =
          {.misfit = [this](const auto& r) { return requests::misfit_of_adopted(*context_, r); },
           .admit = [this](const auto& r) { return requests::admit_adopted(*context_, r); },
           .take_in = [this](const auto& r) { return requests::take_in_adopted(*context_, r); },
           .remove = [this](const auto& gone) { requests::remove_adopted(*context_, gone); },
           .restore = [this](const auto& r) { requests::restore_adopted(*scene_.state, r); },
           .wish = [this](const auto& r,
                          std::size_t g) { return requests::wish_for_another(*context_, r, g); },
           .is_without_publisher =
               [this](const auto& r) { return requests::is_without_publisher(*context_, r); },
           .is_publisher_gone =
               [this](const auto& r) { return requests::is_publisher_gone(*context_, r); },
           .ask = {},
           .forget = {},
           .wants = {},
           .give_back = {},
           .name_of = {},
           .new_id = {},
           .new_number = {},
           .bring_in_line = {}}});
}

}  // namespace mlcca
