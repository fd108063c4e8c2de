// SPDX-License-Identifier: BSD-2-Clause
// Any user may listen where babeld, olsrd2 or mlcca-awds does not: it is not believed. Needs root,
// to be another user.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <fstream>

#include "base/handle.hpp"
#include "base/unix_address.hpp"
#include "tests/tools/sources/proto_loop.hpp"

namespace mlcca::net {
namespace {

using core::mesh::SourceKind;

constexpr uid_t kOtherUser = 65'534;

/// A process of that user listens: its socket is made, bound and answers as soon as this is there.
class OtherUser {
 public:
  /// An address of TCP, or of a local socket of this type.
  OtherUser(const sockaddr* address, socklen_t size, int type) {
    std::array<int, 2> ready{};
    if (::pipe(ready.data()) != 0) std::abort();
    child_ = ::fork();
    if (child_ == 0) listen(address, size, type, ready[1]);
    ::close(ready[1]);
    const Fd from(ready[0]);
    if (::read(from.get(), &port_, sizeof port_) != sizeof port_) std::abort();
  }
  OtherUser(const OtherUser&) = delete;
  OtherUser& operator=(const OtherUser&) = delete;
  ~OtherUser() {
    ::kill(child_, SIGKILL);
    ::waitpid(child_, nullptr, 0);
  }
  [[nodiscard]] std::uint16_t port() const { return port_; }

 private:
  [[noreturn]] static void listen(const sockaddr* address, socklen_t size, int type, int ready) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::setgid(kOtherUser) != 0 || ::setuid(kOtherUser) != 0) ::_exit(1);
    const int socket = ::socket(address->sa_family, type, 0);
    if (::bind(socket, address, size) != 0 || ::listen(socket, 8) != 0) ::_exit(1);
    sockaddr_in bound{};
    size = sizeof bound;
    // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
    ::getsockname(socket, reinterpret_cast<sockaddr*>(&bound), &size);
    const std::uint16_t port = ntohs(bound.sin_port);
    if (::write(ready, &port, sizeof port) != sizeof port) ::_exit(1);
    for (;;) {
      const int client = ::accept(socket, nullptr, nullptr);
      const char answer[] =
          "BABEL 1.0\nok\nadd interface a up true ipv6 ::1\n"
          "add neighbour 1 address ::2 if a rxcost 256 txcost 256 cost 256\nok\nok\n";
      if (::write(client, answer, sizeof answer) < 0) ::_exit(1);
    }
  }

  pid_t child_ = 0;
  std::uint16_t port_ = 0;
};

core::mesh::Source source(SourceKind kind, const std::string& endpoint) {
  core::mesh::Source out;
  out.kind = kind;
  out.endpoint = endpoint;
  return out;
}

std::string reported_of(const core::mesh::Source& source) {
  test::Watched watched(source, test::mesh_of({"a", "b"}));
  const auto reported =
      watched.await([](const auto& s) { return !s.problem.empty() || !s.links.empty(); });
  return reported && reported->links.empty() ? reported->problem : watched.last();
}

const char* const kRefused = "belongs to uid 65534";

TEST(OwnerLive, APortAtWhichAnotherUserListensIsNotBelieved) {
  sockaddr_in loopback{};
  loopback.sin_family = AF_INET;
  loopback.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  // NOLINTNEXTLINE(*-reinterpret-cast): the sockets API
  const OtherUser other(reinterpret_cast<const sockaddr*>(&loopback), sizeof loopback, SOCK_STREAM);
  const std::string endpoint = "127.0.0.1:" + std::to_string(other.port());
  for (const auto kind : {SourceKind::babel, SourceKind::olsr})
    EXPECT_NE(reported_of(source(kind, endpoint)).find(kRefused), std::string::npos);
}

TEST(OwnerLive, APathAtWhichAnotherUserListensIsNotBelieved) {
  const test::Folder folder;
  ::chmod((folder / "").c_str(), 0777);
  for (const auto& [kind, type] :
       {std::pair{SourceKind::babel, SOCK_STREAM}, std::pair{SourceKind::awds, SOCK_SEQPACKET}}) {
    const std::string path = folder / std::to_string(type);
    const auto address = unix_address(path);
    ASSERT_TRUE(address);
    const OtherUser other(generic(*address), sizeof *address, type);
    EXPECT_NE(reported_of(source(kind, path)).find(kRefused), std::string::npos);
  }
}

TEST(OwnerLive, AFileThatOthersMayWriteIsNotBelieved) {
  const test::Folder folder;
  const std::string path = folder / "links";
  std::ofstream(path) << "a b 1Mbit/s\n";
  const auto file = source(SourceKind::file, path);
  EXPECT_EQ(reported_of(file).find("problem: \n"), 0U) << "ours";
  ::chmod(path.c_str(), 0646);
  EXPECT_NE(reported_of(file).find("all users may write it"), std::string::npos);
  ::chmod(path.c_str(), 0644);
  ASSERT_EQ(::chown(path.c_str(), kOtherUser, kOtherUser), 0);
  EXPECT_NE(reported_of(file).find(kRefused), std::string::npos);
}

}  // namespace
}  // namespace mlcca::net
