// SPDX-License-Identifier: BSD-2-Clause
#include "tests/tools/run.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/control/server.hpp"

namespace mlcca::test {
namespace {

std::string content_of(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  for (auto& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

}  // namespace

Outcome run_mlccactl(std::vector<std::string> arguments, std::vector<std::string> environment,
                     const char* out, int input) {
  const TempDir directory;
  const std::string out_path = out == nullptr ? directory.path("out") : out;
  const std::string error_path = directory.path("error");
  const auto program =
      (std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path() / "mlccactl")
          .string();
  arguments.insert(arguments.begin(), "mlccactl");

  posix_spawn_file_actions_t files;
  ::posix_spawn_file_actions_init(&files);
  const int flags = O_WRONLY | (out == nullptr ? O_CREAT : 0);
  if (input < 0)
    ::posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
  else
    ::posix_spawn_file_actions_adddup2(&files, input, 0);
  ::posix_spawn_file_actions_addopen(&files, 1, out_path.c_str(), flags, 0600);
  ::posix_spawn_file_actions_addopen(&files, 2, error_path.c_str(), O_WRONLY | O_CREAT, 0600);
  ::pid_t child = 0;
  const int failed = ::posix_spawn(&child, program.c_str(), &files, nullptr,
                                   pointers(arguments).data(), pointers(environment).data());
  ::posix_spawn_file_actions_destroy(&files);
  EXPECT_EQ(failed, 0) << program;
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, out == nullptr ? content_of(out_path) : "",
          content_of(error_path)};
}

}  // namespace mlcca::test
