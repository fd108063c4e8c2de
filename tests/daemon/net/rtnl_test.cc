// SPDX-License-Identifier: BSD-2-Clause
// A kernel whose answers fail, tear, change and stay away: what is read is whole, or an error.
#include "daemon/net/rtnl.hpp"

#include <gtest/gtest.h>
#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <netlink/attr.h>
#include <netlink/msg.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <functional>
#include <limits>
#include <utility>

#include "daemon/net/links.hpp"

namespace {

/// Stand between this program and the kernel; nothing: the kernel itself.
std::function<ssize_t(ssize_t, msghdr*)> spoil_answer;  // given what the kernel has said
std::function<int()> fail_receiving;                    // errno, and what came stays; 0: received
std::function<int()> fail_sending;                      // errno, 0: sent
bool nothing_comes = false;
int asked = 0;
std::uint32_t question = 0;  // the number of the latest one
bool nothing_without_end = false;
timespec later{};  // added to every clock: this process has had no processor for so long

}  // namespace

extern "C" int clock_gettime(clockid_t clock, timespec* now) {
  const auto done = static_cast<int>(::syscall(SYS_clock_gettime, clock, now));
  now->tv_sec += later.tv_sec;
  return done;
}

extern "C" ssize_t recvmsg(int fd, msghdr* message, int flags) {
  if (nothing_without_end) {
    nlmsghdr noop{};
    noop.nlmsg_len = sizeof noop;
    noop.nlmsg_type = NLMSG_NOOP;
    noop.nlmsg_seq = question;
    std::memcpy(message->msg_iov->iov_base, &noop, sizeof noop);
    static_cast<sockaddr_nl*>(message->msg_name)->nl_pid = 0;
    ++later.tv_sec;
    return sizeof noop;
  }
  if (nothing_comes) {
    errno = EAGAIN;
    return -1;
  }
  if (const int error = fail_receiving ? fail_receiving() : 0; error != 0) {
    errno = error;
    return -1;
  }
  const ssize_t size = ::syscall(SYS_recvmsg, fd, message, flags);
  return spoil_answer && size > 0 ? spoil_answer(size, message) : size;
}
extern "C" ssize_t send(int fd, const void* octets, size_t size, int flags) {
  ++asked;
  question = static_cast<const nlmsghdr*>(octets)->nlmsg_seq;
  if (const int error = fail_sending ? fail_sending() : 0; error != 0) {
    errno = error;
    return -1;
  }
  return ::syscall(SYS_sendto, fd, octets, size, flags, nullptr, 0);
}
extern "C" int poll(pollfd* fds, nfds_t count, int) {
  if (nothing_comes) return 0;
  return static_cast<int>(::syscall(SYS_poll, fds, count, 1000));
}

namespace mlcca::net {
namespace {

nlmsghdr& first_of(msghdr* message) { return *static_cast<nlmsghdr*>(message->msg_iov->iov_base); }
class RtnlTest : public ::testing::Test {
 protected:
  ~RtnlTest() override { heal(); }
  static void heal() {
    spoil_answer = nullptr;
    fail_receiving = nullptr;
    fail_sending = nullptr;
    nothing_comes = false;
    asked = 0;
    later = {};
    nothing_without_end = false;
  }
  static Message interfaces() {
    const ifinfomsg head{};
    return new_message(RTM_GETLINK, 0, &head, sizeof head);
  }
  static std::size_t in(const Answers& answers) {
    std::size_t count = 0;
    answers.each([&count](const nlmsghdr&) { ++count; });
    return count;
  }
  /// Until it is healed, from the n-th answer on.
  static void fail_from(int n, int error) {
    fail_receiving = [n, error, received = 0]() mutable { return ++received >= n ? error : 0; };
  }
  static void fail_once(int n, int error) {
    fail_receiving = [n, error, received = 0]() mutable { return ++received == n ? error : 0; };
  }

