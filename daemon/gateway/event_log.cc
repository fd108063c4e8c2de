// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/event_log.hpp"

#include "base/clock.hpp"
#include "daemon/store/history.hpp"

namespace mlcca {
namespace {

/// Drops, which may come and go each second, are in the log only.
bool is_history(Kind kind) { return kind != Kind::dropped; }

}  // namespace

void EventLog::write(Kind kind, int priority, std::string message, Note about) {
  about.kind = kind;
  about.priority = priority;
  about.message = std::move(message);
  write(std::move(about));
}

void EventLog::write(Note note) {
  note.by = actor_;
  if (note.by) note.message += " (" + by_line(*note.by) + ")";
  log_.write(note);
  const std::uint64_t now = unix_ns();
  if (is_history(note.kind)) ++rows_;
  if (history_ != nullptr && is_history(note.kind))
    history_->append({now, name_of(note.kind), note.subject, note.channel, note.from,
                      note.from.empty() ? "" : note.network, note.from.empty() ? note.network : "",
                      note.message, note.by});
  if (!publish_) return;
  control::Event event;
  event.unix_ns = now;
  event.kind = name_of(note.kind);
  event.subject = note.subject;
  event.channel = std::move(note.channel);
  event.network = std::move(note.network);
  event.message = std::move(note.message);
  event.admissions = std::move(note.admissions);
  event.silent_ns = note.silent_ns;
  event.frames = note.frames;
  event.late = note.late;
  event.longest_ns = note.longest_ns;
  event.missing = note.missing;
  event.client = std::move(note.by);
  event.publisher = std::move(note.publisher);
  event.network_down = std::move(note.network_down);
  publish_(event);
}

void EventLog::notify_clients(control::Event event) const {
  if (!publish_) return;
  event.unix_ns = unix_ns();
  publish_(event);
}

}  // namespace mlcca
