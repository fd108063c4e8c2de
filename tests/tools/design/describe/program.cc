// SPDX-License-Identifier: BSD-2-Clause
#include "tests/tools/design/describe/program.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace mlcca::test {
namespace {

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  for (auto& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

std::string mlccactl() {
  return (std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path() / "mlccactl")
      .string();
}

Ran spawn(const std::string& program, std::vector<std::string> arguments, bool one_output) {
  const Folder folder;
  const auto out = folder.path("out");
  const auto error = folder.path("error");
  posix_spawn_file_actions_t files;
  ::posix_spawn_file_actions_init(&files);
  ::posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_addopen(&files, 1, out.c_str(), O_WRONLY | O_CREAT, 0600);
  if (one_output)
    ::posix_spawn_file_actions_adddup2(&files, 1, 2);
  else
    ::posix_spawn_file_actions_addopen(&files, 2, error.c_str(), O_WRONLY | O_CREAT, 0600);
  ::pid_t child = 0;
  const int failed =
      ::posix_spawnp(&child, program.c_str(), &files, nullptr, pointers(arguments).data(), environ);
  ::posix_spawn_file_actions_destroy(&files);
  EXPECT_EQ(failed, 0) << program;
  if (failed != 0) return {};
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, content_of(out),
          one_output ? "" : content_of(error)};
}

}  // namespace

Folder::Folder() {
  std::string name = std::filesystem::temp_directory_path() / "mlcca-XXXXXX";
  if (::mkdtemp(name.data()) == nullptr) std::abort();
  path_ = name;
}

Folder::~Folder() { std::filesystem::remove_all(path_); }

std::string Folder::write(const std::string& name, const std::string& text) const {
  std::ofstream(path(name), std::ios::binary) << text;
  return path(name);
}

std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

Ran run(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "mlccactl");
  return spawn(mlccactl(), std::move(arguments), false);
}

Ran run_program(std::vector<std::string> arguments) {
  const auto program = arguments.front();
  return spawn(program, std::move(arguments), true);
}

OnTerminal::OnTerminal(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "mlccactl");
  const auto program = mlccactl();
  auto words = pointers(arguments);
  int terminal = -1;
  child_ = ::forkpty(&terminal, nullptr, nullptr, nullptr);
  if (child_ == 0) {
    // As from a shell, also where the tests were started in the background (nohup, &).
    for (const int signal : {SIGHUP, SIGINT, SIGQUIT}) ::signal(signal, SIG_DFL);
    ::execv(program.c_str(), words.data());
    ::_exit(127);
  }
  terminal_.reset(terminal);
}

OnTerminal::~OnTerminal() {
  if (child_ > 0) finish();
}

bool OnTerminal::read_more() {
  std::array<char, 4096> piece{};
  const auto n = ::read(terminal_.get(), piece.data(), piece.size());
  if (n <= 0) return false;  // EIO: no process has the terminal open any more
  screen_.append(piece.data(), static_cast<std::size_t>(n));
  return true;
}

void OnTerminal::await(const std::string& text) {
  for (;;) {
    const auto found = screen_.find(text, seen_);
    if (found != std::string::npos) {
      seen_ = found + text.size();
      return;
    }
    if (!read_more()) {
      ADD_FAILURE() << "'" << text << "' never came:\n" << screen_;
      return;
    }
  }
}

void OnTerminal::type(const std::string& keys) {
  EXPECT_EQ(::write(terminal_.get(), keys.data(), keys.size()), static_cast<ssize_t>(keys.size()));
}

int OnTerminal::finish() {
  while (read_more()) {
  }
  int status = 0;
  EXPECT_EQ(::waitpid(child_, &status, 0), child_);
  child_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

}  // namespace mlcca::test
