// SPDX-License-Identifier: BSD-2-Clause
// The word that opens and closes all gates of this gateway, with the deadline after which they
// close when the daemon falls silent, and the kernel timer that counts that. Lives in pinned maps:
// it outlasts the daemon; what the gates read also outlasts its pin.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "bpf/gate.h"

namespace mlcca::enforce {

enum class Mode : std::uint8_t {
  enforce,
  audit,  ///< count what would be dropped, drop nothing
};

/// Grace that never ends: verdicts stay however long the daemon is silent.
inline constexpr std::uint64_t kForEver = ~std::uint64_t{0};
inline constexpr std::uint64_t kDefaultGrace = 10'000'000'000;  ///< ns
/// A shorter grace is taken as this: a busy daemon could not be distinguished from a dead one.
inline constexpr std::uint64_t kShortestGrace = 100'000'000;  ///< ns

/// The maps that all gates share, by their descriptors, and the epoch of a gate that this daemon
/// holds.
struct SharedMaps {
  int control = -1;
  int events = -1;
  std::uint32_t epoch = 0;
};

class Control {
 public:
  /// Opens the pinned maps below `root`/v1 (a directory of a bpffs; made if absent) as they are, or
  /// makes them: closed, enforcing, grace of 10 s, no heart-beat yet, timer not armed. Errors: no
  /// bpffs, no privilege, maps of another layout.
  static Result<Control> create(const std::string& root);
  /// In memory that nothing names: closed, and it cannot be opened any more when this object is
  /// gone.
  static Result<Control> create_unpinned();
  Control(Control&&) noexcept;
  Control& operator=(Control&&) noexcept;
  Control(const Control&) = delete;
  Control& operator=(const Control&) = delete;
  ~Control();

  /// The maps were there before: a daemon has run since boot.
  [[nodiscard]] bool reused() const;
  /// What had names that are ours, and was no object of ours: replaced, a line of each, once. The
  /// gates that are attached hold what they read, pinned or not; those close, and are made again.
  [[nodiscard]] std::vector<std::string> take_replaced();

  /// Every gate that this daemon holds is in place: whatever is left of one before it, and held by
  /// none, is closed from now on, wherever it is.
  void take_over();
  /// After take_over(): writes again which daemon holds the gates, if another program has written
  /// over it. True: it has; the gates were closed.
  bool keep_epoch();

  void open();
  /// Everything is denied on every interface; slots stay as they are.
  void close_all();
  [[nodiscard]] bool is_open() const;

  void set_mode(Mode mode);
  [[nodiscard]] Mode mode() const;

  /// Sign of life, to be given at least every beat_interval(). `now`: CLOCK_MONOTONIC, ns. One that
  /// comes too late finds the gates closed, and they stay so: see lapsed().
  Result<void> beat(std::uint64_t now);
  /// Quarter of the grace, at most 1 s, in ns.
  [[nodiscard]] std::uint64_t beat_interval() const;

  /// The kernel has closed the gates because of our silence. Observe the interfaces again, then
  /// clear.
  [[nodiscard]] bool lapsed() const;
  [[nodiscard]] std::uint64_t lapses() const;
  /// Counts as a beat, so that nothing closes again at once.
  Result<void> clear_lapse(std::uint64_t now);

  /// How long verdicts outlive the daemon, in ns: the gates close by themselves within two ticks of
  /// the kernel's clock after that. A shorter one holds at once. Restarts an armed timer, which
  /// checks every eighth of the grace, from 20 ms to 1 s. What was set is also pinned where no
  /// program can alter it (see noted_grace()).
  Result<void> set_grace(std::uint64_t grace);
  /// Sets again what set_grace() has set, if another program has overwritten it. True if it was.
  Result<bool> keep_grace();
  [[nodiscard]] std::uint64_t grace() const;

  /// Until when the gates may be open at the most, whatever heart-beats come: CLOCK_MONOTONIC, ns;
  /// 0: as long as they come, which is so where nothing was set. They close up to two ticks of the
  /// kernel's clock before that. An earlier one than before holds at once, a later one from the
  /// next beat on. It is pinned, and holds for the next daemon until that sets another one.
  Result<void> set_until(std::uint64_t until);
  [[nodiscard]] std::uint64_t until() const;

  /// Starts the kernel timer; beat() first. Harmless when it runs: it then calls the new program.
  Result<void> arm();

  /// Pins again what another program has unpinned: without its pin the timer would end with the
  /// daemon, and the gates stay open. True if anything was.
  Result<bool> keep_pinned();

  /// Directory of the pins, `root`/v1.
  [[nodiscard]] const std::string& directory() const;
  /// The map that gates share; stays ours.
  [[nodiscard]] int map_fd() const;
  /// The ring of gate_event that all gates share; stays ours.
  [[nodiscard]] int events_fd() const;
  [[nodiscard]] SharedMaps shared() const { return {map_fd(), events_fd(), epoch()}; }

 private:
  struct State;
  explicit Control(std::unique_ptr<State> state);
  [[nodiscard]] gate_control& word() const;
  [[nodiscard]] std::uint32_t epoch() const;
  std::unique_ptr<State> state_;
};

/// What a grace makes of the control word.
struct GraceWords {
  std::uint64_t grace_ns = 0;
  std::uint64_t grace_ticks = 0;
  std::uint64_t check_ns = 0;
  bool operator==(const GraceWords&) const = default;
};
Result<GraceWords> words_of_grace(std::uint64_t grace);
GraceWords words_of_grace(const gate_control& word);

/// The grace that a daemon has set last, in ns, which no program can write to since; nothing where
/// none has.
std::optional<std::uint64_t> noted_grace(const std::string& directory);
/// How long the gates of a word stay open from now on without a heart-beat, in ns, rounded down;
/// at most 2^32 ticks. Error: no right to ask, or no memory.
Result<std::uint64_t> time_left(int control_map);

}  // namespace mlcca::enforce
