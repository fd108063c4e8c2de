// SPDX-License-Identifier: BSD-2-Clause
// Passes everything that has happened to three readers: the log of the operator, the history on
// disk, and the clients that follow events.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "control/messages.hpp"
#include "daemon/system_log.hpp"

namespace mlcca::store {
class History;
}

namespace mlcca {

/// Writes events. Each one goes to the system log, to the history if there is one, and to clients.
class EventLog {
 public:
  using Publish = std::function<void(const control::Event&)>;

  explicit EventLog(SystemLog log) : log_(std::move(log)) {}

  void on_event(Publish publish) { publish_ = std::move(publish); }
  /// Events are also written to `history` from now on. It must outlive this object.
  void keep_in(store::History& history) { history_ = &history; }

  // `about`: what the event concerns. Its kind, priority and message are set here.

  void critical(Kind kind, std::string message, Note about = {}) {
    write(kind, 2, std::move(message), std::move(about));
  }
  void error(Kind kind, std::string message, Note about = {}) {
    write(kind, 3, std::move(message), std::move(about));
  }
  void warning(Kind kind, std::string message, Note about = {}) {
    write(kind, 4, std::move(message), std::move(about));
  }
  void notice(Kind kind, std::string message, Note about = {}) {
    write(kind, 5, std::move(message), std::move(about));
  }
  void info(Kind kind, std::string message, Note about = {}) {
    write(kind, 6, std::move(message), std::move(about));
  }
  void write(Note note);
  /// Passes an event to clients only, not to the log or the history.
  void notify_clients(control::Event event) const;

  /// A request that is carried out. While it lives, events are attributed to `actor`, who made the
  /// request. nullopt: the daemon acts by itself.
  class Acting {
   public:
    Acting(EventLog& log, std::optional<control::Actor> actor)
        : log_(log), before_(std::exchange(log.actor_, std::move(actor))), rows_(log.rows_) {}
    Acting(const Acting&) = delete;
    Acting& operator=(const Acting&) = delete;
    Acting(Acting&&) = delete;
    Acting& operator=(Acting&&) = delete;
    ~Acting() { log_.actor_ = std::move(before_); }
    /// The rows of the history that the request has cost so far.
    [[nodiscard]] std::uint64_t rows() const { return log_.rows_ - rows_; }

   private:
    EventLog& log_;
    std::optional<control::Actor> before_;
    std::uint64_t rows_;
  };
  [[nodiscard]] const std::optional<control::Actor>& actor() const { return actor_; }

  /// The rows of the history that were written, or will be due to what was written, since this
  /// object was made. Quotas of users are charged with them.
  [[nodiscard]] std::uint64_t rows() const { return rows_; }
  /// Counts rows that a change will write later.
  void add_rows(std::uint64_t rows) { rows_ += rows; }

 private:
  void write(Kind kind, int priority, std::string message, Note about);

  SystemLog log_;
  store::History* history_ = nullptr;
  Publish publish_;
  std::optional<control::Actor> actor_;  ///< who requested the current change
  std::uint64_t rows_ = 0;
};

}  // namespace mlcca
