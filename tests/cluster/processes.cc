// SPDX-License-Identifier: BSD-2-Clause
#include "tests/cluster/processes.hpp"

#include <fcntl.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "base/handle.hpp"
#include "tests/support/require.hpp"

namespace mlcca::test {

WorkFolder::WorkFolder() {
  const std::filesystem::path memory = "/dev/shm";
  const bool there = ::access(memory.c_str(), W_OK) == 0;
  path_ =
      ((there ? memory : std::filesystem::temp_directory_path()) / "mlcca-cluster-XXXXXX").string();
  require(::mkdtemp(path_.data()) != nullptr, "mkdtemp");
}
WorkFolder::~WorkFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

Program::Program(const std::vector<std::string>& command, const std::string& log) {
  std::vector<char*> arguments;
  arguments.reserve(command.size() + 1);
  for (const auto& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_ = ::fork();
  require(pid_ >= 0, "fork");
  if (pid_ > 0) return;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int out = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  ::dup2(out, STDOUT_FILENO);
  ::dup2(out, STDERR_FILENO);
  // Those of libcurl stay open otherwise, and may be more than the program can have.
  ::close_range(STDERR_FILENO + 1, ~0U, 0);
  ::execvp(arguments[0], arguments.data());
  ::_exit(127);
}

void Program::signal(int number) const {
  if (pid_ > 0) ::kill(pid_, number);
}
void Program::end() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(std::exchange(pid_, 0), nullptr, 0);
}
int Program::wait() {
  int status = 0;
  ::waitpid(std::exchange(pid_, 0), &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

bool run_script(const std::string& script, const std::string& folder) {
  const std::string log = folder + "/script.log";
  if (Program({"sh", "-ec", "cd '" + folder + "'\n" + script}, log).wait() == 0) return true;
  std::fputs((script + '\n' + text_of_file(log)).c_str(), stderr);
  return false;
}

bool make_gateway_links(const WorkFolder& folder) {
  return run_script(R"(
for n in 1 2; do
	ip netns add gw$n
	ip link add lan0 netns gw$n type veth peer name far$n
	ip -n gw$n link set lan0 up
	ip link set far$n up
done
)",
                    folder.path());
}

int free_port() {
  const Fd socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  require(
      ::bind(socket.get(), generic, size) == 0 && ::getsockname(socket.get(), generic, &size) == 0,
      "a free port");
  return ntohs(address.sin_port);
}

void write_file(const std::string& path, const std::string& text) { std::ofstream(path) << text; }
std::string text_of_file(const std::string& path) {
  std::ifstream from(path);
  return {std::istreambuf_iterator<char>(from), {}};
}

std::string built(const std::string& program) {
  const auto tests = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  return (tests / ".." / program).lexically_normal();
}

}  // namespace mlcca::test
