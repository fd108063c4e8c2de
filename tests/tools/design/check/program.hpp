// SPDX-License-Identifier: BSD-2-Clause
// Runs the built mlccactl as a user would: to its end, or step by step with its output awaited.
#pragma once
#include <gtest/gtest.h>
#include <sys/types.h>

#include <string>
#include <string_view>
#include <vector>

#include "base/handle.hpp"

namespace mlcca::test {

struct RunOutcome {
  int status = -1;  ///< exit status, or -1: ended by a signal
  std::string out;
  std::string error;
  long max_rss_kib = 0;
};

/// How it is run, beside its arguments.
struct Surroundings {
  std::vector<std::string> environment = {"PATH=/usr/bin:/bin"};
  std::string folder;               ///< working directory; empty: that of the test
  bool without_privileges = false;  ///< root may read everything; this takes that away
  const char* out = nullptr;        ///< a file that replaces the captured standard output
};

/// `mlccactl ARGUMENTS…` of the build tree that this test is from.
RunOutcome run(const std::vector<std::string>& arguments, const Surroundings& how = {});

/// A program that is still running. Its output is awaited; a test that waits in vain fails after a
/// minute.
class Running {
 public:
  enum class Where : bool { pipe, terminal };

  /// With `terminal` standard output and error are one pseudo terminal.
  Running(const std::vector<std::string>& arguments, Where where);
  ~Running();
  Running(const Running&) = delete;
  Running(Running&&) = delete;
  Running& operator=(const Running&) = delete;
  Running& operator=(Running&&) = delete;

  /// Everything up to and with `text`, which is then no longer part of what is awaited.
  std::string await(std::string_view text);
  /// What comes until it closes its output.
  std::string await_end();
  void signal(int number) const;
  /// Its exit status, or -1.
  int wait();

 private:
  bool read_more();

  pid_t pid_ = 0;
  Fd out_;
  std::string pending_;
};

/// A folder of its own for each test.
class CheckTest : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }
  [[nodiscard]] const std::string& folder() const { return folder_; }
  /// Writes it and returns its path.
  std::string file(const std::string& name, std::string_view content) const;

 private:
  std::string folder_;
};

std::string content_of(const std::string& path);

/// A System of the name "test" with these parts, which begin in line 2.
std::string system_of(const std::string& parts);
/// A channel with publisher and subscriber on a network "air", with Omission required and provided.
std::string delivery(int required, int provided);

}  // namespace mlcca::test
