// SPDX-License-Identifier: BSD-2-Clause
// Programs that a test starts, and the folder that they work in: both end with the test.
#pragma once
#include <sys/types.h>

#include <string>
#include <utility>
#include <vector>

namespace mlcca::test {

/// A new folder, in memory where there is room for that.
class WorkFolder {
 public:
  WorkFolder();
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  ~WorkFolder();
  [[nodiscard]] std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Its output goes to a file. It is killed with its owner.
class Program {
 public:
  Program() = default;
  Program(const std::vector<std::string>& command, const std::string& log);
  Program(Program&& other) noexcept : pid_(std::exchange(other.pid_, 0)) {}
  Program& operator=(Program&& other) noexcept {
    end();
    pid_ = std::exchange(other.pid_, 0);
    return *this;
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  ~Program() { end(); }

  [[nodiscard]] pid_t pid() const { return pid_; }
  void signal(int number) const;
  /// Killed, and waited for.
  void end();
  /// Waits until it ends by itself: its exit status; -1: by a signal.
  int wait();

 private:
  pid_t pid_ = 0;
};

/// Runs a script of sh in a folder; false: it failed, and what it said was printed.
bool run_script(const std::string& script, const std::string& folder);
/// Namespaces gw1 and gw2, each with a link lan0 whose other end, far1 or far2, is here.
bool make_gateway_links(const WorkFolder& folder);
/// A port of the loopback that nobody uses now.
int free_port();
void write_file(const std::string& path, const std::string& text);
[[nodiscard]] std::string text_of_file(const std::string& path);
/// Of this build: "mlcca-cluster".
[[nodiscard]] std::string built(const std::string& program);

}  // namespace mlcca::test
