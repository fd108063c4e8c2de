// SPDX-License-Identifier: BSD-2-Clause
// The lock of a bpffs against users who may read the bpffs, or write to it, and against ourselves.
#include "daemon/ports/gates_lock.hpp"

#include <fcntl.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <functional>

#include "tests/daemon/gates/sandbox.hpp"

namespace mlcca {
namespace {

constexpr uid_t kService = 64001;
constexpr gid_t kGroup = 64002;
constexpr uid_t kMember = 64003;  ///< of the group

/// What `body` gives, run in a process of that user.
int as_user(uid_t user, gid_t group, const std::function<int()>& body) {
  const pid_t child = ::fork();
  if (child == 0) {
    const std::array groups{group};
    if (::setgroups(1, groups.data()) != 0 || ::setgid(group) != 0 || ::setuid(user) != 0)
      ::_exit(100);
    ::_exit(body());
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 101;
}

/// errno of an attempt to hold the lock of a directory, 0: it is held.
int hold_lock_of(const std::string& path) {
  const Fd fd(::open(path.c_str(), O_RDONLY | O_DIRECTORY));
  return fd && ::flock(fd.get(), LOCK_EX | LOCK_NB) == 0 ? 0 : errno;
}

int lock_as_the_service(const std::string& root) { return lock_gates(root) ? 0 : 1; }

/// A bpffs as run-mlcca-bpf.mount and mlcca-gate.service make it.
class GatesLockTest : public ::testing::Test {
 protected:
  GatesLockTest() {
    ::umask(0);
    EXPECT_EQ(::mkdir(root_.c_str(), 0750), 0);
    EXPECT_EQ(::chown(root_.c_str(), kService, kGroup), 0);
  }
  ~GatesLockTest() override { std::filesystem::remove_all(root_); }
  GatesLockTest(const GatesLockTest&) = delete;
  GatesLockTest(GatesLockTest&&) = delete;
  GatesLockTest& operator=(const GatesLockTest&) = delete;
  GatesLockTest& operator=(GatesLockTest&&) = delete;

  [[nodiscard]] std::string problem() const {
    const auto locked = lock_gates(root_);
    return locked ? std::string() : locked.error().text;
  }
  const std::string root_ = test::new_bpf_root();
};

/// Or else two daemons could begin there at once.
TEST_F(GatesLockTest, AFolderThatIsNotThereYetIsMadeInTheBpffsAndLocked) {
  const std::string folder = root_ + "/later";
  auto first = lock_gates(folder);
  ASSERT_TRUE(first) << first.error().text;
  EXPECT_FALSE(lock_gates(folder));
  EXPECT_FALSE(*keep_lock(*first, folder)) << "it is held as it was";
}

TEST_F(GatesLockTest, IsHeldByOneProcessAtATime) {
  {
    const auto first = lock_gates(root_);
    ASSERT_TRUE(first) << first.error().text;
    EXPECT_EQ(problem(),
              root_ + ": another mlccad commands the gates there; they are left as they are");
  }
  EXPECT_EQ(problem(), "");
}

TEST_F(GatesLockTest, IsHeldAgainAfterItsDirectoryWasRemoved) {
  auto first = lock_gates(root_);
  ASSERT_TRUE(first) << first.error().text;
  EXPECT_FALSE(keep_lock(*first, root_).value()) << "it is there";
  std::filesystem::remove(root_ + "/lock");
  EXPECT_TRUE(keep_lock(*first, root_).value());
  EXPECT_EQ(problem(),
            root_ + ": another mlccad commands the gates there; they are left as they are");
  std::filesystem::remove(root_ + "/lock");
  const auto other = lock_gates(root_);
  ASSERT_TRUE(other);
  const auto lost = keep_lock(*first, root_);
  ASSERT_FALSE(lost);
  EXPECT_NE(lost.error().text.find("another mlccad commands the gates there"), std::string::npos);
}

TEST_F(GatesLockTest, CannotBeHeldByWhoMayReadTheBpffs) {
  ASSERT_EQ(as_user(kService, kGroup, [&] { return lock_as_the_service(root_); }), 0);
  std::array<int, 2> held{};
  std::array<int, 2> end{};
  ASSERT_EQ(::pipe(held.data()), 0);
  ASSERT_EQ(::pipe(end.data()), 0);
  const pid_t member = ::fork();
  if (member == 0) {
    ::close(end[1]);
    static_cast<void>(as_user(kMember, kGroup, [&] {
      const Fd root(::open(root_.c_str(), O_RDONLY | O_DIRECTORY));
      static_cast<void>(::flock(root.get(), LOCK_EX | LOCK_NB));
      const char said = hold_lock_of(root_ + "/lock") == EACCES ? 'n' : 'y';
      char nothing = 0;
      static_cast<void>(::write(held[1], &said, 1));
      return ::read(end[0], &nothing, 1) == 0 ? 0 : 1;  // until the test is over
    }));
    ::_exit(0);
  }
  char has_lock = 0;
  ASSERT_EQ(::read(held[0], &has_lock, 1), 1);
  EXPECT_EQ(has_lock, 'n');
  EXPECT_EQ(as_user(kService, kGroup, [&] { return lock_as_the_service(root_); }), 0);
  for (const int fd : {held[0], held[1], end[0], end[1]}) ::close(fd);
  ::waitpid(member, nullptr, 0);
}

TEST_F(GatesLockTest, MadeByRootItIsTheServicesAllTheSame) {
  ASSERT_EQ(problem(), "");
  EXPECT_EQ(as_user(kService, kGroup, [&] { return lock_as_the_service(root_); }), 0);
}

TEST_F(GatesLockTest, TakesBackWhatWasMadeReadable) {
  ASSERT_EQ(problem(), "");
  ASSERT_EQ(::chmod((root_ + "/lock").c_str(), 0755), 0);
  EXPECT_EQ(problem(), "");
  EXPECT_EQ(as_user(kMember, kGroup, [&] { return hold_lock_of(root_ + "/lock"); }), EACCES);
}

TEST_F(GatesLockTest, IsRefusedWhereOthersMayExchangeThePins) {
  ASSERT_EQ(::chmod(root_.c_str(), 0770), 0);
  EXPECT_EQ(problem(), root_ + " can be changed by others (mode 0770): chmod 0750");
  ASSERT_EQ(::chmod(root_.c_str(), 0757), 0);
  EXPECT_EQ(problem(), root_ + " can be changed by others (mode 0757): chmod 0750");
  ASSERT_EQ(::chmod(root_.c_str(), 01777), 0);  // a bpffs as mount(8) makes it
  EXPECT_EQ(problem(), "");
}

TEST_F(GatesLockTest, IsRefusedWhereAnotherUserHasMadeWhatWeWouldUse) {
  ASSERT_EQ(::chmod(root_.c_str(), 01777), 0);
  for (const std::string name : {"lock", "v12345", "early_programs"}) {
    const bool ours = name != "v12345";
    const std::string path = root_ + "/" + name;
    ASSERT_EQ(as_user(kMember, kGroup, [&] { return ::mkdir(path.c_str(), 0700); }), 0);
    EXPECT_EQ(problem(), ours ? path +
                                    " belongs to user 64003: remove it, and mount the bpffs "
                                    "with mode=0750"
                              : "");
    ASSERT_EQ(::rmdir(path.c_str()), 0);
  }
}

TEST_F(GatesLockTest, FollowsNoLink) {
  const std::string elsewhere = root_ + "/elsewhere";
  ASSERT_EQ(::mkdir(elsewhere.c_str(), 0700), 0);
  ASSERT_EQ(::symlink(elsewhere.c_str(), (root_ + "/lock").c_str()), 0);
  EXPECT_EQ(problem(), root_ + "/lock: Not a directory");
}

TEST_F(GatesLockTest, IsNotTakenByAUserWhoseBpffsItIsNot) {
  ASSERT_EQ(::chmod(root_.c_str(), 0755), 0);
  EXPECT_EQ(as_user(kMember, kGroup, [&] { return lock_as_the_service(root_); }), 1);
  EXPECT_FALSE(std::filesystem::exists(root_ + "/lock"));
}

}  // namespace
}  // namespace mlcca
