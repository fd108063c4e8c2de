// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/system_log.hpp"

#include <fmt/core.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string_view>

#include "base/many.hpp"
#include "base/text.hpp"
#include "core/model/text.hpp"
#include "daemon/manager.hpp"

namespace mlcca {
namespace {

struct KindInfo {
  const char* name;
  const char* message_id;
};
// Indexed by Kind. The ids must never change, because operators filter by them.
constexpr std::array kKinds{
    KindInfo{"started", "14b643dd05dc43898c7b5b35e1589983"},
    KindInfo{"stopped", "f43723b89f424375a34f886fc34794e7"},
    KindInfo{"granted", "36505939845e4576b62c8f50eff44cfa"},
    KindInfo{"refused", "a761365c7d7649f79e98dc3442aa1d7a"},
    KindInfo{"withdrawn", "08b8e094cb174563a6171d269dba6874"},
    KindInfo{"revoked", "b1f4d7a92c0e4e638a57c3d06f9e2b84"},
    KindInfo{"network-down", "e05c2b7d41fa4b96935d8c6a07f31e42"},
    KindInfo{"removed", "4d7a0c95e1b2463f8f6e9a3b57d10c28"},
    KindInfo{"switched", "349a04610aa34f5dbd79b55781cb57a0"},
    KindInfo{"rerouted", "e7c1a84d52f043b6930d7be164a2f85c"},
    KindInfo{"released", "07140c11d56b4440bad6cc08ff7d96aa"},
    KindInfo{"reinstated", "5b0e3a1c97d24f6c8a40e2f17d9b6c33"},
    KindInfo{"dropping", "009adc297a61474d8ea0e3a17efa72f3"},
    KindInfo{"excess", "faf4d5399e254409bf55d3b1bb42104d"},
    KindInfo{"missing", "6f0a1c52b7e94d30a1d4c86e2f935b17"},
    KindInfo{"restored", "c2d87e4195f34ab68e03b7d1a65cf928"},
    KindInfo{"late", "3c9b51e07a644f1d8e25d0b7f6a1984c"},
    KindInfo{"interface", "f1d09b13c2ac45a9b3d48dcf98334a4e"},
    KindInfo{"gateway", "a94f0c6de27b4b1c9d35c1f08be6471e"},
    KindInfo{"mode", "8e4024714a6c4e21bebd3ea336faf49b"},
    KindInfo{"reload", "16600d2717154f5087c62d70858f4596"},
    KindInfo{"lapsed", "9e1ef985cd944886ba5ceea7d0859707"},
    KindInfo{"drift", "d2984a3083094b93aa490521986a712f"},
    KindInfo{"bypass", "49eae898e745474a8708fcd4a5987dda"},
    KindInfo{"binding", "7d3e1a5c20964f8b9c51e6f40b2a8d17"},
    KindInfo{"rollout", "4be0d1c72a5f4c0f9e8a7d36b15c2f90"},
    KindInfo{"trouble", "11436d69f9dc477a90d4c483ce53572b"},
};

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
  switch (kind) {
    case Kind::granted:
    case Kind::switched:
    case Kind::rerouted:
      return "granted";
    case Kind::refused:
    case Kind::withdrawn:
    case Kind::revoked:
    case Kind::network_down:
    case Kind::removed:
    case Kind::released:
      return "refused";
    default:
      return nullptr;
  }
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
  const auto* const at = std::ranges::find(kKinds, name, &KindInfo::name);
  if (at == kKinds.end()) return std::nullopt;
  return static_cast<Kind>(at - kKinds.begin());
}
std::string by_line(const control::Actor& actor) {
  return fmt::format("by {}uid {}, process {}", actor.user.empty() ? "" : actor.user + ", ",
                     actor.uid, actor.pid);
}
std::string kind_names() {
  std::string names;
  for (const KindInfo& kind : kKinds) names += (names.empty() ? "" : ", ") + std::string(kind.name);
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
