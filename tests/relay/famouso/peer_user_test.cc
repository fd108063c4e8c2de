// SPDX-License-Identifier: BSD-2-Clause
// Tests of how the user at the other end of a TCP connection is found: by a question about that
// connection alone, since whoever connects must not cost time that grows with the sockets of the
// host.
#include "relay/famouso/peer_user.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <netinet/in.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>

#include "base/handle.hpp"

namespace mlcca::relay {
namespace {

/// A connection over the loopback; `there` is the end of the program that connects.
struct Pair {
  Fd there{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  Fd here;
  Pair() {
    const Fd listener(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in at{};
    socklen_t size = sizeof at;
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    auto* const name = reinterpret_cast<sockaddr*>(&at);
    EXPECT_EQ(::bind(listener.get(), name, sizeof at), 0);
    EXPECT_EQ(::listen(listener.get(), 1), 0);
    EXPECT_EQ(::getsockname(listener.get(), name, &size), 0);
    EXPECT_EQ(::connect(there.get(), name, sizeof at), 0);
    here = Fd(::accept4(listener.get(), nullptr, nullptr, SOCK_CLOEXEC));
    EXPECT_TRUE(here);
  }
};

/// Whether the user is found by a process in which a system call with this first argument fails.
bool finds_without(long call, int first) {
  const Pair pair;
  const pid_t child = ::fork();
  if (child == 0) {
    std::array program{
        sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
        sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 3),
        sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args)),
        sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(first), 0, 1),
        sock_filter BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EAFNOSUPPORT),
        sock_filter BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    };
    const sock_fprog filter{.len = program.size(), .filter = program.data()};
    if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 ||
        ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) != 0)
      ::_exit(2);
    ::_exit(user_at_other_end(pair.here.get()) == ::getuid() ? 0 : 1);
  }
  int status = -1;
  return ::waitpid(child, &status, 0) == child && status == 0;
}

TEST(PeerUserLookup, NeedsNoTableOfAllSockets) { EXPECT_TRUE(finds_without(SYS_openat, AT_FDCWD)); }

TEST(PeerUserLookup, ReadsTheTablesWhereItMayNotAsk) {
  EXPECT_TRUE(finds_without(SYS_socket, AF_NETLINK));
}

TEST(PeerUserLookup, AClosedSocketHasNoUser) {
  for (const int lingers : {0, 1}) {
    Pair pair;
    const linger at_once{.l_onoff = lingers, .l_linger = 0};
    ASSERT_EQ(::setsockopt(pair.there.get(), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once), 0);
    pair.there.reset();
    EXPECT_FALSE(user_at_other_end(pair.here.get())) << (lingers == 0 ? "ended" : "reset");
  }
}

}  // namespace
}  // namespace mlcca::relay
