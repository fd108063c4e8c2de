// SPDX-License-Identifier: BSD-2-Clause
// A test bench for a complete gateway.
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "daemon/gateway/controller.hpp"
#include "tests/daemon/gateway/fakes.hpp"
#include "tests/daemon/store/fake_disk.hpp"

namespace mlcca::test {

using Random = std::mt19937_64;
inline std::size_t below(Random& random, std::size_t n) { return random() % n; }
inline bool chance(Random& random, unsigned percent) { return below(random, 100) < percent; }

inline constexpr Value kMs = 1'000'000;
inline constexpr core::Subject kUnlistedSubjects = 0x5600000000000000;

/// Two buses and an Ethernet behind one gateway "g". The only channel, "c0", goes from the first
/// bus to the second one.
core::System small_system();
/// A request for a further publisher, from the first bus to the second one.
control::Admit newcomer();
/// Two or three buses and an Ethernet behind one gateway, and four to seven channels with ends
/// anywhere. Usually not all of them fit.
core::System random_system(Random& random);
/// The same system with other ends, ports, rates or rules.
core::System varied(Random& random, core::System system);

/// A peer that may make changes, and one that may not.
serve::Peer member(std::uint64_t session = 1);
serve::Peer outsider(std::uint64_t session = 2);

/// A complete Controller with fakes around it. It can be ended, killed and started again.
class Bench {
 public:
  explicit Bench(core::System system);
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;
  Bench(Bench&&) = delete;
  Bench& operator=(Bench&&) = delete;
  ~Bench() { end(); }

  /// Starts a daemon. The result is its error if it cannot start.
  std::optional<StartError> start();
  /// The daemon ends without stopping.
  void end();
  /// Leaves on the disk what a loss of power at this moment leaves.
  void lose_power(std::mt19937& random);
  /// The daemon ends, and the next one finds an empty disk.
  void lose_disk();

  [[nodiscard]] bool runs() const { return controller_ != nullptr; }
  Controller& daemon() { return *controller_; }
  [[nodiscard]] const core::State& state() const { return *controller_->scene().state; }
  FakeGates& gates() { return *gates_; }
  FakeControl& control() { return *control_; }
  FakeBackground& reading() { return *reading_; }
  store::test::TroubledDisk& disk() { return *disk_; }
  /// Bytes of memory that the fake disk uses.
  [[nodiscard]] std::size_t held_by_disk() const { return memory_->held(); }
  EventLog& log() { return *log_; }

  /// Sends a request, and returns its reply: the last slice, if there are slices.
  serve::Answer ask(decltype(control::Request::body) body, serve::Peer peer = member());
  /// Does what the end of a turn of the loop does.
  void act() { controller_->act(); }
  /// A complete round of polls, which the daemon does once a second.
  void round();

  /// The rules that all gates together are to hold.
  [[nodiscard]] core::GateState wanted() const;
  /// The contents of the journal, read from a copy of the disk.
  [[nodiscard]] store::Contents recorded(std::mt19937& random) const;

  FakeKernel kernel;
  FakeClock clock;
  FakeCan can;
  core::System system;  ///< read by a start or a reload, unless `readable` is false
  bool readable = true;
  std::size_t self = 0;            ///< index of the gateway in the system
  ClusterLink* cluster = nullptr;  ///< null unless it is in a cluster
  std::uint8_t digest = 0;         ///< digest of the system in a cluster
  /// Descriptions that another gateway can pass on: the text "2" has the digest 2.
  std::map<std::uint8_t, core::System> handed_on;
  FakeTexts texts;
  bool initial_audit = false;  ///< as --initial-mode audit
  bool threads = false;        ///< operations that may hang on a disk run on a thread
  std::uint64_t lease_ns = 10'000'000'000;
  std::string state_directory = "/nowhere/at/all";  ///< of the history, which is on the real disk
  std::vector<Result<void>> commits;                ///< the arguments of on_commit()
  std::vector<std::string> events;                  ///< the kinds of all events
  std::vector<control::Event> published;            ///< the events that clients get

 private:
  std::unique_ptr<store::test::MemoryDisk> memory_;
  std::unique_ptr<store::test::TroubledDisk> disk_;
  std::unique_ptr<EventLog> log_;
  std::unique_ptr<FakeLinks> links_;
  std::unique_ptr<FakeGates> gates_;
  std::unique_ptr<FakeControl> control_;
  std::unique_ptr<FakeBackground> reading_;
  std::unique_ptr<Controller> controller_;
};

}  // namespace mlcca::test
