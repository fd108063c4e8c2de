// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/system_log.hpp"

#include <fmt/core.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <span>
#include <string_view>

#include "base/at_once.hpp"
#include "base/many.hpp"
#include "base/text.hpp"
#include "control/event_kinds.hpp"
#include "core/model/text.hpp"

namespace mlcca {
namespace {

/// Indexed by Kind.
constexpr std::span kKinds = std::span(control::kEventKinds)
                                 .first(static_cast<std::size_t>(std::ranges::count_if(
                                     control::kEventKinds, &control::EventKind::message_id)));

/// Whether stderr is a journal stream: JOURNAL_STREAM has the device and inode of the stream that
/// systemd has given.
bool stderr_is_journal() {
  const char* stream = std::getenv("JOURNAL_STREAM");  // NOLINT(concurrency-mt-unsafe)
  struct stat here{};
  if (stream == nullptr || ::fstat(STDERR_FILENO, &here) < 0) return false;
  return std::string_view(stream) ==
         std::to_string(here.st_dev) + ":" + std::to_string(here.st_ino);
}

const char* verdict_of(Kind kind) {
  switch (kKinds[static_cast<std::size_t>(kind)].verdict) {
    case control::EventVerdict::none:
      return nullptr;
    case control::EventVerdict::granted:
      return "granted";
    case control::EventVerdict::refused:
    case control::EventVerdict::withdrawal:
      return "refused";
  }
  return nullptr;
}

/// Adds one field in the native protocol of journald (systemd.io/JOURNAL_NATIVE_PROTOCOL). Its
/// value may contain any bytes.
void add_field(std::string& fields, std::string_view name, std::string_view value) {
  constexpr std::size_t most = 32UL * 1024;  // bytes of a value: all fields fit a datagram
  value = cut(value, most);
  fields.append(name).push_back('\n');
  for (std::uint64_t size = value.size(), i = 0; i < 8; ++i, size >>= 8)
    fields.push_back(static_cast<char>(size & 0xff));
  fields.append(value).push_back('\n');
}

}  // namespace

const char* name_of(Kind kind) { return kKinds[static_cast<std::size_t>(kind)].name; }
std::optional<Kind> kind_named(std::string_view name) {
  const auto at = std::ranges::find(kKinds, name, &control::EventKind::name);
  if (at == kKinds.end()) return std::nullopt;
  return static_cast<Kind>(at - kKinds.begin());
}
std::string by_line(const control::Actor& actor) {
  return fmt::format("by {}uid {}, process {}", actor.user.empty() ? "" : actor.user + ", ",
                     actor.uid, actor.pid);
}
std::string kind_names() {
  std::string names;
  for (const control::EventKind& kind : kKinds)
    names += (names.empty() ? "" : ", ") + std::string(kind.name);
  return names;
}
const char* message_id_of(Kind kind) { return kKinds[static_cast<std::size_t>(kind)].message_id; }

SystemLog SystemLog::automatic() {
  return stderr_is_journal() ? to_journald("/run/systemd/journal/socket") : to_stderr();
}

/// Opens the descriptor now, because later there may be none left.
SystemLog SystemLog::to_stderr() {
  SystemLog log({});
  log.own_ = std::make_shared<Fd>(opened_at_once(STDERR_FILENO));
  return log;
}

bool SystemLog::send(const Note& note, const std::string& message) const {
  if (path_.empty())
    // A lost line may have been written in part; the line break ends it.
    return write_at_once(own_ && *own_ ? own_->get() : STDERR_FILENO,
                         (*lost_ == 0 ? "" : "\n") + message + '\n');
  std::string fields;
  add_field(fields, "MESSAGE", message);
  add_field(fields, "PRIORITY", std::to_string(note.priority));
  add_field(fields, "MESSAGE_ID", message_id_of(note.kind));
  add_field(fields, "MLCCA_KIND", name_of(note.kind));
  add_field(fields, "SYSLOG_IDENTIFIER", "mlccad");
  if (note.subject != 0) add_field(fields, "SUBJECT", core::format_subject(note.subject));
  if (!note.channel.empty()) add_field(fields, "CHANNEL", note.channel);
  if (!note.network.empty()) add_field(fields, "NETWORK", note.network);
  if (!note.from.empty()) add_field(fields, "FROM", note.from);
  if (!note.publisher.empty()) add_field(fields, "PUBLISHER", note.publisher);
  if (note.by) {
    add_field(fields, "CLIENT_UID", std::to_string(note.by->uid));
    add_field(fields, "CLIENT_PID", std::to_string(note.by->pid));
    if (!note.by->user.empty()) add_field(fields, "CLIENT_USER", note.by->user);
  }
  if (const char* verdict = verdict_of(note.kind)) add_field(fields, "VERDICT", verdict);
  const iovec whole{fields.data(), fields.size()};
  return send_at_once(path_, {&whole, 1});
}

void SystemLog::write(const Note& note) const {
  const std::string before =
      *lost_ == 0 ? ""
                  : fmt::format("({} before this one {} not read) ", many(*lost_, "line"),
                                *lost_ == 1 ? "was lost: it was" : "were lost: they were");
  if (send(note, before + note.message))
    *lost_ = 0;
  else
    ++*lost_;
}

}  // namespace mlcca
