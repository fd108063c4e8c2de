// SPDX-License-Identifier: BSD-2-Clause
// --watch: what counts as a save, and what is printed after one. Nothing here waits for time to
// pass: each step awaits what the one before it causes.
#include "tools/design/check/watch.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/tools/design/check/program.hpp"

namespace mlcca {
namespace {

using test::Running;
using tools::design::FileWatch;
using tools::design::Woken;
using Json = nlohmann::json;

constexpr const char* kFit = "1 fit, 0 decided at run time, 0 do not fit\n";
constexpr const char* kUnfit = "0 fit, 0 decided at run time, 1 do not fit\n";
constexpr timespec kLater{.tv_sec = 1L << 40U, .tv_nsec = 0};

/// FileWatch in this process. It blocks the signals that end it: they are let through again.
class FileWatchTest : public test::CheckTest {
 protected:
  void SetUp() override {
    CheckTest::SetUp();
    ::sigprocmask(SIG_SETMASK, nullptr, &mask_);
  }
  void TearDown() override {
    ::sigprocmask(SIG_SETMASK, &mask_, nullptr);
    CheckTest::TearDown();
  }
  static FileWatch open() {
    auto watch = FileWatch::open();
    EXPECT_TRUE(watch) << watch.error().text;
    return std::move(*watch);
  }
  /// After what has been done to files: a change is seen, or the end that follows.
  static Woken woken_by(FileWatch& watch) {
    ::kill(::getpid(), SIGTERM);
    const auto woken = watch.wait();
    EXPECT_TRUE(woken);
    return *woken;
  }
  static void follow(FileWatch& watch, const std::vector<std::string>& files) {
    const auto missed = watch.follow(files, kLater);
    ASSERT_TRUE(missed) << missed.error().text;
    EXPECT_FALSE(*missed);
  }
  /// Waits for a change, of which there must be one.
  static void expect_change(FileWatch& watch) {
    const auto woken = watch.wait();
    ASSERT_TRUE(woken) << woken.error().text;
    EXPECT_EQ(*woken, Woken::changed);
  }

