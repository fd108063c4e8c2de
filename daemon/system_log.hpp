// SPDX-License-Identifier: BSD-2-Clause
// What the operator reads: one line an event with structured fields, in the journal or on stderr.
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

/// Kinds of events; each has a MESSAGE_ID of its own (docs/man/mlccad.8 lists them).
enum class Kind : std::uint8_t {
  started,
  stopped,
  granted,
  refused,
  withdrawn,
  revoked,       ///< withdrawn by an operator
  network_down,  ///< withdrawn because a network is not available
  removed,       ///< was granted, and the description has it no more
  switched,
  rerouted,  ///< a delivery that is granted takes another way
  released,
  reinstated,  ///< an operator takes it back that a channel was withdrawn
  dropping,
  excess,
  missing,
  restored,
  late,  ///< a program that carries events took longer than the gateway states
  interface,
  gateway,  ///< another gateway has failed, or is back; or this one gives way to it
  mode,
  reload,
  lapsed,
  drift,    ///< the kernel is not as it was set up
  bypass,   ///< frames were sent past a gate
  binding,  ///< the broker of a FAMOUSO bus has dealt a tag that is not as it was
  rollout,  ///< of a description, to all gateways of a cluster
  trouble,
};

/// "granted", as in events of the control protocol for who wants exact kinds.
[[nodiscard]] const char* name_of(Kind kind);
[[nodiscard]] std::optional<Kind> kind_named(std::string_view name);
/// "started, stopped, …"
[[nodiscard]] std::string kind_names();
/// 32 hex digits.
[[nodiscard]] const char* message_id_of(Kind kind);

/// "by alice, uid 1000, process 4242"
[[nodiscard]] std::string by_line(const control::Actor& actor);

struct Note {
  Kind kind = Kind::trouble;
  int priority = 6;  ///< as in syslog: 3 error, 4 warning, 5 notice, 6 information
  std::string message = {};
  std::uint64_t subject = 0;  ///< 0: not about a subject
  std::string channel = {};
  std::string network = {};    ///< or gateway; of a delivery the place that it leads to
  std::string from = {};       ///< of a delivery: the place of its publisher
  std::string publisher = {};  ///< of a delivery or of frames: its name; empty: several, or none
  std::vector<std::uint64_t> admissions = {};  ///< run-time admissions that it concerns
  std::uint64_t silent_ns = 0;                 ///< of missing and restored: how long nothing came
  std::uint64_t missing = 0;                   ///< and how many events that are
  std::uint64_t frames = 0;                    ///< of dropping and excess: since the last report
  std::uint64_t late = 0;                      ///< of late: events since the last report
  std::uint64_t longest_ns = 0;                ///< and the longest time of one of them
  std::string network_down = {};          ///< of network_down: the network that is not available
  std::optional<control::Actor> by = {};  ///< the client that asked for it
};

/// Nothing here waits for whoever reads: the gates matter more than the log. A line that cannot be
/// taken at once is lost, and the next one that is taken says how many were. Copies write to the
/// same place.
class SystemLog {
 public:
  /// To journald when this process's stderr is a journal stream, else to stderr.
  static SystemLog automatic();
  static SystemLog to_stderr();
  /// In the native protocol of journald, to a datagram socket of that path.
  static SystemLog to_journald(std::string path) { return SystemLog(std::move(path)); }

  void write(const Note& note) const;

 private:
  explicit SystemLog(std::string path)
      : path_(std::move(path)), lost_(std::make_shared<std::uint64_t>(0)) {}
  [[nodiscard]] bool send(const Note& note, const std::string& message) const;

  std::string path_;  ///< of journald's socket; empty: stderr
  std::shared_ptr<std::uint64_t> lost_;
  std::shared_ptr<Fd> own_;  ///< stderr once more, which never waits; none: it cannot be had
};

}  // namespace mlcca
