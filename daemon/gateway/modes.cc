// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/modes.hpp"

#include <fmt/core.h>

#include <optional>
#include <string>

#include "core/model/text.hpp"

namespace mlcca {

void Modes::begin(bool in_audit_mode) {
  begins_in_audit_ = in_audit_mode;
  if (is_to_be_introduced()) control_.set_mode(gates::Mode::audit);
}

void Modes::report() {
  if (is_audit()) log_.warning(Kind::mode, audit_line());
}

/// The entry is on disk at the end of the turn, before the client gets its answer.
void Modes::note_introduced() {
  if (is_to_be_introduced()) recorder_.note_introduced();
}

std::string Modes::audit_line() const {
  return fmt::format("AUDIT MODE: nothing is dropped, everything is only counted{}",
                     is_to_be_introduced()
                         ? ", over restarts until 'mlccactl mode enforce' (--initial-mode audit)"
                         : "");
}

/// Reports the drops so far under the mode in which they happened. No client is named as their
/// cause.
void Modes::report_drops() {
  const EventLog::Acting no_actor(log_, std::nullopt);
  drops_.report_all();
}

control::Done Modes::set(gates::Mode mode) {
  report_drops();
  when_clean_ = 0;
  control_.set_mode(mode);
  if (mode == gates::Mode::audit) {
    audit_.restart_clean();
    std::string line = audit_line();
    log_.warning(Kind::mode, line);
    return {std::move(line)};
  }
  note_introduced();
  std::string line = "enforcing: what is not admitted is dropped";
  log_.notice(Kind::mode, line);
  return {std::move(line)};
}

control::Done Modes::enforce() { return set(gates::Mode::enforce); }
control::Done Modes::audit() { return set(gates::Mode::audit); }

Result<control::Done> Modes::enforce_when_clean(std::uint64_t when_clean) {
  if (!is_audit())
    return fail("the gates enforce already: 'mode audit' is what comes before --when-clean");
  when_clean_ = when_clean;
  std::string line = fmt::format(
      "audit mode until nothing would have been dropped for {}: then the gates enforce; for {} "
      "nothing would have been",
      core::format_span(when_clean), core::format_span(clean()));
  log_.notice(Kind::mode, line);
  return control::Done{std::move(line)};
}

void Modes::restore(std::uint64_t when_clean) {
  if (!is_audit() || when_clean == 0) return;
  when_clean_ = when_clean;
  log_.notice(Kind::mode,
              fmt::format("the gates enforce when nothing would have been dropped for {} from now "
                          "on, as was asked for",
                          core::format_span(when_clean)));
}

/// Decides by the final counters, because more may have been counted since the latest poll.
void Modes::poll() {
  if (!is_audit()) note_introduced();  // again, if the disk refused it before
  if (when_clean() == 0 || clean() < when_clean_) return;
  report_drops();
  if (clean() < when_clean_) return;
  log_.notice(Kind::mode, fmt::format("nothing would have been dropped for {}",
                                      core::format_span(when_clean_)));
  set(gates::Mode::enforce);
}

const char* Modes::name() const { return is_audit() ? "audit" : "enforce"; }

}  // namespace mlcca
