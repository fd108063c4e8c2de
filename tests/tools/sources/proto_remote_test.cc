// SPDX-License-Identifier: BSD-2-Clause
// A source that is read by a process of its own: what it may do, and what becomes of its facts when
// it ends, hangs or lies.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "base/handle.hpp"
#include "base/unix_address.hpp"
#include "daemon/net/sources/facts.hpp"
#include "daemon/net/sources/remote.hpp"
#include "tests/tools/sources/proto_loop.hpp"

namespace mlcca::net {
namespace {

std::string helper_program() {
  const auto tests = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  return (tests / "../mlcca-sources").lexically_normal();
}

/// Of this process, ns.
std::uint64_t processor_time() {
  timespec time{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<std::uint64_t>(time.tv_sec) * 1'000'000'000 +
         static_cast<std::uint64_t>(time.tv_nsec);
}

/// Those whom this process has started.
std::vector<pid_t> children() {
  std::vector<pid_t> out;
  for (const auto& process : std::filesystem::directory_iterator("/proc")) {
    const std::string name = process.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    std::ifstream stat(process.path() / "stat");
    std::string line;
    std::getline(stat, line);
    const auto after = line.rfind(") ");
    if (after == std::string::npos) continue;
    std::istringstream rest(line.substr(after + 2));
    char state = 0;
    pid_t parent = 0;
    if (rest >> state >> parent && parent == ::getpid() && state != 'Z')
      out.push_back(std::stoi(name));
  }
  return out;
}

/// The one there is, once those before it have ended; 0: none after a generous time.
pid_t only_child() {
  for (int i = 0; i < 30'000; ++i) {
    const auto all = children();
    if (all.size() == 1) return all[0];
    ::usleep(1000);
  }
  return 0;
}

class RemoteSource : public ::testing::Test {
 protected:
  RemoteSource() {
    std::ofstream(links_) << "a b 24Mbit/s both\n";
    helper_.socket = folder_ / "none";
    helper_.program = helper_program();
    helper_.pause = 1000;
  }
  /// In place of the helper.
  std::string script(const std::string& lines) {
    const std::string path = folder_ / "script";
    std::ofstream(path) << "#!/bin/sh\n" << lines << "\n";
    ::chmod(path.c_str(), 0755);
    return path;
  }
  /// The socket at which the helper is expected.
  Fd listen() {
    helper_.socket = folder_ / "sources";
    const auto address = unix_address(helper_.socket);
    EXPECT_TRUE(address);
    Fd listening(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
    EXPECT_EQ(::bind(listening.get(), generic(*address), sizeof *address), 0);
    EXPECT_EQ(::listen(listening.get(), 4), 0);
    return listening;
  }
  std::unique_ptr<test::Watched> watch(std::uint64_t work = 0) {
    core::mesh::Source source;
    source.kind = core::mesh::SourceKind::file;
    source.endpoint = links_;
    return std::make_unique<test::Watched>([&](sd_event* loop, LinkSource::Report report) {
      return open_remote(
          source, test::mesh_of({"a", "b"}), loop,
          [work, report = std::move(report)](core::mesh::Snapshot snapshot) {
            for (const auto end = processor_time() + work; processor_time() < end;) {
            }
            report(std::move(snapshot));
          },
          helper_);
    });
  }

  test::Folder folder_;
  std::string links_ = folder_ / "links";
  Helper helper_;
};

const auto kHasLinks = [](const auto& s) { return s.links.size() == 2 && s.problem.empty(); };
const auto kHasProblem = [](const auto& s) { return s.links.empty() && !s.problem.empty(); };

TEST_F(RemoteSource, FactsArriveAndFollowWhatIsRead) {
  const auto watched = watch();
  ASSERT_TRUE(watched->await(kHasLinks)) << watched->last();
  std::ofstream(links_) << "nonsense\n";
  const auto wrong = watched->await(kHasProblem);
  ASSERT_TRUE(wrong) << watched->last();
  EXPECT_EQ(wrong->problem, links_ + ":1: a link needs FROM, TO and RATE");
}

TEST_F(RemoteSource, TheProcessHasNoRights) {
  const auto watched = watch();
  ASSERT_TRUE(watched->await(kHasLinks)) << watched->last();
  std::ifstream status("/proc/" + std::to_string(only_child()) + "/status");
  const std::string text(std::istreambuf_iterator<char>(status), {});
  for (const char* line :
       {"CapPrm:\t0000000000000000", "CapEff:\t0000000000000000", "CapInh:\t0000000000000000",
        "CapAmb:\t0000000000000000", "NoNewPrivs:\t1",
#ifndef __SANITIZE_ADDRESS__
        "Seccomp:\t2",
#endif
        "Threads:\t1"})
    EXPECT_NE(text.find(std::string("\n") + line + "\n"), std::string::npos) << line << text;
}

TEST_F(RemoteSource, AProcessThatDiesIsAProblemAndReplaced) {
  const auto watched = watch();
  ASSERT_TRUE(watched->await(kHasLinks)) << watched->last();
  const pid_t child = only_child();
  ASSERT_NE(child, 0);
  ::kill(child, SIGKILL);
  const auto lost = watched->await(kHasProblem);
  ASSERT_TRUE(lost) << watched->last();
  EXPECT_NE(lost->problem.find("the process that reads it has ended"), std::string::npos);
  EXPECT_TRUE(watched->await(kHasLinks)) << watched->last();
}

TEST_F(RemoteSource, AProcessThatHangsIsReplaced) {
  helper_.timeout = 1'500'000'000;
  const std::string mark = folder_ / "mark";
  helper_.program = script("[ -e " + mark + " ] && exec " + helper_.program + "\ntouch " + mark +
                           "\nexec sleep 600");
  const auto watched = watch();
  const auto lost = watched->await(kHasProblem);
  ASSERT_TRUE(lost) << watched->last();
  EXPECT_EQ(lost->problem, "the process that reads it says nothing");
  EXPECT_TRUE(watched->await(kHasLinks)) << watched->last();
}

TEST_F(RemoteSource, AProcessThatTalksNonsenseIsNotBelieved) {
  helper_.program = script("printf x >&0; exec sleep 600");
  const auto watched = watch();
  const auto lost = watched->await(kHasProblem);
  ASSERT_TRUE(lost) << watched->last();
  EXPECT_NE(lost->problem.find("not to be believed"), std::string::npos) << lost->problem;
}

TEST_F(RemoteSource, AMessageThatIsTooLongIsNotBelieved) {
  helper_.program = script("dd if=/dev/zero bs=32769 count=1 2>/dev/null >&0; exec sleep 600");
  const auto watched = watch();
  const auto lost = watched->await(kHasProblem);
  ASSERT_TRUE(lost) << watched->last();
  EXPECT_NE(lost->problem.find("too long"), std::string::npos) << lost->problem;
}

TEST_F(RemoteSource, AProgramThatIsNotThereIsAProblem) {
  helper_.program = folder_ / "nothing";
  const auto watched = watch();
  const auto lost = watched->await(kHasProblem);
  ASSERT_TRUE(lost) << watched->last();
  EXPECT_NE(lost->problem.find("No such file"), std::string::npos) << lost->problem;
}

TEST_F(RemoteSource, ASocketAtWhichSystemdStartsOneIsPreferred) {
  const Fd listening = listen();
  // What systemd does, once.
  const pid_t starter = ::fork();
  if (starter == 0) {
    const int peer = ::accept(listening.get(), nullptr, nullptr);
    ::dup2(peer, STDIN_FILENO);
    ::execl(helper_.program.c_str(), helper_.program.c_str(), nullptr);
    ::_exit(1);
  }
  helper_.program = folder_ / "nothing";
  auto watched = watch();
  EXPECT_TRUE(watched->await(kHasLinks)) << watched->last();
  watched.reset();
  int status = -1;
  ::waitpid(starter, &status, 0);
  EXPECT_EQ(status, 0) << "it ends with the conversation";
}

// A report that takes 20 ms, and a reader with more without end: at least 200 ms lie between two.
TEST_F(RemoteSource, AReaderThatReportsWithoutPauseLeavesTheLoopTimeForOthers) {
  const Fd listening = listen();
  const pid_t liar = ::fork();
  if (liar == 0) {
    const int peer = ::accept(listening.get(), nullptr, nullptr);
    const auto answer = facts::answer({.links = {}, .next_hops = {}, .problem = "none"});
    while (peer >= 0)
      for (const auto& message : answer)
        if (::send(peer, message.data(), message.size(), MSG_NOSIGNAL) < 0) ::_exit(0);
    ::_exit(1);
  }
  auto watched = watch(20'000'000);
  constexpr int reports = 5;
  const auto worked = processor_time();
  const auto begun = std::chrono::steady_clock::now();
  for (int i = 0; i < reports; ++i)
    ASSERT_TRUE(watched->await([](const auto& s) { return s.problem == "none"; }));
  const std::chrono::nanoseconds passed = std::chrono::steady_clock::now() - begun;
  EXPECT_GT(static_cast<std::uint64_t>(passed.count()), 6 * (processor_time() - worked));
  watched.reset();
  int status = -1;
  ::waitpid(liar, &status, 0);
  EXPECT_EQ(status, 0);
}

TEST_F(RemoteSource, EndsWithItsSource) {
  auto watched = watch();
  ASSERT_TRUE(watched->await(kHasLinks)) << watched->last();
  ASSERT_NE(only_child(), 0);
  watched.reset();
  // It was killed: the kernel needs a moment to end it.
  for (int i = 0; i < 30'000 && !children().empty(); ++i) ::usleep(1000);
  EXPECT_TRUE(children().empty());
}

}  // namespace
}  // namespace mlcca::net