  Rtnl kernel_;
  const int loopback_ = static_cast<int>(if_nametoindex("lo"));
};

TEST_F(RtnlTest, AnAnswerThatFailsIsNoShorterList) {
  const auto whole = kernel_.dump(interfaces());
  ASSERT_TRUE(whole) << whole.error().text;
  for (const int error : {ENOBUFS, ENOMEM, EIO, EINTR, EAGAIN})
    for (int n = 1; n <= 3; ++n) {
      fail_once(n, error);
      const auto again = kernel_.dump(interfaces());
      ASSERT_TRUE(again) << again.error().text;
      EXPECT_EQ(in(*again), in(*whole)) << "errno " << error << " at " << n;
      heal();
      const auto after = kernel_.dump(interfaces());
      ASSERT_TRUE(after);
      EXPECT_EQ(in(*after), in(*whole)) << "after errno " << error << " at " << n;
    }
}

TEST_F(RtnlTest, WhatFailsForEverIsAnError) {
  for (int n = 1; n <= 2; ++n) {
    fail_from(n, ENOBUFS);
    EXPECT_FALSE(kernel_.dump(interfaces()));
    heal();
    EXPECT_TRUE(kernel_.dump(interfaces()));
  }
}

TEST_F(RtnlTest, ASocketOnWhichAnythingFailedIsReplaced) {
  ASSERT_TRUE(kernel_.dump(interfaces()));
  EXPECT_EQ(kernel_.replaced(), 0U);
  fail_once(1, ENOBUFS);
  ASSERT_TRUE(kernel_.dump(interfaces()));
  EXPECT_EQ(kernel_.replaced(), 1U);
}

TEST_F(RtnlTest, AListThatChangedWhileItWasReadIsReadAgain) {
  spoil_answer = [](ssize_t size, msghdr* message) {
    if (asked < Rtnl::kTries) first_of(message).nlmsg_flags |= NLM_F_DUMP_INTR;
    return size;
  };
  EXPECT_TRUE(kernel_.dump(interfaces()));
  EXPECT_EQ(asked, Rtnl::kTries);
}

TEST_F(RtnlTest, AListThatAlwaysChangesIsAnError) {
  spoil_answer = [](ssize_t size, msghdr* message) {
    first_of(message).nlmsg_flags |= NLM_F_DUMP_INTR;
    return size;
  };
  EXPECT_FALSE(kernel_.dump(interfaces()));
  EXPECT_EQ(asked, Rtnl::kTries);
}

TEST_F(RtnlTest, TheEndOfAnotherListEndsNone) {
  spoil_answer = [first = true](ssize_t size, msghdr* message) mutable {
    if (!std::exchange(first, false)) return size;
    nlmsghdr& head = first_of(message);
    head.nlmsg_type = NLMSG_DONE;
    head.nlmsg_seq -= 1;
    head.nlmsg_len = NLMSG_LENGTH(sizeof(int));
    return static_cast<ssize_t>(head.nlmsg_len);
  };
  const auto read = kernel_.dump(interfaces());
  ASSERT_TRUE(read);
  EXPECT_GE(in(*read), 1U);
  EXPECT_EQ(kernel_.replaced(), 1U);
}

TEST_F(RtnlTest, TornAndTruncatedAnswersAreErrors) {
  spoil_answer = [](ssize_t size, msghdr*) { return size - 4; };
  EXPECT_FALSE(kernel_.dump(interfaces()));
  heal();
  spoil_answer = [](ssize_t size, msghdr* message) {
    message->msg_flags |= MSG_TRUNC;
    return size;
  };
  EXPECT_FALSE(kernel_.dump(interfaces()));
}

TEST_F(RtnlTest, AnEndWithWhatIsNoErrnoIsAnError) {
  spoil_answer = [](ssize_t size, msghdr* message) {
    nlmsghdr& first = first_of(message);
    first.nlmsg_type = NLMSG_ERROR;
    const int least = std::numeric_limits<int>::min();
    std::memcpy(NLMSG_DATA(&first), &least, sizeof least);
    return size;
  };
  const auto answers = kernel_.dump(interfaces());
  ASSERT_FALSE(answers);
  EXPECT_EQ(answers.error().said, 0);
}

TEST_F(RtnlTest, NoCallWaitsForEver) {
  nothing_comes = true;
  const auto read = kernel_.dump(interfaces());
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().text, "the kernel has not answered in time");
}

TEST_F(RtnlTest, AnAnswerThatIsThereIsTakenHoweverLateThisProcessComesToIt) {
  const auto whole = kernel_.dump(interfaces());
  ASSERT_TRUE(whole);
  for (const bool once : {false, true}) {
    later = {};
    fail_receiving = [once, first = true]() mutable {
      later.tv_sec += 10;
      return once && std::exchange(first, false) ? EAGAIN : 0;
    };
    asked = 0;
    const auto read = kernel_.dump(interfaces());
    ASSERT_TRUE(read) << read.error().text;
    EXPECT_EQ(in(*read), in(*whole));
    EXPECT_EQ(asked, 1);
  }
}

TEST_F(RtnlTest, MessagesWithoutEndPutNothingOff) {
  nothing_without_end = true;
  const auto read = kernel_.dump(interfaces());
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().text, "the kernel has not answered in time");
  EXPECT_LT(later.tv_sec, 100);
}

TEST_F(RtnlTest, WhatOthersSendPutsNothingOff) {
  spoil_answer = [](ssize_t size, msghdr* message) {
    static_cast<sockaddr_nl*>(message->msg_name)->nl_pid = 1;
    later.tv_sec += 10;
    return size;
  };
  const auto read = kernel_.dump(interfaces());
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().text, "the kernel has not answered in time");
}

