// SPDX-License-Identifier: BSD-2-Clause
#include "tests/bench/gateways/place.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <thread>
#include <utility>
#include <variant>

#include "base/handle.hpp"
#include "tests/bench/measure.hpp"

namespace mlcca::bench {
namespace {

using test::built;
using test::text_of_file;

constexpr std::chrono::seconds kPatience{60};

}  // namespace

void give_up(const std::string& why) { throw std::runtime_error(why); }

void wait_for(const std::string& what, const std::function<bool()>& holds) {
  const auto start = Steady::now();
  while (!holds()) {
    if (Steady::now() - start > kPatience) give_up(what);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

void enter_place() {
  // Each simulated gateway has a connection, and the store inherits the limit.
  rlimit files{};
  ::getrlimit(RLIMIT_NOFILE, &files);
  files.rlim_cur = files.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &files);
  require(::unshare(CLONE_NEWNET | CLONE_NEWNS) == 0, "namespaces: root is needed");
  require(::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0, "private mounts");
  for (const char* folder : {"/run", "/dev/shm"})
    require(::mount("tmpfs", folder, "tmpfs", 0, nullptr) == 0, "a folder of its own");
  const bool made = test::run_script(fmt::format(R"(
ip link set lo up
mkdir -p /run/netns
cp /etc/passwd /run/passwd
sed -i '/^mlcca-relay:/d' /run/passwd
echo 'mlcca-relay:x:{0}:{0}::/:/usr/sbin/nologin' >>/run/passwd
mount --bind /run/passwd /etc/passwd
)",
                                                 kRelayUser),
                                     "/run");
  require(made, "a place");
}

void inside(const std::string& name, const std::function<void()>& work) {
  std::thread([&] {
    const Fd space(::open(("/run/netns/" + name).c_str(), O_RDONLY | O_CLOEXEC));
    if (::setns(space.get(), CLONE_NEWNET) != 0) std::abort();
    work();
  }).join();
}

std::uint64_t loopback_octets() {
  std::istringstream lines(text_of_file("/proc/thread-self/net/dev"));
  for (std::string line; std::getline(lines, line);) {
    const auto colon = line.find("lo:");
    if (colon != std::string::npos) return std::strtoull(line.c_str() + colon + 3, nullptr, 10);
  }
  return 0;
}

double processor_seconds(pid_t pid) {
  const std::string text = text_of_file(fmt::format("/proc/{}/stat", pid));
  // Behind the name, which may have anything in it: state is the first, utime the twelfth.
  std::istringstream words(text.substr(text.rfind(')') + 1));
  std::string word;
  constexpr int before = 11;
  for (int i = 0; i < before; ++i) words >> word;
  double user = 0;
  double system = 0;
  words >> user >> system;
  return (user + system) / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

double resident_mib(pid_t pid) {
  const std::string text = text_of_file(fmt::format("/proc/{}/status", pid));
  const auto at = text.find("VmRSS:");
  constexpr double kib = 1024;
  return at == std::string::npos ? 0 : std::strtod(text.c_str() + at + 6, nullptr) / kib;
}

std::string ms_attribute(const std::string& name, double value) {
  return fmt::format(
      "<Attribute><Name>{}</Name><Dimension><SIUnit><Seconds>1</Seconds></SIUnit><Magnitude>-3"
      "</Magnitude></Dimension><Value>{}</Value></Attribute>",
      name, value);
}
std::string octets_attribute(const std::string& name, std::uint64_t value) {
  return fmt::format(
      "<Attribute><Name>{}</Name><Dimension><SIUnit><Bytes>1</Bytes></SIUnit></Dimension>"
      "<Value>{}</Value></Attribute>",
      name, value);
}
std::string ethernet(const std::string& name) {
  return fmt::format(
             "<Network name='{}'><Kind>udp-multicast</Kind><Profile>famouso</Profile>"
             "<Provision>",
             name) +
         ms_attribute("Latency", 1) + ms_attribute("Period", 1) +
         "<Attribute><Name>Omission</Name><Value>0</Value></Attribute>" +
         octets_attribute("MaxPayload", 1400) + "</Provision></Network>\n";
}

RealGateway::RealGateway(const test::WorkFolder& folder, const test::Store& store, Options options)
    : folder_(folder), options_(std::move(options)) {
  test::write_file(file(".conf"), "endpoint = " + store.endpoint(0) +
                                      "\nca = " + folder / "ca.pem" +
                                      "\ncertificate = " + folder / options_.certificate +
                                      ".pem\nkey = " + folder / options_.certificate + ".key\n");
  // mlcca-relay reaches the control socket as another user.
  using std::filesystem::perms;
  std::filesystem::permissions(folder.path(),
                               perms::owner_all | perms::group_exec | perms::others_exec);
  std::filesystem::create_directories(options_.state);
  std::filesystem::create_directories(file(".bpf"));
  require(::mount("bpf", file(".bpf").c_str(), "bpf", 0, nullptr) == 0, "a bpffs");
}

RealGateway::~RealGateway() {
  kill();
  ::umount2(file(".bpf").c_str(), MNT_DETACH);
}

void RealGateway::start() {
  if (bridge_.pid() <= 0) {
    std::filesystem::remove(file(".cluster"));
    bridge_ = test::Program(
        {built("mlcca-cluster"), "--settings", file(".conf"), "--socket", file(".cluster")},
        file(".bridge.log"));
  }
  daemon_ = test::Program({"ip",
                           "netns",
                           "exec",
                           options_.name,
                           built("mlccad"),
                           "--description",
                           options_.description,
                           "--gateway",
                           options_.name,
                           "--socket",
                           file(".sock"),
                           "--bpf-root",
                           file(".bpf"),
                           "--state-directory",
                           options_.state,
                           "--cluster-settings",
                           file(".conf"),
                           "--cluster-socket",
                           file(".cluster"),
                           "--lease",
                           options_.lease},
                          file(".log"));
}

void RealGateway::start_relay() {
  wait_for(options_.name + " does not answer: " + log(),
           [this] { return !standing().system.empty(); });
  relay_ = test::Program(
      {"ip", "netns", "exec", options_.name, "setpriv", "--reuid", kRelayUser, "--regid",
       kRelayUser, "--clear-groups", built("mlcca-relay"), "--socket", file(".sock")},
      file(".relay.log"));
}

void RealGateway::kill() {
  // The daemon and the relay at once: what the one stops the other would carry on.
  daemon_.signal(SIGKILL);
  relay_.signal(SIGKILL);
  bridge_.end();
  daemon_.end();
  relay_.end();
}

void RealGateway::stop() {
  daemon_.signal(SIGTERM);
  require(daemon_.wait() == 0, options_.name + " has not ended well: " + log());
  kill();
}

control::Client RealGateway::connect() const {
  auto client = control::Client::connect(file(".sock"), kPatience);
  if (!client) give_up(client.error().text + log());
  return std::move(*client);
}

control::Cluster RealGateway::standing() const {
  auto client = control::Client::connect(file(".sock"), kPatience);
  if (!client) return {};
  auto reply = client->call({.id = 0, .body = control::ClusterRequest{}});
  if (!reply) return {};
  auto* const cluster = std::get_if<control::Cluster>(&reply->body);
  return cluster == nullptr ? control::Cluster{} : std::move(*cluster);
}

void RealGateway::wait_until_in() const {
  const auto start = Steady::now();
  for (control::Cluster now; now.phase != "in" || now.shared != "open"; now = standing()) {
    if (Steady::now() - start > kPatience)
      give_up(options_.name + " does not take part: " + now.why + '\n' + log());
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

std::string RealGateway::log() const {
  return text_of_file(file(".log")) + text_of_file(file(".bridge.log")) +
         text_of_file(file(".relay.log"));
}

}  // namespace mlcca::bench
