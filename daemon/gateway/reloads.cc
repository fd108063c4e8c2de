// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/reloads.hpp"

#include <fmt/core.h>

#include "core/model/progress.hpp"
#include "daemon/gateway/quotas.hpp"

namespace mlcca {
namespace {

constexpr const char* kBusy =
    "nothing was changed: the description is being read already; ask again later";
constexpr const char* kNoThread =
    "nothing was changed: no thread can be had that reads the description; ask again later";

}  // namespace

/// Reads on a thread; the rest follows in the loop when that has ended.
bool Reloads::start_reading(std::uint64_t session, ReadDescription from) {
  const auto read = std::make_shared<std::optional<DescribedResult>>();
  const auto current =
      std::make_shared<Current>(Current{std::nullopt, session, parts_.log.actor()});
  const bool begun = parts_.reading.begin([read, from = std::move(from)] { *read = from(); },
                                          [this, read] { end(take(std::move(**read))); });
  if (!begun) return false;
  parts_.log.add_rows(Quotas::kRowsOfReload);
  current_ = current;
  return true;
}

const char* Reloads::why_not_begun() const { return parts_.reading.busy() ? kBusy : kNoThread; }

Response Reloads::begin(const Asker& asker) {
  if (!start_reading(asker.peer.session, parts_.reader())) return failed(why_not_begun());
  return Response([current = current_]() -> std::optional<serve::Slice> {
    if (!current->body) return std::nullopt;
    return serve::Slice{*current->body};
  });
}

void Reloads::begin() {
  if (!start_reading(0, parts_.reader())) parts_.log.error(Kind::reload, why_not_begun());
}

bool Reloads::begin(ReadDescription read, std::function<void(const std::string&)> done) {
  if (!start_reading(0, std::move(read))) return false;
  current_->done = std::move(done);
  return true;
}

void Reloads::poll() {
  if (!parts_.reading.waits() ||
      parts_.clock.monotonic_ns() - parts_.reading.begun() <= parts_.options.read_limit_ns)
    return;
  parts_.reading.forget();
  const std::string why = "nothing was changed: " + not_read_in_time(parts_.options);
  parts_.log.error(Kind::reload, why);
  end(control::Error{control::ErrorKind::unreadable, why, {}});
}

void Reloads::end(Body body) {
  const auto current = std::exchange(current_, nullptr);
  if (!current) return;
  current->body = std::move(body);
  if (current->done) {
    const auto* const error = std::get_if<control::Error>(&*current->body);
    std::string why;
    if (error != nullptr) why = error->details.empty() ? error->message : error->details.front();
    current->done(why);
  }
  if (ready_) ready_(current->session);
}

std::expected<Admissions::LeftOut, StartError> Reloads::complete(Described& described) const {
  auto left_out = parts_.admissions.restore_into(*described.state);
  if (const auto lack = described.state->exceeds_capacity(described.self))
    return std::unexpected(StartError{{parts_.options.description + ": " + *lack}, true});
  return left_out;
}

Body Reloads::refuse(StartError why) {
  last_error_ = why.lines.front();
  const std::string more =
      why.lines.size() > 1 ? fmt::format(" (and {} more)", why.lines.size() - 1) : "";
  parts_.log.error(Kind::reload,
                   fmt::format("reload refused, nothing changed: {}{}", last_error_, more));
  return control::Error{control::ErrorKind::unreadable,
                        "the description cannot be used, nothing was changed",
                        std::move(why.lines)};
}

/// A gate that the description needs cannot be made: there is no memory or no right.
Body Reloads::refuse(const Error& no_gates) {
  last_error_ = "nothing has changed: " + no_gates.text;
  parts_.log.error(Kind::reload, "reload refused, " + last_error_);
  return failed(last_error_);
}

/// The rows that a reload writes are charged to the user who requested it.
Body Reloads::take(DescribedResult read) {
  const auto actor = current_ ? current_->actor : std::nullopt;
  const EventLog::Acting acting(parts_.log, actor);
  Body done = put_in_force(std::move(read));
  if (actor) parts_.charge(actor->uid, acting.rows());
  return done;
}

Body Reloads::put_in_force(DescribedResult read) {
  const core::Progress alive(parts_.pulse);
  parts_.turn.commit();
  const auto before = parts_.recorder.granted();
  if (!read) return refuse(std::move(read.error()));
  for (const std::string& note : read->notes) parts_.log.warning(Kind::problem, note);
  auto left_out = complete(*read);
  if (!left_out) return refuse(std::move(left_out.error()));
  if (const auto ready = parts_.gates.prepare(read->state->system(), read->self); !ready)
    return refuse(ready.error());
  {
    const EventLog::Acting no_actor(parts_.log, std::nullopt);
    parts_.drops.report_all();  // under the names that it has now
  }
  last_error_.clear();
  Scene& scene = parts_.scene;
  Described former{std::exchange(scene.state, std::move(read->state)),
                   std::exchange(scene.self, read->self), std::exchange(scene.digest, read->digest),
                   std::exchange(scene.file_digest, read->file_digest)};
  former.unchecked = std::exchange(scene.unchecked, read->unchecked);
  scene.text = std::move(read->text);
  ++scene.description;
  auto loads = parts_.buses.carry_over(former.state->system());
  parts_.meshes.describe(scene.state->system(), scene.self);
  if (const auto done = parts_.put_in_force(before); !done)
    return roll_back(std::move(former), std::move(loads), before, done.error());
  parts_.gates.end_change();
  parts_.health.forget(parts_.pulse);
  parts_.drops.forget();
  parts_.turn.open_unless_lost();
  note_loaded();
  parts_.admissions.set_left_out(std::move(*left_out));
  const std::string line = "reloaded: " + parts_.summary();
  parts_.log.notice(Kind::reload, line);
  parts_.admissions.report_left_out();
  parts_.deliveries.outcome(before, parts_.deliveries.reported_of(*former.state));
  return control::Done{line};
}

Body Reloads::roll_back(Described former, BusMonitor::Loads loads,
                        const DeliveryEvents::Granted& before, const Error& why) {
  ++parts_.scene.description;
  parts_.scene.state = std::move(former.state);
  parts_.scene.self = former.self;
  parts_.scene.digest = former.digest;
  parts_.scene.file_digest = former.file_digest;
  parts_.scene.unchecked = former.unchecked;
  parts_.scene.text.clear();
  parts_.buses.restore(std::move(loads));
  last_error_ = why.text;
  parts_.log.error(Kind::reload, "reload refused, back to what was: " + last_error_);
  parts_.meshes.describe(parts_.scene.state->system(), parts_.scene.self);
  parts_.gates.go_back();
  static_cast<void>(parts_.put_in_force(before));
  parts_.gates.end_change();
  parts_.health.forget(parts_.pulse);
  parts_.drops.forget();
  parts_.turn.open_unless_lost();
  return failed(last_error_);
}

}  // namespace mlcca
