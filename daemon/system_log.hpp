// SPDX-License-Identifier: BSD-2-Clause
// The log for the operator: one line per event with structured fields, in the systemd journal or on
// stderr.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/handle.hpp"
#include "control/messages.hpp"

namespace mlcca {

/// The kinds of events, as control/event_kinds.inc lists them.
enum class Kind : std::uint8_t {
#define MLCCA_EVENT(identifier, ...) identifier,
#include "control/event_kinds.inc"
};

/// The name of a kind, for example "granted", as in events of the control protocol for clients that
/// want exact kinds.
[[nodiscard]] const char* name_of(Kind kind);
[[nodiscard]] std::optional<Kind> kind_named(std::string_view name);
/// All names: "started, stopped, …".
[[nodiscard]] std::string kind_names();
/// The MESSAGE_ID: 32 hexadecimal digits.
[[nodiscard]] const char* message_id_of(Kind kind);

/// A text such as "by alice, uid 1000, process 4242".
[[nodiscard]] std::string by_line(const control::Actor& actor);

/// One event, with everything that the log has about it.
struct Note {
  Kind kind = Kind::problem;
  int priority = 6;  ///< as in syslog: 2 critical, 3 error, 4 warning, 5 notice, 6 information
  std::string message = {};
  std::uint64_t subject = 0;  ///< 0: not about a subject
  std::string channel = {};
  std::string network = {};    ///< or gateway; of a delivery: the place to which it leads
  std::string from = {};       ///< of a delivery: the place of its publisher
  std::string publisher = {};  ///< of a delivery or frames: its name; empty: several, or none
  std::vector<std::uint64_t> admissions = {};  ///< the run-time admissions that it concerns
  std::uint64_t silent_ns = 0;            ///< of missing and restored: how long nothing has come
  std::uint64_t missing = 0;              ///< the number of events missing in that time
  std::uint64_t frames = 0;               ///< of dropped and policed: since the last report
  std::uint64_t late = 0;                 ///< of late: events since the last report
  std::uint64_t longest_ns = 0;           ///< the longest time of one of these events
  std::string network_down = {};          ///< of network_down: the unavailable network
  std::optional<control::Actor> by = {};  ///< the client that requested it
};

/// Writes notes without ever waiting for the reader, because the gates matter more than the log. A
/// line that cannot be written at once is lost; the next written line says how many were lost.
/// Copies write to the same place.
class SystemLog {
 public:
  /// Writes to journald if stderr of this process is a journal stream, otherwise to stderr.
  static SystemLog automatic();
  static SystemLog to_stderr();
  /// Writes in the native protocol of journald to the datagram socket at `path`.
  static SystemLog to_journald(std::string path) { return SystemLog(std::move(path)); }

  void write(const Note& note) const;

 private:
  explicit SystemLog(std::string path)
      : path_(std::move(path)), lost_(std::make_shared<std::uint64_t>(0)) {}
  [[nodiscard]] bool send(const Note& note, const std::string& message) const;

  std::string path_;  ///< the path of journald's socket; empty: stderr
  std::shared_ptr<std::uint64_t> lost_;
  std::shared_ptr<Fd> own_;  ///< a non-blocking descriptor of stderr; empty: there is none
};

}  // namespace mlcca
