// SPDX-License-Identifier: BSD-2-Clause
#include "tests/daemon/start/daemon.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>
#include <utility>

#include "base/unix_address.hpp"
#include "daemon/gates/pins.hpp"
#include "tests/daemon/gates/sandbox.hpp"
#include "tests/support/becomes.hpp"
#include "tests/support/require.hpp"

namespace mlcca::test {
namespace {

constexpr std::uint64_t kPatience = 300'000'000'000;  // ns

}  // namespace

std::uint64_t clock_ns() {
  return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch() /
                                    std::chrono::nanoseconds(1));
}

constexpr int kOutput = 900;  // of a process without readers, before it begins

// --- a process -----------------------------------------------------------------------------------

/// Until neither takes more.
void Process::fill(const std::string& notices) {
  const Fd sender(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const auto address = unix_address(notices);
  while (::sendto(sender.get(), "X=1", 3, 0, generic(*address), sizeof(*address)) > 0) {
  }
  std::array<int, 2> ends{-1, -1};
  require(::pipe2(ends.data(), O_CLOEXEC | O_NONBLOCK) == 0, "a pipe");
  output_ = Fd(ends[0]);
  const std::string much(65536, 'x');
  while (::write(ends[1], much.data(), much.size()) > 0) {
  }
  // From now on who writes waits.
  ::fcntl(ends[1], F_SETFL, 0);  // NOLINT(*-vararg)
  ::dup2(ends[1], kOutput);
  ::close(ends[1]);
}

Process::Process(std::vector<std::string> arguments, const std::string& log, Readers readers)
    : notices_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string path = log + ".notify";
  ::unlink(path.c_str());
  path.copy(static_cast<char*>(address.sun_path), sizeof(address.sun_path) - 1);
  require(
      ::bind(notices_.get(), reinterpret_cast<sockaddr*>(&address),  // NOLINT(*-reinterpret-cast)
             sizeof(address)) == 0,
      "bind the notify socket");
  const std::string program =
      std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path() / arguments.at(0);
  arguments.at(0) = program;
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  if (readers == Readers::none) fill(path);
  began_ = clock_ns();
  pid_ = ::fork();
  require(pid_ >= 0, "fork");
  if (pid_ != 0) {
    if (readers == Readers::none) ::close(kOutput);
    return;
  }
  const int out = readers == Readers::none ? kOutput
                                           : ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND,
                                                    0600);  // NOLINT(*-vararg)
  ::dup2(out, 1);
  ::dup2(out, 2);
  ::setenv("NOTIFY_SOCKET", path.c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
  ::execv(program.c_str(), pointers.data());
  ::_exit(127);
}

Process::~Process() {
  signal(SIGKILL);
  end();
}

bool Process::ready(const std::function<void()>& meanwhile) {
  std::array<char, 4096> text{};
  while (clock_ns() - began_ < kPatience) {
    pollfd wait{.fd = notices_.get(), .events = POLLIN, .revents = 0};
    ::poll(&wait, 1, 1);
    meanwhile();
    for (;;) {
      const ssize_t size = ::recv(notices_.get(), text.data(), text.size(), 0);
      if (size < 0) break;
      const std::string_view received(text.data(), static_cast<std::size_t>(size));
      if (received.find("READY=1") != std::string_view::npos) return true;
    }
    if (status_ < 0 && ::waitpid(pid_, &status_, WNOHANG) == pid_) return false;
  }
  return false;
}

void Process::signal(int number) const {
  if (status_ < 0) ::kill(pid_, number);
}

bool Process::ends() {
  if (becomes([&] { return status_ >= 0 || ::waitpid(pid_, &status_, WNOHANG) == pid_; }))
    return true;
  signal(SIGKILL);
  return false;
}

int Process::end() {
  if (status_ < 0) ::waitpid(pid_, &status_, 0);
  return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
}

// --- a gateway -----------------------------------------------------------------------------------

Gateway::Gateway(const std::string& description) : root_(new_bpf_root()) {
  std::filesystem::create_directories(root_);
  std::string form = std::filesystem::temp_directory_path() / "mlcca-start-XXXXXX";
  require(::mkdtemp(form.data()) != nullptr, "mkdtemp");
  folder_ = form;
  std::filesystem::create_directories(path("state"));
  describe(description);
}

Gateway::~Gateway() {
  std::filesystem::remove_all(folder_);
  std::filesystem::remove_all(root_);
}

void Gateway::describe(const std::string& description) const {
  std::ofstream(path("system.xml")) << description;
}

std::vector<std::string> Gateway::command(std::vector<std::string> more) const {
  std::vector<std::string> out = {
      "mlccad",   "--description",      path("system.xml"),  "--bpf-root", root_,
      "--socket", path("control.sock"), "--state-directory", path("state")};
  out.insert(out.end(), more.begin(), more.end());
  return out;
}

std::string Gateway::log() const {
  std::ifstream file(path("log"));
  return {std::istreambuf_iterator<char>(file), {}};
}

bool Gateway::comes_to_log(const std::string& words) const {
  const std::uint64_t end = clock_ns() + kPatience;
  while (log().find(words) == std::string::npos) {
    if (clock_ns() > end) return false;
    ::poll(nullptr, 0, 10);
  }
  return true;
}

gates::Mapped<gate_control> Gateway::word() const {
  const Fd map = gates::open_pin(fmt::format("{}/v{}/control", root_, GATE_LAYOUT_VERSION));
  return map ? gates::Mapped<gate_control>(map.get(), 1) : gates::Mapped<gate_control>();
}

// --- what is described ---------------------------------------------------------------------------

void make_links(int ports) {
  static_cast<void>(new_bpf_root());                  // in the namespace of the test
  std::FILE* const ip = ::popen("ip -batch -", "w");  // NOLINT(cert-env33-c)
  require(ip != nullptr, "ip");
  for (int i = 0; i < ports; ++i)
    fmt::print(ip, "link add lan{0} up type veth peer name far{0}\nlink set far{0} up\n", i);
  require(::pclose(ip) == 0, "ip link add");
}

std::string described(int ports, const std::string& more) {
  std::string out = "<System name=\"start\">\n";
  for (int i = 0; i < ports; ++i)
    out += fmt::format("<EventChannel name=\"c{}\"><SubjectUID>{:#x}</SubjectUID></EventChannel>\n",
                       i, i + 1);
  for (int i = 0; i < ports; ++i)
    out += fmt::format(
        "<Network name=\"n{}\"><Kind>udp-multicast</Kind><Profile>famouso</Profile></Network>\n",
        i);
  out += more;
  out += "<Gateway name=\"gate\">\n";
  for (int i = 0; i < ports; ++i)
    out += fmt::format("<Port network=\"n{0}\"><Interface name=\"lan{0}\"/></Port>\n", i);
  out += "</Gateway>\n";
  for (int i = 0; i < ports; ++i)
    out += fmt::format(
        "<Publisher channel=\"c{0}\" network=\"n{0}\"/><Subscriber channel=\"c{0}\" "
        "gateway=\"gate\"/>\n",
        i);
  return out + "</System>\n";
}

}  // namespace mlcca::test