TEST_F(RtnlTest, AQuestionThatCannotBeSentIsAskedAgainAndThenAnError) {
  fail_sending = [n = 0]() mutable { return ++n == 1 ? ENOBUFS : 0; };
  EXPECT_TRUE(kernel_.dump(interfaces()));
  for (const int error : {ENOBUFS, EINTR, EPERM, ECONNREFUSED}) {
    fail_sending = [error] { return error; };
    const auto read = kernel_.dump(interfaces());
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().said, 0);
  }
}

TEST_F(RtnlTest, AChangeIsNotRepeated) {
  const ifinfomsg nothing{};  // no interface is meant: refused, or not permitted
  nothing_comes = true;
  EXPECT_FALSE(kernel_.change(new_message(RTM_SETLINK, 0, &nothing, sizeof nothing)));
  EXPECT_EQ(asked, 1);
}

TEST_F(RtnlTest, ARefusalOfTheKernelIsAnAnswer) {
  ifinfomsg head{};
  head.ifi_index = 0x7fffffff;
  const auto read = kernel_.get(new_message(RTM_GETLINK, 0, &head, sizeof head));
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().said, ENODEV);
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(kernel_.replaced(), 0U);
}

TEST_F(RtnlTest, ATableThatCannotBeReadStaysAsItWas) {
  auto links = Links::open();
  ASSERT_TRUE(links) << links.error().text;
  ASSERT_TRUE(links->table().contains(loopback_));
  for (int n = 1; n <= 3; ++n) {
    fail_from(n, ENOBUFS);
    const InterfaceTable before = links->table();
    const auto read = links->refresh();
    EXPECT_EQ(links->problem().empty(), read.has_value());
    EXPECT_EQ(links->table(), before) << n;
    heal();
    ASSERT_TRUE(links->refresh());
    EXPECT_EQ(links->problem(), "");
    EXPECT_TRUE(links->table().contains(loopback_));
  }
}

TEST_F(RtnlTest, OnlyTheKernelsOwnAnswerMeansThatAnInterfaceHasGone) {
  auto links = Links::open();
  ASSERT_TRUE(links);
  EXPECT_EQ(links->presence(loopback_), Presence::there);
  EXPECT_EQ(links->presence(0x7fffffff), Presence::gone);
  for (const int error : {ENOBUFS, ENODEV, ENXIO}) {
    fail_from(1, error);
    EXPECT_EQ(links->presence(loopback_), Presence::unknown);
    EXPECT_EQ(links->presence(0x7fffffff), Presence::unknown);
    heal();
  }
}

// --- what libnl reads without checking whether it is there ---------------------------------------

int objects_of(const Message& message, int type) {
  Answers answers;
  answers.add(*nlmsg_hdr(message.get()));
  int count = 0;
  answers.each_object(type, [&count](nl_object*) { ++count; });
  return count;
}

TEST(Answers, ADisciplineBehindWhoseKindNothingCanBeReadIsNoObject) {
  const tcmsg head{};
  const Message message = new_message(RTM_NEWQDISC, 0, &head, sizeof head);
  ASSERT_EQ(nla_put_string(message.get(), TCA_KIND, "prio"), 0);
  const nlattr beyond_the_end{.nla_len = 0x218, .nla_type = TCA_OPTIONS};
  ASSERT_EQ(nlmsg_append(message.get(), const_cast<nlattr*>(&beyond_the_end), sizeof beyond_the_end,
                         NLMSG_ALIGNTO),
            0);
  EXPECT_EQ(objects_of(message, RTM_NEWQDISC), 0);
}

TEST(Answers, ACanLinkIsWhatIsSaidOfItLast) {
  const ifinfomsg head{.ifi_family = AF_UNSPEC,
                       .__ifi_pad = 0,
                       .ifi_type = ARPHRD_CAN,
                       .ifi_index = 1,
                       .ifi_flags = 0,
                       .ifi_change = 0};
  const Message message = new_message(RTM_NEWLINK, 0, &head, sizeof head);
  ASSERT_EQ(nla_put_string(message.get(), IFLA_IFNAME, "can0"), 0);
  for (const bool has_data : {true, false}) {
    nlattr* const information = nla_nest_start(message.get(), IFLA_LINKINFO);
    ASSERT_EQ(nla_put_string(message.get(), IFLA_INFO_KIND, "can"), 0);
    if (has_data) {
      nlattr* const data = nla_nest_start(message.get(), IFLA_INFO_DATA);
      ASSERT_EQ(nla_put_u32(message.get(), IFLA_CAN_RESTART_MS, 0), 0);
      nla_nest_end(message.get(), data);
    }
    nla_nest_end(message.get(), information);
  }
  EXPECT_EQ(objects_of(message, RTM_NEWLINK), 0);
}

}  // namespace
}  // namespace mlcca::net
