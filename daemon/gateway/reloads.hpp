// SPDX-License-Identifier: BSD-2-Clause
// Puts another description in the place of the one in force: reads it on a thread, then puts it in
// force in one step of the loop, or changes nothing.
#pragma once
#include <sys/types.h>

#include <cstdint>
#include <expected>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "control/messages.hpp"
#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/bus_monitor.hpp"
#include "daemon/gateway/delivery_events.hpp"
#include "daemon/gateway/delivery_health.hpp"
#include "daemon/gateway/described.hpp"
#include "daemon/gateway/drop_reports.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/meshes.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/requests/response.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/gateway/turn.hpp"
#include "daemon/outside/background.hpp"
#include "daemon/outside/gate_driver.hpp"

namespace mlcca {

/// A reload that was requested by a client, the service manager or a rollout. Only one is under way
/// at a time.
class Reloads {
 public:
  using Ready = std::function<void(std::uint64_t session)>;

  /// All references must outlive this object.
  struct Parts {
    const Options& options;
    /// Returns the function that reads the description that is to be loaded now.
    std::function<ReadDescription()> reader;
    Background& reading;
    const Clock& clock;
    GateDriver& gates;
    Scene& scene;
    EventLog& log;
    DeliveryEvents& deliveries;
    DeliveryHealth& health;
    DropReports& drops;
    Recorder& recorder;
    Turn& turn;
    Admissions& admissions;
    BusMonitor& buses;
    Meshes& meshes;
    /// Brings interfaces, links and gates in line with the description that the scene has now. What
    /// was granted before is handled first.
    std::function<Result<void>(const DeliveryEvents::Granted&)> put_in_force;
    /// The state of the gateway in one line.
    std::function<std::string()> summary;
    /// Charges the quota of a user with rows of the history.
    std::function<void(uid_t user, std::uint64_t rows)> charge;
    std::function<void()> pulse;
  };
  explicit Reloads(Parts parts) : parts_(std::move(parts)) {}

  /// Sets the function that is called with the session whose reload has ended.
  void on_ready(Ready ready) { ready_ = std::move(ready); }
  /// Begins a reload for a client. The response comes when it has ended.
  Response begin(const Asker& asker);
  /// Begins a reload for the service manager. Problems go to the log.
  void begin();
  /// Begins to load another description than that of the file; false if that is not possible now.
  /// `done` gets why it is not in force; empty if it is.
  bool begin(ReadDescription read, std::function<void(const std::string& why)> done);
  /// To be called once a second: gives up a description that takes too long to read.
  void poll();

  /// Adds what was admitted at run time to `described`. Returns the admissions without a place in
  /// it; the error says why the description cannot be used.
  [[nodiscard]] std::expected<Admissions::LeftOut, StartError> complete(Described& described) const;
  /// When the description in force was read: seconds since 1970.
  [[nodiscard]] std::uint64_t loaded() const { return loaded_; }
  void note_loaded() { loaded_ = parts_.clock.unix_ns() / 1'000'000'000; }
  /// Why the latest reload was refused; empty if it was not.
  [[nodiscard]] const std::string& last_error() const { return last_error_; }

 private:
  /// The reload that is under way, and who waits for it.
  struct Current {
    std::optional<Body> body;
    std::uint64_t session = 0;
    std::optional<control::Actor> actor;
    std::function<void(const std::string&)> done{};
  };
  [[nodiscard]] bool start_reading(std::uint64_t session, ReadDescription from);
  [[nodiscard]] const char* why_not_begun() const;
  void end(Body body);
  Body take(DescribedResult read);
  Body put_in_force(DescribedResult read);
  Body refuse(StartError why);
  Body refuse(const Error& no_gates);
  Body roll_back(Described former, BusMonitor::Loads loads, const DeliveryEvents::Granted& before,
                 const Error& why);

  Parts parts_;
  Ready ready_;
  std::shared_ptr<Current> current_;
  std::uint64_t loaded_ = 0;
  std::string last_error_;
};

}  // namespace mlcca