 private:
  sigset_t mask_{};
};

TEST_F(FileWatchTest, SeesASaveARenameARemovalAndANewFile) {
  auto watch = open();
  const auto name = file("a.xml", "1");
  follow(watch, {name});
  file("a.xml", "2");
  expect_change(watch);
  file("b.xml", "3");
  std::filesystem::rename(path("b.xml"), name);
  expect_change(watch);
  std::filesystem::remove(name);
  expect_change(watch);
  file("a.xml", "4");
  expect_change(watch);
}

TEST_F(FileWatchTest, TheManyEventsOfOneSaveAreOneChange) {
  auto watch = open();
  const auto name = file("a.xml", "1");
  follow(watch, {name});
  for (int i = 0; i < 10; ++i) {
    file("a.xml~", "backup");
    std::filesystem::rename(path("a.xml~"), name);
    file("a.xml", "again");
  }
  expect_change(watch);
  EXPECT_EQ(woken_by(watch), Woken::ended) << "all of them have been taken";
}

TEST_F(FileWatchTest, OtherFilesOfTheFolderDoNotCount) {
  auto watch = open();
  follow(watch, {file("a.xml", "1")});
  file("b.xml", "2");
  std::filesystem::rename(path("b.xml"), path("c.xml"));
  EXPECT_EQ(woken_by(watch), Woken::ended);
}

TEST_F(FileWatchTest, FollowsOtherFilesFromNowOn) {
  auto watch = open();
  follow(watch, {file("one/a.xml", "1")});
  follow(watch, {file("two/b.xml", "1")});
  file("two/b.xml", "2");
  expect_change(watch);
  file("one/a.xml", "2");
  EXPECT_EQ(woken_by(watch), Woken::ended);
}

TEST_F(FileWatchTest, SeesASaveBehindASymbolicLink) {
  auto watch = open();
  file("real/a.xml", "1");
  std::filesystem::create_symlink(path("real/a.xml"), path("link.xml"));
  follow(watch, {path("link.xml")});
  file("real/a.xml", "2");
  expect_change(watch);
}

TEST_F(FileWatchTest, WaitsForAFolderThatDoesNotExistYet) {
  auto watch = open();
  follow(watch, {path("later/a.xml")});
  std::filesystem::create_directory(path("later"));
  expect_change(watch);
  follow(watch, {path("later/a.xml")});
  file("later/a.xml", "1");
  expect_change(watch);
}

TEST_F(FileWatchTest, WaitsForAFolderBesideAFileThatExists) {
  auto watch = open();
  follow(watch, {path("later/a.xml"), file("z.xml", "1")});
  std::filesystem::create_directory(path("later"));
  expect_change(watch);
}

TEST_F(FileWatchTest, ReportsAChangeBeforeItPolled) {
  auto watch = open();
  const auto before = tools::design::file_time();
  const auto name = file("a.xml", "1");
  const auto missed = watch.follow({name}, before);
  ASSERT_TRUE(missed);
  EXPECT_TRUE(*missed);
  const auto known = watch.follow({name}, before);
  ASSERT_TRUE(known);
  EXPECT_FALSE(*known) << "it was watched meanwhile";
}

class WatchTest : public test::CheckTest {
 protected:
  std::string name_ = "s.xml";
  void save(int required, int provided) {
    file(name_, test::system_of(test::delivery(required, provided)));
  }
};

TEST_F(WatchTest, ChecksAgainAfterASaveARenameAndARepair) {
  save(2, 2);
  Running watching({"check", "--watch", path(name_)}, Running::Where::pipe);
  EXPECT_FALSE(watching.await(kFit).contains("---"));
  save(2, 3);
  EXPECT_TRUE(watching.await(kUnfit).contains("--- checked again\n"));
  file("new.xml", test::system_of(test::delivery(4, 3)));
  std::filesystem::rename(path("new.xml"), path(name_));
  watching.await(kFit);
  file(name_, "<System");
  EXPECT_TRUE(watching.await("cannot be read\n").contains("MLCCA002"));
  save(1, 2);
  watching.await(kUnfit);
  watching.signal(SIGINT);
  watching.await_end();
  EXPECT_EQ(watching.wait(), 1) << "that of the last check";
}

TEST_F(WatchTest, EndsWithTheStatusOfTheLastCheck) {
  save(2, 3);
  Running watching({"check", "--watch", path(name_)}, Running::Where::pipe);
  watching.await(kUnfit);
  save(2, 2);
  watching.await(kFit);
  watching.signal(SIGTERM);
  watching.await_end();
  EXPECT_EQ(watching.wait(), 0);
}

TEST_F(WatchTest, WatchesWhatIsIncludedEvenIfItIsMissingOrBroken) {
  const auto including = test::system_of("<xi:include href=\"parts/n.xml\"/>\n");
  const std::string network = "<Network name=\"air\"><Kind>mesh</Kind></Network>";
  file(name_, including);
  Running watching({"check", "--watch", path(name_)}, Running::Where::pipe);
  EXPECT_TRUE(watching.await("cannot be read\n").contains("MLCCA001"));
  file("parts/n.xml", network);
  watching.await("0 channels");
  file("parts/n.xml", "<Network");
  EXPECT_TRUE(watching.await("cannot be read\n").contains("n.xml:1"));
  file("parts/n.xml", network);
  watching.await("0 channels");
  watching.signal(SIGTERM);
  watching.await_end();
  EXPECT_EQ(watching.wait(), 0);
}

TEST_F(WatchTest, ClearsATerminalBeforeEachReport) {
  save(2, 2);
  Running watching({"check", "--watch", path(name_)}, Running::Where::terminal);
  // A terminal ends a line by both characters.
  const auto first = watching.await("0 do not fit\r\n");
  EXPECT_TRUE(first.starts_with("\x1b[H\x1b[2J")) << first;
  save(2, 3);
  const auto second = watching.await("1 do not fit\r\n");
  EXPECT_TRUE(second.contains("\x1b[H\x1b[2J")) << second;
  EXPECT_FALSE(second.contains("---")) << second;
  watching.signal(SIGTERM);
  watching.await_end();
  EXPECT_EQ(watching.wait(), 1);
}

TEST_F(WatchTest, PrintsAnObjectForEachCheck) {
  save(2, 2);
  Running watching({"check", "--watch", "--json", path(name_)}, Running::Where::pipe);
  EXPECT_EQ(Json::parse(watching.await("\n")).at("errors"), 0);
  save(2, 3);
  EXPECT_EQ(Json::parse(watching.await("\n")).at("errors"), 1);
}

TEST_F(WatchTest, ReplacesTheOutputAndShowsTheText) {
  save(2, 2);
  const auto page = path("report.html");
  Running watching({"check", "--watch", "--format", "html", "--output", page, path(name_)},
                   Running::Where::pipe);
  watching.await(kFit);
  save(2, 3);
  watching.await(kUnfit);
  save(3, 3);
  // The page of a check is written before the next one begins.
  watching.await(kFit);
  EXPECT_TRUE(test::content_of(page).contains("</html>"));
  watching.signal(SIGTERM);
  watching.await_end();
  EXPECT_EQ(watching.wait(), 0);
  EXPECT_TRUE(test::content_of(page).contains("No findings."));
}

TEST_F(WatchTest, EndsAtOnceWhenTheFirstReportCannotBeWritten) {
  save(2, 2);
  for (const auto& output : {path("missing/report.txt"), path(name_)}) {
    const std::vector<std::string> arguments = {"check", "--output", output, path(name_)};
    auto watching = arguments;
    watching.emplace_back("--watch");
    const auto once = test::run(arguments);
    const auto watched = test::run(watching);
    EXPECT_GE(once.status, 2) << once.error;
    EXPECT_EQ(watched.status, once.status);
    EXPECT_TRUE(watched.error.contains(output)) << watched.error;
  }
}

TEST_F(WatchTest, WantsAFileForAPage) {
  save(2, 2);
  for (const std::string format : {"html", "sarif"}) {
    const auto outcome = test::run({"check", "--watch", "--format", format, path(name_)});
    EXPECT_EQ(outcome.status, 2);
    EXPECT_TRUE(outcome.error.contains(format + " needs --output")) << outcome.error;
  }
}

}  // namespace
}  // namespace mlcca
