// SPDX-License-Identifier: BSD-2-Clause
// A gateway on a bench: a whole Controller among fakes, which can be ended, killed and started
// again; and a small world for it.
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

/// Two buses and an Ethernet behind one gateway "g"; a channel "c0" goes from the first bus to the
/// second one, and there is no other one.
core::System small_system();
/// From its first bus to the second one.
control::Admit newcomer();
/// Two or three buses and an Ethernet behind one gateway; four to seven channels whose ends are
/// anywhere. Mostly not all of them fit.
core::System random_system(Random& random);
/// The same with other ends, ports, rates or rules.
core::System varied(Random& random, core::System system);

/// A peer that may change something, or may not.
serve::Peer member(std::uint64_t session = 1);
serve::Peer outsider(std::uint64_t session = 2);

class Bench {
 public:
  explicit Bench(core::System system);
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;
  Bench(Bench&&) = delete;
  Bench& operator=(Bench&&) = delete;
  ~Bench() { end(); }

  /// A daemon of its own; what it says when it cannot start.
  std::optional<StartError> start();
  /// It is gone, without a word.
  void end();
  /// What the disk has after a loss of power now.
  void lose_power(std::mt19937& random);

  [[nodiscard]] bool runs() const { return controller_ != nullptr; }
  Controller& daemon() { return *controller_; }
  [[nodiscard]] const core::State& state() const { return *controller_->scene().state; }
  FakeGates& gates() { return *gates_; }
  FakeControl& control() { return *control_; }
  FakeBackground& reading() { return *reading_; }
  store::test::TroubledDisk& disk() { return *disk_; }
  /// Memory that stands for the disk.
  [[nodiscard]] std::size_t held_by_disk() const { return memory_->held(); }
  EventLog& log() { return *log_; }

  /// The body of the reply: that of the last slice, if there are slices that can be had.
  serve::Answer ask(decltype(control::Request::body) body, serve::Peer peer = member());
  /// As a turn of the loop ends.
  void act() { controller_->act(); }
  /// A whole round of polls, as once a second.
  void round();

  /// What all gates are to hold.
  [[nodiscard]] core::GateState wanted() const;
  /// The journal as another reader finds it on a copy of the disk.
  [[nodiscard]] store::Contents recorded(std::mt19937& random) const;

  FakeKernel kernel;
  FakeClock clock;
  FakeCan can;
  core::System system;  ///< what a start or a reload reads; none: it cannot be read
  bool readable = true;
  std::size_t self = 0;            ///< which gateway of the system it is
  ClusterLink* cluster = nullptr;  ///< where it shares networks by a store
  std::uint8_t digest = 0;         ///< of the system, then
  /// Descriptions that another gateway can hand on: "2" is a text of the digest 2.
  std::map<std::uint8_t, core::System> handed_on;
  FakeTexts texts;
  bool initial_audit = false;  ///< it is to be introduced in audit mode
  bool threads = false;        ///< what may hang on a disk is done on a thread
  std::uint64_t lease_ns = 10'000'000'000;
  std::string state_directory = "/nowhere/at/all";  ///< of the history, on the real disk
  std::vector<Result<void>> commits;                ///< what on_commit() was called with
  std::vector<std::string> events;                  ///< kinds
  std::vector<control::Event> published;            ///< the same as clients get them

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
