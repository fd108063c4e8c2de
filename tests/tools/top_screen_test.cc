// SPDX-License-Identifier: BSD-2-Clause
// mlccactl top as a user has it: the built program on a pseudo terminal, against a fake daemon.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <memory>
#include <string_view>

#include "base/handle.hpp"
#include "tests/control/messages.hpp"
#include "tests/control/server.hpp"
#include "tests/tools/run.hpp"

namespace mlcca {
namespace {

using test::Server;

constexpr const char* kOtherScreen = "\x1b[?1049h";
constexpr const char* kShellScreen = "\x1b[?1049l";
constexpr const char* kCursor = "\x1b[?25h";

/// A daemon whose only delivery passes 100 frames from poll to poll.
Server::Handler gateway() {
  return [passed = std::make_shared<std::uint64_t>(0)](const control::Request& request) {
    control::Reply reply{0, control::Done{"?"}};
    if (std::holds_alternative<control::StatusRequest>(request.body)) {
      auto status = test::full_status();
      status.problem.clear();
      reply.body = status;
    } else if (std::holds_alternative<control::NetworksRequest>(request.body)) {
      reply.body = test::full_networks();
    } else if (std::holds_alternative<control::ReservationsRequest>(request.body)) {
      reply.body = test::full_reservations();
    } else {
      auto channel = test::granted_channel();
      channel.passed = *passed += 100;
      reply.body = control::Channels{{channel, test::refused_channel()}};
    }
    return Server::Answer{{reply}};
  };
}

/// What a shell does for its foreground job: takes the terminal back when the job stops, says how
/// it finds it, and gives it on at a line of input. Ends as the job does, 128 and the signal.
[[noreturn]] void be_shell(const char* program, char* const* words, char* const* environment) {
  ::signal(SIGTTOU, SIG_IGN);  // NOLINT(cert-err33-c)
  const ::pid_t job = ::fork();
  if (job == 0) {
    ::setpgid(0, 0);
    ::tcsetpgrp(STDIN_FILENO, ::getpid());
    ::signal(SIGTTOU, SIG_DFL);  // NOLINT(cert-err33-c)
    const rlimit no_core{};
    ::setrlimit(RLIMIT_CORE, &no_core);
    ::execve(program, words, environment);
    ::_exit(127);
  }
  ::setpgid(job, job);
  for (;;) {
    ::tcsetpgrp(STDIN_FILENO, job);
    ::killpg(job, SIGCONT);
    int status = 0;
    if (::waitpid(job, &status, WUNTRACED) != job) ::_exit(126);
    ::tcsetpgrp(STDIN_FILENO, ::getpgrp());
    if (WIFEXITED(status)) ::_exit(WEXITSTATUS(status));
    if (WIFSIGNALED(status)) ::_exit(128 + WTERMSIG(status));
    termios now{};
    ::tcgetattr(STDIN_FILENO, &now);
    const bool in_order = (now.c_lflag & (ICANON | ECHO)) == (ICANON | ECHO);
    const std::string_view said = in_order ? "STOPPED in order" : "STOPPED raw";
    std::array<char, 16> line{};
    if (::write(STDOUT_FILENO, said.data(), said.size()) < 0 ||
        ::read(STDIN_FILENO, line.data(), line.size()) <= 0)
      ::_exit(125);
  }
}

/// The program on a terminal of its own.
class OnTerminal {
 public:
  OnTerminal(const std::string& socket, std::vector<std::string> arguments,
             const char* terminal = "xterm", winsize size = {24, 80, 0, 0}) {
    int master = -1;
    const std::string program =
        (std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path() / "mlccactl")
            .string();
    arguments.insert(arguments.begin(), {program, "--socket", socket, "top"});
    std::vector<char*> words;
    for (auto& word : arguments) words.push_back(word.data());
    words.push_back(nullptr);
    const std::string term = std::string("TERM=") + terminal;
    child_ = ::forkpty(&master, nullptr, nullptr, &size);
    if (child_ == 0) {
      std::string term_of_child = term;
      std::array<char*, 2> environment = {term_of_child.data(), nullptr};
      be_shell(program.c_str(), words.data(), environment.data());
    }
    master_ = Fd(master);
  }
  OnTerminal(const OnTerminal&) = delete;
  OnTerminal& operator=(const OnTerminal&) = delete;
  ~OnTerminal() {
    if (child_ <= 0) return;
    ::kill(child_, SIGKILL);
    ::waitpid(child_, nullptr, 0);
  }

