// SPDX-License-Identifier: BSD-2-Clause
#include "tests/fuzz/surroundings.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/if_arp.h>
#include <linux/if_tun.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <string_view>

#include "daemon/net/pair.hpp"
#include "tests/daemon/gates/sandbox.hpp"
#include "tests/fuzz/demand.hpp"

namespace mlcca::fuzz {
namespace {

constexpr uid_t kDescribedUser = 1003;

// --- the surroundings, made once -----------------------------------------------------------------

/// A tun device that says that it is a CAN interface.
Fd make_can(const std::string& name) {
  Fd fd(::open("/dev/net/tun", O_RDWR | O_CLOEXEC));  // NOLINT(*-vararg)
  ifreq request{};
  name.copy(request.ifr_name, IFNAMSIZ - 1);
  request.ifr_flags = IFF_TUN | IFF_NO_PI;
  // NOLINTBEGIN(*-vararg)
  demand(fd && ::ioctl(fd.get(), TUNSETIFF, &request) == 0, "a tun device");
  demand(::ioctl(fd.get(), TUNSETLINK, ARPHRD_CAN) == 0, "a tun device for CAN");
  const Fd any(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  request.ifr_flags = IFF_UP;
  demand(::ioctl(any.get(), SIOCSIFFLAGS, &request) == 0, "a device that is up");
  // NOLINTEND(*-vararg)
  return fd;
}

Surroundings make_surroundings() {
  demand(::geteuid() == 0, "this needs root: real gates, in namespaces of their own");
  Surroundings out;
  out.bpf_root = test::new_bpf_root();
  out.folder = std::filesystem::temp_directory_path() / "mlcca-fuzz";
  std::filesystem::create_directories(out.folder);
  demand(::mount("none", out.folder.c_str(), "tmpfs", 0, "mode=755") == 0, "a tmpfs");
  const auto paired = net::make_pair("veth", {"lan0", 101}, {"far0", 102});
  demand(paired.has_value(), "a pair of interfaces");
  out.can = make_can("bus0");
  std::filesystem::create_directories(out.bpf_root);
  ::signal(SIGPIPE, SIG_IGN);  // NOLINT(cert-err33-c)
  return out;
}

}  // namespace

const Surroundings& surroundings() {
  static const Surroundings made = make_surroundings();
  return made;
}

// --- what is described ---------------------------------------------------------------------------

namespace {

std::string attribute(const char* name, const char* unit, int magnitude, int value) {
  return fmt::format(
      "<Attribute><Name>{0}</Name><Dimension><SIUnit><{1}>1</{1}></SIUnit><Magnitude>{2}</"
      "Magnitude></Dimension><Value>{3}</Value></Attribute>",
      name, unit, magnitude, value);
}

std::string channel(int number) {
  return fmt::format(
      "<EventChannel name=\"c{0}\"><SubjectUID>{0:#x}</SubjectUID><Attributes>{1}{2}</Attributes>"
      "</EventChannel>\n",
      number, attribute("Period", "Seconds", -3, 10), attribute("MaxPayload", "Bytes", 0, 8));
}

}  // namespace

std::string description(std::size_t number) {
  if (number == kUnreadable) return "<System name=\"fuzz\"><Network";
  std::string out = "<System name=\"fuzz\">\n";
  constexpr std::string_view allowed = R"(<Unlisted allow="0x5600000000000000/8" most="2"/>)";
  const std::string_view unlisted = number == 1 ? std::string_view{} : allowed;
  for (int c = 1; c <= 5; ++c) out += channel(c);
  out +=
      "<Network name=\"lan\"><Kind>udp-multicast</Kind><Profile>famouso</Profile><Provision>" +
      attribute("Latency", "Seconds", -3, 1) + attribute("Period", "Seconds", -3, 1) +
      attribute("Jitter", "Seconds", -3, 1) + attribute("MaxPayload", "Bytes", 0, 1000) +
      "<Attribute><Name>Bandwidth</Name><Dimension><SIUnit><Bytes>1</Bytes><Seconds>-1</Seconds></"
      "SIUnit>"
      "</Dimension><Value>100000</Value></Attribute>"
      "</Provision>" +
      std::string(unlisted) +
      "</Network>\n"
      "<Network name=\"bus\"><Kind>can</Kind><Profile>famouso</Profile><Bus bitrate=\"500000\"/>";
  for (int c = 1; c <= 5; ++c)
    out += fmt::format("<Binding channel=\"c{0}\"><ETag>{1:#x}</ETag></Binding>", c, 0x100 + c);
  out += std::string(unlisted) +
         "</Network>\n"
         "<Gateway name=\"gate\"><Port network=\"lan\"><Interface name=\"lan0\"/></Port>"
         "<Port network=\"bus\"><Interface name=\"bus0\"/></Port></Gateway>\n";
  if (number != 1) out += "<Publisher channel=\"c1\" network=\"lan\"/>\n";
  if (number == 2)
    out += "<Subscriber channel=\"c1\" network=\"bus\"/>\n";
  else
    out += "<Subscriber channel=\"c1\" gateway=\"gate\"/>\n";
  out += "<Subscriber channel=\"c2\" gateway=\"gate\"/>\n";
  out += fmt::format("<Publisher channel=\"c5\" gateway=\"gate\" user=\"{}\"/>\n", kDescribedUser);
  out += "<Subscriber channel=\"c5\" network=\"lan\"/>\n";
  return out + "</System>\n";
}

// --- who connects --------------------------------------------------------------------------------

namespace {

/// This thread alone, and only for the kernel's record of who has connected.
void become(uid_t user, gid_t group) {
  // NOLINTBEGIN(*-vararg)
  demand(::syscall(SYS_setresuid, -1, 0, -1) == 0 && ::syscall(SYS_setresgid, -1, group, -1) == 0 &&
             ::syscall(SYS_setresuid, -1, user, -1) == 0,
         "another user");
  // NOLINTEND(*-vararg)
}

}  // namespace

Fd connected(const std::string& path, User user) {
  Fd fd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(static_cast<char*>(address.sun_path), sizeof(address.sun_path) - 1);
  if (user == User::member) become(1001, kGroup);
  if (user == User::outsider) become(1002, 1002);
  // NOLINTNEXTLINE(*-reinterpret-cast): as connect() has it
  const int done = ::connect(fd.get(), reinterpret_cast<sockaddr*>(&address), sizeof address);
  if (user != User::root) become(0, 0);
  demand(done == 0, "no client can connect");
  return fd;
}

}  // namespace mlcca::fuzz
