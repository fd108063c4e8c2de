// SPDX-License-Identifier: BSD-2-Clause
// The real mlccad as a process of its own, and what is seen of it from outside: its control word,
// and what it reports to systemd.
#pragma once
#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "bpf/gate.h"
#include "daemon/gates/mapped.hpp"

namespace mlcca::test {

/// CLOCK_MONOTONIC, ns.
std::uint64_t clock_ns();

/// Whether a reader takes what a process writes. Without one, the pipe of its output is full, and
/// so is the queue of its reports to systemd.
enum class Readers : std::uint8_t { there, none };

/// Runs a program beside this one (…/build/mlccad), its output in `log`. Ends it when destroyed.
class Process {
 public:
  Process(std::vector<std::string> arguments, const std::string& log,
          Readers readers = Readers::there);
  ~Process();
  Process(const Process&) = delete;
  Process(Process&&) = delete;
  Process& operator=(const Process&) = delete;
  Process& operator=(Process&&) = delete;

  /// Waits, at most some minutes, until it reports READY=1, and calls `meanwhile` each millisecond.
  /// False: it has ended, or never came so far.
  bool ready(const std::function<void()>& meanwhile = [] {});
  void signal(int number) const;
  /// Waits some seconds for its end; false: it goes on, and is killed.
  bool ends();
  /// Waits for its end. The exit status, or 128 and more: it was killed.
  int end();
  [[nodiscard]] std::uint64_t began() const { return began_; }

 private:
  void fill(const std::string& notices);

  Fd notices_;
  Fd output_;  ///< the end that is never read
  pid_t pid_ = -1;
  int status_ = -1;
  std::uint64_t began_ = 0;
};

/// A directory for description, journal and log of one daemon, in a network namespace and a bpffs
/// of the test's own.
class Gateway {
 public:
  explicit Gateway(const std::string& description);
  ~Gateway();
  Gateway(const Gateway&) = delete;
  Gateway(Gateway&&) = delete;
  Gateway& operator=(const Gateway&) = delete;
  Gateway& operator=(Gateway&&) = delete;

  void describe(const std::string& description) const;
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }
  [[nodiscard]] std::vector<std::string> command(std::vector<std::string> more = {}) const;
  [[nodiscard]] std::string log() const;
  /// Waits, at most some minutes, until the log has these words.
  [[nodiscard]] bool comes_to_log(const std::string& words) const;
  /// The control word, once there is one.
  [[nodiscard]] gates::Mapped<gate_control> word() const;

 private:
  std::string folder_;
  std::string root_;
};

/// `ports` veth pairs lan0… with far ends far0…, all up.
void make_links(int ports);
/// A network, a port and a channel for each; `more` is put into System.
std::string described(int ports, const std::string& more = {});

}  // namespace mlcca::test
