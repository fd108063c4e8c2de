// SPDX-License-Identifier: BSD-2-Clause
// The built program, run as a user would: with captured output, or on a pseudo-terminal.
#pragma once
#include <sys/types.h>

#include <string>
#include <vector>

#include "base/handle.hpp"

namespace mlcca::test {

/// A fresh folder, gone with everything in it at the end.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  [[nodiscard]] std::string path(const std::string& name) const { return path_ + "/" + name; }
  /// Writes a file and returns its path.
  std::string write(const std::string& name, const std::string& text) const;

 private:
  std::string path_;
};

std::string content_of(const std::string& path);

struct Ran {
  int status = -1;  ///< exit status, or -1: ended by a signal
  std::string out;
  std::string error;
};

/// mlccactl of the build tree that this test is from; its standard input is empty.
Ran run(std::vector<std::string> arguments);

/// Any program, looked up in PATH. Both outputs are in `out`.
Ran run_program(std::vector<std::string> arguments);

/// mlccactl on a terminal of its own.
class OnTerminal {
 public:
  explicit OnTerminal(std::vector<std::string> arguments);
  ~OnTerminal();
  OnTerminal(const OnTerminal&) = delete;
  OnTerminal& operator=(const OnTerminal&) = delete;

  /// Reads until `text` is on the screen, behind what was awaited before; fails the test if the
  /// program ends without it.
  void await(const std::string& text);
  void type(const std::string& keys);
  /// Exit status, or minus the signal that ended it.
  int finish();
  [[nodiscard]] const std::string& screen() const { return screen_; }

 private:
  bool read_more();

  ::pid_t child_ = -1;
  Fd terminal_;
  std::string screen_;
  std::size_t seen_ = 0;
};

}  // namespace mlcca::test
