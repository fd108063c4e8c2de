// SPDX-License-Identifier: BSD-2-Clause
#include "tests/tools/design/check/program.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/capability.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace mlcca::test {
namespace {

constexpr int kPatience = 60'000;  // ms

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  for (auto& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

/// In the child: becomes the program.
[[noreturn]] void become(const std::string& program, std::vector<std::string> arguments,
                         std::vector<std::string> environment) {
  arguments.insert(arguments.begin(), "mlccactl");
  ::execve(program.c_str(), pointers(arguments).data(), pointers(environment).data());
  ::_exit(127);
}

std::string program() {
  return (std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path() / "mlccactl")
      .string();
}

int status_of(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : -1; }

}  // namespace

std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

RunOutcome run(const std::vector<std::string>& arguments, const Surroundings& how) {
  std::string files = ::testing::TempDir() + "mlcca-run-XXXXXX";
  EXPECT_NE(::mkdtemp(files.data()), nullptr);
  const auto binary = program();
  const std::string out = how.out != nullptr ? how.out : files + "/out";
  const auto error = files + "/error";
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(::open(out.c_str(), O_WRONLY | (how.out != nullptr ? 0 : O_CREAT), 0600), 1);
    ::dup2(::open(error.c_str(), O_WRONLY | O_CREAT, 0600), 2);
    if (!how.folder.empty() && ::chdir(how.folder.c_str()) != 0) ::_exit(126);
    // Root gets back at exec what the bounding set allows.
    if (how.without_privileges)
      for (const int may : {CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH}) ::prctl(PR_CAPBSET_DROP, may);
    become(binary, arguments, how.environment);
  }
  int status = 0;
  rusage usage{};
  EXPECT_EQ(::wait4(child, &status, 0, &usage), child);
  RunOutcome result{status_of(status), how.out != nullptr ? "" : content_of(out), content_of(error),
                    usage.ru_maxrss};
  std::filesystem::remove_all(files);
  return result;
}

Running::Running(const std::vector<std::string>& arguments, Where where) {
  const auto binary = program();
  std::array<int, 2> ends{};
  if (where == Where::terminal)
    EXPECT_EQ(::openpty(&ends[0], &ends[1], nullptr, nullptr, nullptr), 0);
  else
    EXPECT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
  out_.reset(ends[0]);
  const Fd theirs(ends[1]);
  ::fcntl(ends[0], F_SETFD, FD_CLOEXEC);
  ::fcntl(ends[1], F_SETFD, FD_CLOEXEC);
  pid_ = ::fork();
  if (pid_ != 0) return;
  ::dup2(ends[1], 1);
  ::dup2(ends[1], 2);
  become(binary, arguments, {"PATH=/usr/bin:/bin", "TERM=xterm"});
}

Running::~Running() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

bool Running::read_more() {
  pollfd ready{.fd = out_.get(), .events = POLLIN, .revents = 0};
  if (::poll(&ready, 1, kPatience) <= 0) {
    ADD_FAILURE() << "nothing more came after:\n" << pending_;
    return false;
  }
  std::array<char, 4096> piece{};
  const auto n = ::read(out_.get(), piece.data(), piece.size());
  if (n <= 0) return false;  // a terminal says EIO at its end
  pending_.append(piece.data(), static_cast<std::size_t>(n));
  return true;
}

std::string Running::await(std::string_view text) {
  for (;;) {
    if (const auto at = pending_.find(text); at != std::string::npos) {
      auto seen = pending_.substr(0, at + text.size());
      pending_.erase(0, seen.size());
      return seen;
    }
    if (read_more()) continue;
    ADD_FAILURE() << "'" << text << "' did not come, but:\n" << pending_;
    return {};
  }
}

std::string Running::await_end() {
  while (read_more()) {
  }
  return std::exchange(pending_, {});
}

void Running::signal(int number) const { ::kill(pid_, number); }

int Running::wait() {
  int status = 0;
  EXPECT_EQ(::waitpid(pid_, &status, 0), pid_);
  pid_ = 0;
  return status_of(status);
}

void CheckTest::SetUp() {
  std::string form = ::testing::TempDir() + "mlcca-check-XXXXXX";
  ASSERT_NE(::mkdtemp(form.data()), nullptr);
  folder_ = form;
}

void CheckTest::TearDown() { std::filesystem::remove_all(folder_); }

std::string CheckTest::file(const std::string& name, std::string_view content) const {
  std::filesystem::create_directories(std::filesystem::path(path(name)).parent_path());
  std::ofstream(path(name), std::ios::binary) << content;
  return path(name);
}

std::string system_of(const std::string& parts) {
  return "<System name=\"test\" xmlns:xi=\"http://www.w3.org/2001/XInclude\">\n" + parts +
         "</System>\n";
}

std::string delivery(int required, int provided) {
  return fmt::format(
      "<EventChannel name=\"speed\"><SubjectUID>0x1</SubjectUID><Attributes><Attribute>"
      "<Name>Omission</Name><Value>{}</Value></Attribute></Attributes></EventChannel>\n"
      "<Network name=\"air\"><Kind>mesh</Kind><Provision><Attribute><Name>Omission</Name>"
      "<Value>{}</Value></Attribute></Provision></Network>\n"
      "<Publisher channel=\"speed\" network=\"air\"/>\n"
      "<Subscriber channel=\"speed\" network=\"air\"/>\n",
      required, provided);
}

}  // namespace mlcca::test
