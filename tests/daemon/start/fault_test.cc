// SPDX-License-Identifier: BSD-2-Clause
// A start that fails: with status 2, after which systemd does not start it again, only where what
// was read is refused; with status 1 where the machine failed, which may be over the next time.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/mount.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "base/handle.hpp"
#include "tests/daemon/start/daemon.hpp"

namespace mlcca::test {
namespace {

constexpr int kAgain = 1;
constexpr int kNotAgain = 2;

/// Of the processes that are started while it lives.
class Environment {
 public:
  explicit Environment(std::vector<std::pair<std::string, std::string>> variables)
      : variables_(std::move(variables)) {
    for (const auto& [name, value] : variables_)
      ::setenv(name.c_str(), value.c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
  }
  ~Environment() {
    for (const auto& [name, value] : variables_)
      ::unsetenv(name.c_str());  // NOLINT(concurrency-mt-unsafe)
  }
  Environment(const Environment&) = delete;
  Environment(Environment&&) = delete;
  Environment& operator=(const Environment&) = delete;
  Environment& operator=(Environment&&) = delete;

 private:
  std::vector<std::pair<std::string, std::string>> variables_;
};

std::string beside_this(const std::string& name) {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / name;
}

class StartFaultTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { make_links(1); }
  void TearDown() override {
    if (!has_groups_) return;
    ASSERT_EQ(::umount2("/etc/group", MNT_DETACH), 0);
  }

  /// In the namespace of the test.
  void have_groups(const std::string& line) {
    std::ofstream(gateway_.path("group")) << "root:x:0:\n" << line << '\n';
    ASSERT_EQ(::mount(gateway_.path("group").c_str(), "/etc/group", nullptr, MS_BIND, nullptr), 0);
    has_groups_ = true;
  }

  int status_of_a_start(std::vector<std::string> more = {}) {
    Process daemon(gateway_.command(std::move(more)), gateway_.path("log"));
    EXPECT_FALSE(daemon.ready()) << gateway_.log();
    const auto word = gateway_.word();
    EXPECT_TRUE(word && word[0].open == 0) << "the gates are closed";
    return daemon.end();
  }

  /// Of a start where `call` (open, read, write) fails for files whose path ends so.
  int status_where(const char* call, const std::string& file, int error) {
    const Environment failing({{"FAILING_CALL", call},
                               {"FAILING_FILE", file},
                               {"FAILING_ERRNO", std::to_string(error)},
                               {"LD_PRELOAD", beside_this("failing_file.so")}});
    const int status = status_of_a_start();
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
  bool has_groups_ = false;
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
  EXPECT_EQ(status_of_a_start(), kAgain) << "the directory that has the user may not be up yet";
  gateway_.describe(
      described(1, "<Publisher channel=\"c0\" gateway=\"gate\" user=\"4294967295\"/>\n"));
  EXPECT_EQ(status_of_a_start(), kNotAgain) << "no user has this number";
}

TEST_F(StartFaultTest, AGroupWithManyMembersIsFound) {
  std::string line = "mlcca:x:995:";
  for (int i = 0; i < 20'000; ++i) line += "member" + std::to_string(i) + ",";
  have_groups(line + "last");
  let_one_run();
  EXPECT_EQ(gateway_.log().find("only root may change"), std::string::npos) << gateway_.log();
}

TEST_F(StartFaultTest, AGroupThatCannotBeLookedUpIsNotSaidToBeMissing) {
  have_groups("mlcca:x:995:member");
  const Environment failing({{"FAILING_CALL", "getgrnam_r"},
                             {"FAILING_FILE", ""},
                             {"FAILING_ERRNO", std::to_string(EMFILE)},
                             {"LD_PRELOAD", beside_this("failing_file.so")}});
  let_one_run();
  EXPECT_NE(gateway_.log().find("group mlcca cannot be looked up: Too many open files"),
            std::string::npos)
      << gateway_.log();
}

/// libbpf goes on without them, and the verifier does not end then.
TEST_F(StartFaultTest, AStartEndsOrSucceedsWhicheverTypesTheKernelDoesNotTakeOnce) {
  const std::string said = "types failed";
  for (int n = 1;; ++n) {
    std::filesystem::remove(gateway_.path("log"));
    const Environment failing(
        {{"FAILING_TYPES", std::to_string(n)}, {"LD_PRELOAD", beside_this("failing_types.so")}});
    Process daemon(gateway_.command(), gateway_.path("log"));
    const bool ready = daemon.ready();
    if (ready) daemon.signal(SIGTERM);
    EXPECT_EQ(daemon.end(), ready ? 0 : kAgain) << n << '\n' << gateway_.log();
    if (gateway_.log().find(said) == std::string::npos) {
      EXPECT_TRUE(ready) << gateway_.log();
      EXPECT_GT(n, 10) << "libbpf's probes and our programs";
      return;
    }
  }
}

TEST_F(StartFaultTest, WhatWasReadAndIsRefusedIsNotTriedAgain) {
  EXPECT_EQ(status_of_a_start({"--gateway", "another"}), kNotAgain);
  gateway_.describe("<System");
  EXPECT_EQ(status_of_a_start(), kNotAgain);
}

}  // namespace
}  // namespace mlcca::test