  void type(const std::string& keys) const {
    EXPECT_EQ(::write(master_.get(), keys.data(), keys.size()), static_cast<ssize_t>(keys.size()));
  }
  void signal(int number) const { EXPECT_EQ(::killpg(::tcgetpgrp(master_.get()), number), 0); }
  void resize(winsize size) const { EXPECT_EQ(::ioctl(master_.get(), TIOCSWINSZ, &size), 0); }
  [[nodiscard]] tcflag_t local_flags() const {
    termios now{};
    EXPECT_EQ(::tcgetattr(master_.get(), &now), 0);
    return now.c_lflag;
  }

  /// Until `text` is written, from what was awaited last on; false if it never is.
  bool shows(const std::string& text) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds{20};
    for (;;) {
      if (const auto at = output_.find(text, seen_); at != std::string::npos) {
        seen_ = at + text.size();
        return true;
      }
      if (std::chrono::steady_clock::now() > end || !read()) return false;
    }
  }
  /// Everything that was written until the end, and how it ended.
  int end() {
    while (read()) {
    }
    int status = 0;
    EXPECT_EQ(::waitpid(child_, &status, 0), child_);
    child_ = 0;
    return status;
  }
  [[nodiscard]] const std::string& output() const { return output_; }

 private:
  bool read() {
    pollfd one{master_.get(), POLLIN, 0};
    if (::poll(&one, 1, 20'000) <= 0) return false;
    std::array<char, 4096> buffer{};
    const auto n = ::read(master_.get(), buffer.data(), buffer.size());
    if (n <= 0) return false;
    output_.append(buffer.data(), static_cast<std::size_t>(n));
    return true;
  }

  Fd master_;
  ::pid_t child_ = -1;
  std::string output_;
  std::size_t seen_ = 0;
};

TEST(TopScreenTest, FollowsTheGatewayAndLeavesTheTerminalAsItWas) {
  Server server(gateway());
  OnTerminal top(server.path(), {"-d", "0.1"});
  ASSERT_TRUE(top.shows(kOtherScreen));
  EXPECT_TRUE(top.shows("RATE/s"));
  EXPECT_TRUE(top.shows("emergency-switch"));
  EXPECT_EQ(top.local_flags() & (ICANON | ECHO), 0U);
  EXPECT_TRUE(top.shows("by subject, sorted by rate"));
  top.type("s");
  EXPECT_TRUE(top.shows("sorted by jitter"));
  top.type("n");
  EXPECT_TRUE(top.shows("by network"));
  top.type("n/refus\r");
  EXPECT_TRUE(top.shows("1 row, filter 'refus'"));
  top.type("h");
  EXPECT_TRUE(top.shows("any key leaves this help"));
  top.type("x ");
  EXPECT_TRUE(top.shows("PAUSED"));
  top.type("q");
  const int status = top.end();
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  const auto back = top.output().rfind(kShellScreen);
  ASSERT_NE(back, std::string::npos);
  EXPECT_EQ(top.output().find(kOtherScreen, back), std::string::npos);
  EXPECT_NE(top.output().find(kCursor), std::string::npos);
}

TEST(TopScreenTest, EverySignalThatEndsItGivesTheTerminalBack) {
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) {
    Server server(gateway());
    OnTerminal top(server.path(), {});
    ASSERT_TRUE(top.shows("RATE/s"));
    if (number == SIGINT)
      top.type("\x03");
    else
      top.signal(number);
    const int status = top.end();
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 128 + number)
        << number << ' ' << status;
    EXPECT_NE(top.output().find(kShellScreen), std::string::npos) << number;
  }
}

TEST(TopScreenTest, StopsLikeAnyProgramAndComesBack) {
  Server server(gateway());
  OnTerminal top(server.path(), {"-d", "0.1"});
  ASSERT_TRUE(top.shows("RATE/s"));
  top.type("\x1a");
  ASSERT_TRUE(top.shows(kShellScreen));
  ASSERT_TRUE(top.shows("STOPPED in order"));
  top.type("fg\n");
  ASSERT_TRUE(top.shows(kOtherScreen));
  EXPECT_TRUE(top.shows("RATE/s"));
  top.type("q");
  EXPECT_TRUE(WIFEXITED(top.end()));
}

TEST(TopScreenTest, AnotherSizeIsAnotherLayout) {
  Server server(gateway());
  OnTerminal top(server.path(), {"-d", "3600"});
  ASSERT_TRUE(top.shows("second-can > r~"));
  top.resize({30, 132, 0, 0});
  EXPECT_TRUE(top.shows("second-can > robot-can"));
  top.type("q");
  EXPECT_TRUE(WIFEXITED(top.end()));
}

TEST(TopScreenTest, ADaemonThatGoesAwayIsShownAndComesBack) {
  std::atomic<bool> gone = false;
  Server server([&gone, answer = gateway()](const control::Request& request) {
    auto reply = answer(request);
    if (gone) return Server::Answer{{}, true};
    return reply;
  });
  OnTerminal top(server.path(), {"-d", "0.1"});
  ASSERT_TRUE(top.shows("by subject"));
  gone = true;
  EXPECT_TRUE(top.shows("mlccad"));
  EXPECT_TRUE(top.shows("emergency-switch"));
  gone = false;
  EXPECT_TRUE(top.shows("can1 is missing"));
  top.type("q");
  EXPECT_TRUE(WIFEXITED(top.end()));
}

TEST(TopScreenTest, ADumbTerminalGetsBatchesWithoutColour) {
  Server server(gateway());
  OnTerminal top(server.path(), {"-d", "0.1", "-n", "2"}, "dumb");
  const int status = top.end();
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_EQ(top.output().find('\x1b'), std::string::npos) << top.output();
  EXPECT_NE(top.output().find("RATE/s"), std::string::npos);
}

TEST(TopBatchTest, PrintsAsManyAsAskedForWithRates) {
  Server server(gateway());
  const auto outcome = test::run_mlccactl(
      {"--socket", server.path(), "top", "-b", "-d", "0.1", "-n", "3", "--sort", "name"});
  EXPECT_EQ(outcome.status, 0) << outcome.error;
  std::size_t tables = 0;
  for (auto at = outcome.out.find("RATE/s"); at != std::string::npos;
       at = outcome.out.find("RATE/s", at + 1))
    ++tables;
  EXPECT_EQ(tables, 3U);
  EXPECT_EQ(outcome.out.find('\x1b'), std::string::npos);
  EXPECT_NE(outcome.out.find("refused      0"), std::string::npos) << outcome.out;
}

TEST(TopBatchTest, SaysWhatIsWrongAndWhatWouldBeRight) {
  Server server(gateway());
  const auto run = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"--socket", server.path(), "top"});
    return test::run_mlccactl(arguments);
  };
  EXPECT_EQ(run({"--sort", "speed"}).status, 2);
  EXPECT_NE(run({"--sort", "speed"}).error.find("reserved, used"), std::string::npos);
  for (const auto* delay : {"0.09", "3601", "nan", "1x"}) {
    EXPECT_EQ(run({"-b", "-n", "1", "-d", delay}).status, 2) << delay;
    EXPECT_NE(run({"-b", "-n", "1", "-d", delay}).error.find("0.1 to 3600"), std::string::npos);
  }
  EXPECT_EQ(run({"-b", "-n", "0"}).status, 2);
  EXPECT_EQ(run({"--by", "colour"}).status, 2);
  EXPECT_EQ(test::run_mlccactl({"--socket", "/nowhere/at/all", "top", "-b"}).status, 3);
}

}  // namespace
}  // namespace mlcca
