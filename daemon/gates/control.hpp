// SPDX-License-Identifier: BSD-2-Clause
// The control word, which opens and closes all gates of this gateway and has their deadline, and
// the kernel timer that closes them when the daemon is silent (the dead-man). They are in pinned
// maps and outlive the daemon; the gates hold the word even if its pin is removed.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "bpf/gate.h"

namespace mlcca::gates {

/// How gates treat frames that are not admitted.
enum class Mode : std::uint8_t {
  enforce,
  audit,  ///< count what would be dropped, and drop nothing
};

/// A grace period that never ends: verdicts stay in force however long the daemon is silent.
inline constexpr std::uint64_t kForEver = ~std::uint64_t{0};
inline constexpr std::uint64_t kDefaultGrace = 10'000'000'000;  ///< ns
/// Shorter grace periods are set to this one, because a busy daemon could not be distinguished from
/// a dead one.
inline constexpr std::uint64_t kShortestGrace = 100'000'000;  ///< ns

/// The descriptors of the maps that all gates share, and the epoch of the gates that this daemon
/// holds.
struct SharedMaps {
  int control = -1;
  int events = -1;
  std::uint32_t epoch = 0;
};

/// Owns the maps of the control word and the programs of the dead-man, and gives heart-beats. Apart
/// from the methods that return a Result, its methods are single loads and stores in memory that
/// the kernel shares.
class Control {
 public:
  /// Opens the maps that are pinned in `root`/v<layout> (in a bpffs; made if absent) as they are.
  /// Otherwise makes them: closed, enforcing, with a grace of 10 s, no heart-beat yet and the timer
  /// not armed. Errors: no bpffs, no privilege, maps of another layout.
  static Result<Control> create(const std::string& root);
  /// Makes the maps in memory without a pin: closed, and impossible to open once this object is
  /// gone.
  static Result<Control> create_unpinned();
  Control(Control&&) noexcept;
  Control& operator=(Control&&) noexcept;
  Control(const Control&) = delete;
  Control& operator=(const Control&) = delete;
  ~Control();

  /// Whether the maps existed before: a daemon has run since boot.
  [[nodiscard]] bool reused() const;
  /// What had one of our names and was not an object of ours, so that it was replaced: one line
  /// each, reported once. Attached gates still read their former objects, which get no heart-beat,
  /// so they close and have to be made again.
  [[nodiscard]] std::vector<std::string> take_replaced();

  /// Called when every gate that this daemon holds is in place. All other gates, left by an earlier
  /// daemon, are closed from now on, wherever they are.
  void take_over();
  /// After take_over(): if another program has overwritten which daemon holds the gates, writes it
  /// again. True if it was overwritten; the gates were closed then.
  bool keep_epoch();

  void open();
  /// Denies everything on every interface. The slots stay as they are.
  void close_all();
  [[nodiscard]] bool is_open() const;

  void set_mode(Mode mode);
  [[nodiscard]] Mode mode() const;

  /// Gives a heart-beat; to be called at least every beat_interval(). `now`: CLOCK_MONOTONIC, ns.
  /// If it comes too late the gates have closed, and they stay closed: see lapsed().
  Result<void> beat(std::uint64_t now);
  /// ns between heart-beats: a quarter of the grace period, at most 1 s.
  [[nodiscard]] std::uint64_t beat_interval() const;

  /// Whether the kernel has closed the gates because of the daemon's silence. The caller must
  /// observe all interfaces again before it calls clear_lapse().
  [[nodiscard]] bool lapsed() const;
  /// How often the gates have closed that way.
  [[nodiscard]] std::uint64_t lapses() const;
  /// Ends the lapse. Counts as a heart-beat, so that the gates do not close again at once.
  Result<void> clear_lapse(std::uint64_t now);

  /// Sets how long verdicts stay in force without a heart-beat, ns; the gates close within two
  /// ticks of the kernel's clock after that. A shorter grace holds at once. An armed timer is
  /// restarted; it checks every eighth of the grace, between 20 ms and 1 s. The value is also
  /// pinned in a map that no program can write (see noted_grace()).
  Result<void> set_grace(std::uint64_t grace);
  /// Sets the grace of set_grace() again if another program has overwritten it. True if it was
  /// overwritten.
  Result<bool> keep_grace();
  [[nodiscard]] std::uint64_t grace() const;

  /// Limits until when the gates may be open, whatever heart-beats come: CLOCK_MONOTONIC, ns; 0
  /// (the initial value) is no limit. The gates close at most two ticks of the kernel's clock
  /// before it. An earlier limit holds at once, a later one from the next heart-beat on. It is
  /// pinned, and stays until a daemon sets another one.
  Result<void> set_until(std::uint64_t until);
  [[nodiscard]] std::uint64_t until() const;

  /// Starts the kernel timer, after a first beat(). If it runs already, it continues with the
  /// program of this process.
  Result<void> arm();

  /// Pins again what another program has unpinned. Without its pin the timer would end with the
  /// daemon, and the gates would stay open. True if anything was unpinned.
  Result<bool> keep_pinned();

  /// The directory of the pins, `root`/v<layout>.
  [[nodiscard]] const std::string& directory() const;
  /// The map of the control word. The descriptor stays with this object.
  [[nodiscard]] int map_fd() const;
  /// The ring of gate_event that all gates share. The descriptor stays with this object.
  [[nodiscard]] int events_fd() const;
  [[nodiscard]] SharedMaps shared() const { return {map_fd(), events_fd(), epoch()}; }

 private:
  struct State;
  explicit Control(std::unique_ptr<State> state);
  [[nodiscard]] gate_control& word() const;
  [[nodiscard]] std::uint32_t epoch() const;
  std::unique_ptr<State> state_;
};

/// The fields of the control word that follow from a grace period.
struct GraceWords {
  std::uint64_t grace_ns = 0;
  std::uint64_t grace_ticks = 0;
  std::uint64_t check_ns = 0;
  bool operator==(const GraceWords&) const = default;
};
/// The fields for a grace in ns; the error: the kernel's clock cannot be read.
Result<GraceWords> words_of_grace(std::uint64_t grace);
GraceWords words_of_grace(const gate_control& word);

/// The grace that a daemon has last set, in ns, from the map that no program can write; nullopt if
/// none was set.
std::optional<std::uint64_t> noted_grace(const std::string& directory);
/// How long gates with this control word stay open without a further heart-beat, in ns, rounded
/// down; at most 2^32 ticks. The error: no privilege, or no memory.
Result<std::uint64_t> time_left(int control_map);

}  // namespace mlcca::gates
