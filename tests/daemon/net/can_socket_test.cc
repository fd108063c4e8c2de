// SPDX-License-Identifier: BSD-2-Clause
// What mlccad takes from mlcca-can. This kernel may have no CAN: that a frame leaves is for a
// guest.
#include "daemon/net/can_socket.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "base/passed_fd.hpp"
#include "base/unix_address.hpp"

namespace mlcca::net {
namespace {

std::array<Fd, 2> pair_of(int type) {
  std::array<int, 2> ends{};
  EXPECT_EQ(::socketpair(AF_UNIX, type | SOCK_CLOEXEC, 0, ends.data()), 0);
  return {Fd(ends[0]), Fd(ends[1])};
}

/// A message with so many file descriptors of /dev/null.
void send_several(const Fd& to, int count) {
  char byte = 0;
  iovec data{.iov_base = &byte, .iov_len = 1};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(4 * sizeof(int))> control{};
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  std::vector<Fd> fds;
  if (count > 0) {
    message.msg_control = control.data();
    message.msg_controllen = CMSG_SPACE(static_cast<unsigned>(count) * sizeof(int));
    cmsghdr* const part = CMSG_FIRSTHDR(&message);
    part->cmsg_level = SOL_SOCKET;
    part->cmsg_type = SCM_RIGHTS;
    part->cmsg_len = CMSG_LEN(static_cast<unsigned>(count) * sizeof(int));
    for (int i = 0; i < count; ++i) {
      fds.emplace_back(::open("/dev/null", O_RDONLY | O_CLOEXEC));
      const int number = fds.back().get();
      std::memcpy(CMSG_DATA(part) + static_cast<unsigned>(i) * sizeof number, &number,
                  sizeof number);
    }
  }
  EXPECT_EQ(::sendmsg(to.get(), &message, 0), 1);
}

std::size_t open_descriptors() {
  std::size_t count = 0;
  for (int fd = 0; fd < 256; ++fd) count += ::fcntl(fd, F_GETFD) >= 0 ? 1 : 0;
  return count;
}

TEST(PassedFd, IsTheSameFileAndIsClosedOnExec) {
  const auto [ours, theirs] = pair_of(SOCK_SEQPACKET);
  EXPECT_FALSE(receive_fd(ours)) << "nothing has come";
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe2(pipe.data(), O_CLOEXEC), 0);
  const Fd out(pipe[0]);
  const Fd in(pipe[1]);
  ASSERT_TRUE(send_fd(theirs.get(), in));
  const auto passed = receive_fd(ours);
  ASSERT_TRUE(passed && *passed);
  EXPECT_EQ(::fcntl(passed->get(), F_GETFD), FD_CLOEXEC);
  EXPECT_EQ(::write(passed->get(), "x", 1), 1);
  char byte = 0;
  EXPECT_EQ(::read(out.get(), &byte, 1), 1);
  EXPECT_EQ(byte, 'x');
}

TEST(PassedFd, NoneOrSeveralAreRefusedAndNoneStaysOpen) {
  for (const int count : {0, 2, 4}) {
    const auto [ours, theirs] = pair_of(SOCK_SEQPACKET);
    const std::size_t before = open_descriptors();
    send_several(theirs, count);
    const auto passed = receive_fd(ours);
    ASSERT_TRUE(passed) << count;
    EXPECT_FALSE(*passed) << count;
    EXPECT_EQ(open_descriptors(), before) << count;
  }
}

TEST(PassedFd, TheEndOfTheOtherProcessIsNoDescriptor) {
  auto [ours, theirs] = pair_of(SOCK_SEQPACKET);
  theirs.reset();
  const auto passed = receive_fd(ours);
  ASSERT_TRUE(passed);
  EXPECT_FALSE(*passed);
}

TEST(CanSocket, TakesNoSocketOfAnotherKind) {
  for (const int family : {AF_UNIX, AF_INET}) {
    const Fd socket(::socket(family, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    const auto taken = make_sender(socket);
    ASSERT_FALSE(taken);
    EXPECT_EQ(taken.error().text, "not a raw socket of CAN");
  }
  EXPECT_FALSE(make_sender(Fd(::open("/dev/null", O_RDONLY | O_CLOEXEC))));
}

/// A socket in the file system in place of that of mlcca-can.
class Helper : public ::testing::Test {
 protected:
  Helper() {
    std::string name = "/tmp/can-socket-XXXXXX";
    EXPECT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    const auto address = unix_address(path());
    EXPECT_EQ(::bind(listens_.get(), generic(*address), sizeof *address), 0);
    EXPECT_EQ(::listen(listens_.get(), 4), 0);
  }
  Helper(const Helper&) = delete;
  Helper& operator=(const Helper&) = delete;
  Helper(Helper&&) = delete;
  Helper& operator=(Helper&&) = delete;
  ~Helper() override {
    ::unlink(path().c_str());
    ::rmdir(folder_.c_str());
  }
  [[nodiscard]] std::string path() const { return folder_ + "/can"; }
  [[nodiscard]] Fd accept() const { return Fd(::accept(listens_.get(), nullptr, nullptr)); }

  std::string folder_;
  Fd listens_{::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)};
};

bool has_can() { return static_cast<bool>(Fd(::socket(PF_CAN, SOCK_RAW, 1))); }

TEST_F(Helper, IsAskedOnceUntilItAnswersAndAgainAfterAWrongAnswer) {
  if (has_can()) return;  // no helper is needed
  CanSocket can(path());
  EXPECT_FALSE(can.send(1, {}));
  EXPECT_FALSE(can.send(1, {}));
  Fd first = accept();
  ASSERT_TRUE(first);
  EXPECT_FALSE(accept()) << "it was asked twice";
  ASSERT_TRUE(send_fd(first.get(), Fd(::open("/dev/null", O_RDONLY | O_CLOEXEC))));
  EXPECT_EQ(can.problem(), "");
  EXPECT_TRUE(can.send(1, {})) << "the frame is lost";
  EXPECT_EQ(can.problem(), path() + ": what was handed over is not a raw socket of CAN");
  EXPECT_FALSE(can.send(1, {}));
  first = accept();
  ASSERT_TRUE(first) << "it is asked again";
  first.reset();
  EXPECT_TRUE(can.send(1, {})) << "the frame is lost";
  EXPECT_EQ(can.problem(), path() + ": mlcca-can ended without handing over a socket");
}

TEST_F(Helper, MayBeMissing) {
  if (has_can()) return;
  CanSocket can(path() + "-of-nobody");
  EXPECT_TRUE(can.send(1, {})) << "the frame is lost";
  EXPECT_EQ(can.problem(), path() + "-of-nobody: No such file or directory");
}

}  // namespace
}  // namespace mlcca::net
