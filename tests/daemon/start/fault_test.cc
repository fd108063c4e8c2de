// SPDX-License-Identifier: BSD-2-Clause
// A start that fails: with status 2, after which systemd does not start it again, only where what
// was read is refused; with status 1 where the machine failed, which may be over the next time.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "base/handle.hpp"
#include "tests/daemon/start/daemon.hpp"

namespace mlcca::test {
namespace {

constexpr int kAgain = 1;
constexpr int kNotAgain = 2;

class StartFaultTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { make_links(1); }

  int status_of_a_start(std::vector<std::string> more = {}) {
    Process daemon(gateway_.command(std::move(more)), gateway_.path("log"));
    EXPECT_FALSE(daemon.ready()) << gateway_.log();
    const auto word = gateway_.word();
    EXPECT_TRUE(word && word[0].open == 0) << "the gates are closed";
    return daemon.end();
  }

  /// Of a start where `call` (open, read, write) fails for files whose path ends so.
  int status_where(const char* call, const std::string& file, int error) {
    const auto library =
        std::filesystem::read_symlink("/proc/self/exe").parent_path() / "failing_file.so";
    ::setenv("FAILING_CALL", call, 1);                            // NOLINT(concurrency-mt-unsafe)
    ::setenv("FAILING_FILE", file.c_str(), 1);                    // NOLINT(concurrency-mt-unsafe)
    ::setenv("FAILING_ERRNO", std::to_string(error).c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
    ::setenv("LD_PRELOAD", library.c_str(), 1);                   // NOLINT(concurrency-mt-unsafe)
    const int status = status_of_a_start();
    ::unsetenv("LD_PRELOAD");  // NOLINT(concurrency-mt-unsafe)
    EXPECT_NE(gateway_.log().find(std::strerror(error)), std::string::npos)  // NOLINT(*-mt-unsafe)
        << gateway_.log();
    return status;
  }

  /// So that there is a journal.
  void let_one_run() {
    Process before(gateway_.command(), gateway_.path("log"));
    ASSERT_TRUE(before.ready()) << gateway_.log();
    before.signal(SIGTERM);
    EXPECT_EQ(before.end(), 0);
  }

  Gateway gateway_{described(1)};
};

TEST_F(StartFaultTest, AJournalThatCannotBeReadIsTriedAgain) {
  let_one_run();
  EXPECT_EQ(status_where("read", "/state/journal", EIO), kAgain);
  EXPECT_EQ(status_where("open", "/state/journal", ENFILE), kAgain);
  EXPECT_EQ(status_where("open", "/state/journal", EMFILE), kAgain);
  EXPECT_EQ(status_where("open", "/state/lock", EMFILE), kAgain);
  EXPECT_EQ(status_where("open", "/state", EIO), kAgain);
  let_one_run();
}

TEST_F(StartFaultTest, ADiskThatIsFullAtTheFirstStartIsTriedAgain) {
  EXPECT_EQ(status_where("open", "/state/journal.new", ENOSPC), kAgain);
  EXPECT_EQ(status_where("write", "/state/journal.new", ENOSPC), kAgain);
  let_one_run();
}

TEST_F(StartFaultTest, AJournalThatAnotherProcessHoldsIsTriedAgain) {
  {
    const Fd lock(::open(gateway_.path("state/lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC,
                         0600));  // NOLINT(*-vararg)
    ASSERT_EQ(::flock(lock.get(), LOCK_EX | LOCK_NB), 0);
    EXPECT_EQ(status_of_a_start(), kAgain);
    EXPECT_NE(gateway_.log().find("in use by another process"), std::string::npos);
  }
  let_one_run();
}

TEST_F(StartFaultTest, ADamagedJournalIsTriedAgain) {
  std::ofstream(gateway_.path("state/journal")) << "no journal";
  EXPECT_EQ(status_of_a_start(), kAgain) << "until a copy was put back";
}

TEST_F(StartFaultTest, ADescriptionThatCannotBeReadIsTriedAgain) {
  EXPECT_EQ(status_where("read", "/system.xml", EIO), kAgain);
  EXPECT_EQ(status_where("open", "/system.xml", EMFILE), kAgain);
  EXPECT_EQ(status_where("open", "/system.xml", ENFILE), kAgain);
  let_one_run();
}

TEST_F(StartFaultTest, ADescriptionThatIsNotThereIsTriedAgain) {
  std::filesystem::remove(gateway_.path("system.xml"));
  EXPECT_EQ(status_of_a_start(), kAgain) << "its file system may not be mounted yet";
}

TEST_F(StartFaultTest, APartThatCannotBeReadIsTriedAgain) {
  std::ofstream(gateway_.path("part.xml")) << "<Network";
  gateway_.describe(described(1,
                              "<xi:include xmlns:xi=\"http://www.w3.org/2001/XInclude\" "
                              "href=\"part.xml\"/>"));
  EXPECT_EQ(status_where("open", "/part.xml", EMFILE), kAgain);
  EXPECT_EQ(status_of_a_start(), kNotAgain) << "it was read, and is wrong";
}

TEST_F(StartFaultTest, AUserDatabaseThatCannotBeReadIsTriedAgain) {
  gateway_.describe(
      described(1, "<Publisher channel=\"c0\" gateway=\"gate\" user=\"mlcca-nobody\"/>\n"));
  EXPECT_EQ(status_where("getpwnam_r", "", EMFILE), kAgain);
  EXPECT_EQ(status_of_a_start(), kNotAgain) << "it was read, and has no such user";
}

TEST_F(StartFaultTest, WhatWasReadAndIsRefusedIsNotTriedAgain) {
  EXPECT_EQ(status_of_a_start({"--gateway", "another"}), kNotAgain);
  gateway_.describe("<System");
  EXPECT_EQ(status_of_a_start(), kNotAgain);
}

}  // namespace
}  // namespace mlcca::test
