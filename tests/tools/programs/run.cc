// SPDX-License-Identifier: BSD-2-Clause
#include "tests/tools/programs/run.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "base/handle.hpp"
#include "tests/control/server.hpp"

namespace mlcca::test {
namespace {

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> result;
  for (auto& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

/// The end of a pipe that nobody reads.
Fd pipe_without_reader() {
  std::array<int, 2> ends{};
  EXPECT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
  ::close(ends[0]);
  return Fd(ends[1]);
}

}  // namespace

std::string build_folder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path().string();
}

End run(const Start& start) {
  const TempDir directory;
  std::ofstream(directory.path("in")) << start.input;
  const Fd unread = pipe_without_reader();
  posix_spawn_file_actions_t files;
  ::posix_spawn_file_actions_init(&files);
  ::posix_spawn_file_actions_addopen(&files, 0, directory.path("in").c_str(), O_RDONLY, 0);
  for (const auto& [fd, stream] : {std::pair(1, start.out), std::pair(2, start.error)}) {
    const auto file =
        stream == Stream::full ? "/dev/full" : directory.path(fd == 1 ? "out" : "error");
    if (stream == Stream::closed)
      ::posix_spawn_file_actions_addclose(&files, fd);
    else if (stream == Stream::gone)
      ::posix_spawn_file_actions_adddup2(&files, unread.get(), fd);
    else
      ::posix_spawn_file_actions_addopen(&files, fd, file.c_str(), O_WRONLY | O_CREAT, 0600);
  }
  std::vector<std::string> words{start.program};
  words.insert(words.end(), start.arguments.begin(), start.arguments.end());
  std::vector<std::string> environment = start.environment;
  const auto path = build_folder() + "/" + start.program;
  ::pid_t child = 0;
  const int failed = ::posix_spawn(&child, path.c_str(), &files, nullptr, pointers_to(words).data(),
                                   pointers_to(environment).data());
  ::posix_spawn_file_actions_destroy(&files);
  EXPECT_EQ(failed, 0) << path;
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  End end;
  end.status = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  if (start.out == Stream::file) end.out = text_of(directory.path("out"));
  if (start.error == Stream::file) end.error = text_of(directory.path("error"));
  return end;
}

}  // namespace mlcca::test
