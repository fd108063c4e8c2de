// SPDX-License-Identifier: BSD-2-Clause
// Tests of a daemon that starts after another one was killed: what stays in force while it starts.
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "base/unix_address.hpp"
#include "tests/daemon/start/daemon.hpp"
#include "tests/support/becomes.hpp"

namespace mlcca::test {
namespace {

/// A babeld that accepts connections and sends nothing, so that the daemon waits for its first
/// report.
class MuteSource {
 public:
  explicit MuteSource(const std::string& path)
      : socket_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)), path_(path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(static_cast<char*>(address.sun_path), sizeof(address.sun_path) - 1);
    EXPECT_EQ(::bind(socket_.get(), reinterpret_cast<sockaddr*>(&address),  // NOLINT(*-cast)
                     sizeof(address)),
              0);
    EXPECT_EQ(::listen(socket_.get(), 16), 0);
  }
  [[nodiscard]] std::string network() const {
    return "<Network name=\"air\"><Kind>mesh</Kind><Mesh><Source kind=\"babel\" endpoint=\"" +
           path_ + "\"/></Mesh></Network>\n";
  }

 private:
  Fd socket_;
  std::string path_;
};

/// With one port more than this the daemon makes its status in a child process.
constexpr int kManyPorts = 17;

class StartTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { make_links(kManyPorts); }

  /// Runs a daemon until its gates are in force, and kills it.
  void let_one_die() {
    Process before(gateway_.command(), gateway_.path("log"));
    ASSERT_TRUE(before.ready()) << gateway_.log();
    before.signal(SIGKILL);
    EXPECT_EQ(before.end(), 128 + SIGKILL);
    word_ = gateway_.word();
    ASSERT_TRUE(word_);
    ASSERT_EQ(word_[0].open, 1U);
  }

  /// The times of the heart-beats that are seen until the gates of the daemon are in force.
  std::set<std::uint64_t> beats_of(Process& daemon) {
    std::set<std::uint64_t> seen;
    EXPECT_TRUE(daemon.ready([&] {
      seen.insert(__atomic_load_n(&word_[0].heartbeat, __ATOMIC_ACQUIRE));
    })) << gateway_.log();
    return seen;
  }

  Gateway gateway_{described(1)};
  gates::Mapped<gate_control> word_;
};

TEST_F(StartTest, BeatsBeforeItHasReadEverything) {
  const MuteSource source(gateway_.path("babel"));
  let_one_die();
  gateway_.describe(described(1, source.network()));
  Process after(gateway_.command(), gateway_.path("log"));
  EXPECT_GE(beats_of(after).size(), 5U);  // the former daemon's, and more than one at the end
}

TEST_F(StartTest, BeatsNotBeforeItHasReadEverythingWhereThatIsNotWanted) {
  const MuteSource source(gateway_.path("babel"));
  let_one_die();
  gateway_.describe(described(1, source.network()));
  Process after(gateway_.command({"--start-limit", "0"}), gateway_.path("log"));
  EXPECT_LE(beats_of(after).size(), 3U);
}

TEST_F(StartTest, BeginsInAuditModeWhereTheGatewayIsIntroduced) {
  Process daemon(gateway_.command({"--initial-mode", "audit"}), gateway_.path("log"));
  ASSERT_TRUE(daemon.ready()) << gateway_.log();
  EXPECT_EQ(gateway_.word()[0].mode, std::uint32_t{GATE_AUDIT});
  EXPECT_TRUE(gateway_.comes_to_log("AUDIT MODE")) << gateway_.log();
}

TEST_F(StartTest, InAModeThatThereIsNotIsRefused) {
  Process daemon(gateway_.command({"--initial-mode", "open"}), gateway_.path("log"));
  EXPECT_FALSE(daemon.ready());
  EXPECT_EQ(daemon.end(), 2);
}

TEST_F(StartTest, ThatFailsClosesWhatWasOpen) {
  let_one_die();
  gateway_.describe("<System");
  Process after(gateway_.command(), gateway_.path("log"));
  EXPECT_FALSE(after.ready());
  EXPECT_EQ(after.end(), 2);
  EXPECT_EQ(word_[0].open, 0U);
}

TEST_F(StartTest, BeatsNotBeforeItHasReadEverythingWhereTheGatesHaveLapsed) {
  let_one_die();
  const MuteSource source(gateway_.path("babel"));
  gateway_.describe(described(1, source.network()));
  __atomic_store_n(&word_[0].lapsed, 1, __ATOMIC_RELEASE);
  Process after(gateway_.command(), gateway_.path("log"));
  EXPECT_LE(beats_of(after).size(), 3U);
  EXPECT_EQ(word_[0].lapsed, 0U);
}

TEST_F(StartTest, ThatIsRefusedBecauseAnotherDaemonRunsDoesNotSayThatEverythingIsDenied) {
  Process first(gateway_.command(), gateway_.path("log"));
  ASSERT_TRUE(first.ready()) << gateway_.log();
  word_ = gateway_.word();
  const Gateway other(described(1));
  auto command = other.command();
  *std::next(std::ranges::find(command, "--state-directory")) = gateway_.path("state");
  Process second(command, other.path("log"));
  EXPECT_FALSE(second.ready());
  EXPECT_NE(second.end(), 0);
  EXPECT_EQ(word_[0].open, 1U) << "the gates of the first one";
  const std::string said = other.log();
  EXPECT_EQ(said.find("on every gate"), std::string::npos) << said;
  EXPECT_NE(said.find("deny everything, and no others were changed"), std::string::npos) << said;
  first.signal(SIGTERM);
  EXPECT_EQ(first.end(), 0);
}

TEST_F(StartTest, GoesOnBeatingWhileTheDiskTakesNothing) {
  const std::string slow = gateway_.path("slow");
  const auto library =
      std::filesystem::read_symlink("/proc/self/exe").parent_path() / "slow_disk.so";
  ::setenv("SLOW_DISK", slow.c_str(), 1);      // NOLINT(concurrency-mt-unsafe)
  ::setenv("LD_PRELOAD", library.c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
  Process daemon(gateway_.command({"--grace", "2s"}), gateway_.path("log"));
  ::unsetenv("LD_PRELOAD");  // NOLINT(concurrency-mt-unsafe)
  ASSERT_TRUE(daemon.ready()) << gateway_.log();
  word_ = gateway_.word();
  ASSERT_TRUE(word_);
  std::ofstream(slow) << "now";
  const auto heartbeat = [&] { return __atomic_load_n(&word_[0].heartbeat, __ATOMIC_ACQUIRE); };
  const std::uint64_t before = heartbeat();
  Process asks({"mlccactl", "--timeout", "60", "--socket", gateway_.path("control.sock"),
                "withdraw", "--yes", "c0"},
               gateway_.path("said"));
  EXPECT_TRUE(becomes([&] { return heartbeat() > before + 2 * word_[0].grace_ns; }))
      << "no heart-beat while a change waits for the disk";
  EXPECT_EQ(word_[0].lapsed, 0U);
  std::filesystem::remove(slow);
  EXPECT_EQ(asks.end(), 0);
}

// --- a user database that never answers ----------------------------------------------------------

/// Makes look-ups of users hang in this process and in those that it starts.
class HangingUsers {
 public:
  /// `database` is passwd or group.
  HangingUsers(const Gateway& gateway, const std::string& database) {
    const std::string file = gateway.path("nsswitch.conf");
    std::ofstream(file) << database << ": hang\n";
    const auto library = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "nss";
    ::setenv("LD_LIBRARY_PATH", library.c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
    EXPECT_EQ(::mount(file.c_str(), kFile, nullptr, MS_BIND, nullptr), 0);
  }
  HangingUsers(const HangingUsers&) = delete;
  HangingUsers(HangingUsers&&) = delete;
  HangingUsers& operator=(const HangingUsers&) = delete;
  HangingUsers& operator=(HangingUsers&&) = delete;
  ~HangingUsers() {
    EXPECT_EQ(::umount(kFile), 0);
    ::unsetenv("LD_LIBRARY_PATH");  // NOLINT(concurrency-mt-unsafe)
  }

  static constexpr const char* kSender =
      "<Publisher channel=\"c0\" gateway=\"gate\" user=\"somebody\"/>\n";

 private:
  static constexpr const char* kFile = "/etc/nsswitch.conf";
};

TEST_F(StartTest, GoesOnBeatingWhileALookUpOfUsersHangsAndThenGivesUp) {
  let_one_die();
  const HangingUsers users(gateway_, "passwd");
  gateway_.describe(described(1, HangingUsers::kSender));
  Process after(gateway_.command({"--read-limit", "3s"}), gateway_.path("log"));
  std::set<std::uint64_t> seen;
  EXPECT_FALSE(
      after.ready([&] { seen.insert(__atomic_load_n(&word_[0].heartbeat, __ATOMIC_ACQUIRE)); }));
  EXPECT_GE(seen.size(), 4U) << "the former one's, and some while it hung";
  EXPECT_EQ(after.end(), 1) << "systemd tries again";
  EXPECT_EQ(word_[0].open, 0U);
  EXPECT_NE(gateway_.log().find("does a look-up of users hang"), std::string::npos)
      << gateway_.log();
}

TEST_F(StartTest, AReloadWhoseLookUpOfUsersHangsIsGivenUp) {
  const HangingUsers users(gateway_, "passwd");
  Process daemon(gateway_.command({"--read-limit", "1s"}), gateway_.path("log"));
  ASSERT_TRUE(daemon.ready()) << "no user is looked up yet: " << gateway_.log();
  const auto word = gateway_.word();
  gateway_.describe(described(1, HangingUsers::kSender));
  daemon.signal(SIGHUP);
  EXPECT_TRUE(gateway_.comes_to_log("does a look-up of users hang")) << gateway_.log();
  EXPECT_EQ(word[0].lapsed, 0U);
  EXPECT_EQ(word[0].open, 1U);
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.end(), 0) << "also while the thread hangs";
}

TEST_F(StartTest, WhereTheLookUpOfTheGroupHangsOnlyRootMayChangeAnything) {
  let_one_die();
  const HangingUsers users(gateway_, "group");
  Process after(gateway_.command(), gateway_.path("log"));
  EXPECT_GE(beats_of(after).size(), 4U);
  EXPECT_NE(gateway_.log().find("only root may change anything"), std::string::npos);
  EXPECT_EQ(word_[0].open, 1U);
  after.signal(SIGTERM);
  EXPECT_EQ(after.end(), 0);
}

TEST_F(StartTest, ACheckRefusesWhatAStartWould) {
  const auto check = [this](const std::string& description, std::vector<std::string> more = {}) {
    gateway_.describe(description);
    more.insert(more.begin(), "--check");
    return Process(gateway_.command(std::move(more)), gateway_.path("log")).end();
  };
  EXPECT_EQ(check(described(1)), 0);
  EXPECT_EQ(check(described(1), {"--gateway", "gate"}), 0);
  EXPECT_EQ(check(described(1), {"--gateway", "another"}), 2);
  EXPECT_NE(gateway_.log().find("no Gateway is called 'another'"), std::string::npos);
  EXPECT_EQ(check("<System name=\"empty\"></System>"), 2);
  EXPECT_NE(gateway_.log().find("no Gateway is described"), std::string::npos);
}

TEST_F(StartTest, OfManyPortsTheStatusIsWhole) {
  gateway_.describe(described(kManyPorts));
  Process daemon(gateway_.command(), gateway_.path("log"));
  ASSERT_TRUE(daemon.ready()) << gateway_.log();
  const std::string said = gateway_.path("status");
  Process asks({"mlccactl", "--socket", gateway_.path("control.sock"), "--json", "status"}, said);
  EXPECT_EQ(asks.end(), 0);
  std::ifstream file(said);
  const std::string status(std::istreambuf_iterator<char>(file), {});
  for (int i = 0; i < kManyPorts; ++i)
    EXPECT_NE(status.find("\"lan" + std::to_string(i) + "\""), std::string::npos) << status;
}

TEST_F(StartTest, WhatHasHappenedIsInTheHistory) {
  Process daemon(gateway_.command(), gateway_.path("log"));
  ASSERT_TRUE(daemon.ready()) << gateway_.log();
  const std::string said = gateway_.path("history");
  Process asks({"mlccactl", "--socket", gateway_.path("control.sock"), "--json", "history"}, said);
  EXPECT_EQ(asks.end(), 0);
  std::ifstream file(said);
  const std::string history(std::istreambuf_iterator<char>(file), {});
  EXPECT_NE(history.find("\"kind\":\"started\""), std::string::npos) << history;
}

TEST_F(StartTest, WithoutTheFolderOfTheBpffsClosesAndSaysWhatToDo) {
  let_one_die();
  auto command = gateway_.command();
  *std::next(std::ranges::find(command, "--bpf-root")) = gateway_.path("no/bpf");
  Process after(command, gateway_.path("log"));
  EXPECT_FALSE(after.ready());
  EXPECT_EQ(after.end(), 1);
  EXPECT_NE(gateway_.log().find("is on no bpffs: mount one (mount -t bpf bpf DIRECTORY)"),
            std::string::npos)
      << gateway_.log();
  EXPECT_NE(gateway_.log().find("closed: lan0"), std::string::npos) << gateway_.log();
}

TEST_F(StartTest, WaitsNeitherForSystemdNorForWhoeverReadsItsLines) {
  let_one_die();
  Process after(gateway_.command(), gateway_.path("log"), Readers::none);
  std::set<std::uint64_t> beats;
  EXPECT_TRUE(becomes([&] {
    beats.insert(__atomic_load_n(&word_[0].heartbeat, __ATOMIC_ACQUIRE));
    return beats.size() > 8;
  }));
  // The relay reports that it is ready as soon as it has a reader.
  EXPECT_TRUE(after.ready());
  after.signal(SIGTERM);
  EXPECT_EQ(after.end(), 0);
  EXPECT_EQ(word_[0].open, 0U);
}

TEST_F(StartTest, ClosesEveryInterfaceWithoutAReaderOfItsOutput) {
  Process closing(gateway_.command({"--close", "lan0", "--close", "missing"}), gateway_.path("log"),
                  Readers::none);
  EXPECT_TRUE(closing.ends());
  EXPECT_EQ(closing.end(), 0);
}

/// Three interfaces: lan0 is named in gate.conf, lan1 in conf.d, and lan2 nowhere. They may have
/// gates from an earlier test.
class NamedInterfaces {
 public:
  explicit NamedInterfaces(const Gateway& gateway) : gateway_(gateway) {
    std::filesystem::create_directories(gateway_.path("etc/conf.d"));
    std::ofstream(gateway_.path("etc/gate.conf")) << "MLCCA_INTERFACES=lan0\n";
    std::ofstream(gateway_.path("etc/conf.d/10.conf")) << "MLCCA_INTERFACES=lan1\n";
  }
  void make_a_mistake() const {
    std::ofstream(gateway_.path("etc/conf.d/05.conf")) << "\nMLCCA_INTERFACE=lan3\n";
  }
  /// The exit status of --close; its messages are in the log.
  [[nodiscard]] int close(std::vector<std::string> more) const {
    std::filesystem::remove(gateway_.path("log"));
    more.insert(more.begin(), {"--named-in", gateway_.path("etc"), "--close"});
    return Process(gateway_.command(std::move(more)), gateway_.path("log")).end();
  }
  /// Those of lan0, lan1 and lan2 that have a gate now, according to the log.
  [[nodiscard]] std::set<std::string> closed() const {
    std::set<std::string> names;
    for (const char* name : {"lan0", "lan1", "lan2"})
      if (says(std::string(name) + ": closed\n") ||
          says(std::string(name) + ": has a gate already"))
        names.insert(name);
    return names;
  }
  [[nodiscard]] bool says(const std::string& words) const {
    return gateway_.log().find(words) != std::string::npos;
  }

 private:
  const Gateway& gateway_;
};
using Names = std::set<std::string>;

TEST_F(StartTest, ClosesTheInterfacesThatAreNamed) {
  const NamedInterfaces interfaces(gateway_);
  EXPECT_EQ(interfaces.close({}), 0);
  EXPECT_EQ(interfaces.closed(), (Names{"lan0", "lan1"}));
}

TEST_F(StartTest, ClosesOneThatAppearsWhereItIsNamed) {
  const NamedInterfaces interfaces(gateway_);
  EXPECT_EQ(interfaces.close({"lan2"}), 0);
  EXPECT_EQ(gateway_.log(), "");
  EXPECT_EQ(interfaces.close({"lan1"}), 0);
  EXPECT_EQ(interfaces.closed(), (Names{"lan1"}));
}

TEST_F(StartTest, WithAMistakeClosesTheOthersAndWhatAppearsCountsAsNamed) {
  const NamedInterfaces interfaces(gateway_);
  interfaces.make_a_mistake();
  EXPECT_EQ(interfaces.close({}), 2);
  EXPECT_TRUE(interfaces.says(gateway_.path("etc/conf.d/05.conf:2: "))) << gateway_.log();
  EXPECT_EQ(interfaces.closed(), (Names{"lan0", "lan1"}));
  EXPECT_EQ(interfaces.close({"lan2"}), 2);
  EXPECT_EQ(interfaces.closed(), (Names{"lan2"}));
}

TEST_F(StartTest, ListsTheInterfacesThatAreNamedWithoutClosingAny) {
  const NamedInterfaces interfaces(gateway_);
  EXPECT_EQ(interfaces.close({"--check"}), 0);
  EXPECT_EQ(gateway_.log(), gateway_.path("etc/gate.conf:1: lan0\n") +
                                gateway_.path("etc/conf.d/10.conf:1: lan1\n"));
  interfaces.make_a_mistake();
  EXPECT_EQ(interfaces.close({"--check"}), 2);
  EXPECT_TRUE(interfaces.says("'MLCCA_INTERFACE' is no setting")) << gateway_.log();
  EXPECT_EQ(interfaces.closed(), Names{});
}

TEST_F(StartTest, TheReaderOfUntrustedInputEndsWithoutAReaderOfItsOutput) {
  Process reader({"mlcca-sources"}, gateway_.path("log"), Readers::none);
  EXPECT_TRUE(reader.ends());
  EXPECT_EQ(reader.end(), 1);
}

// --- mlcca-awds ----------------------------------------------------------------------------------

/// Connects, and shuts the writing side down. The result is true if the owner of the socket then
/// closes the connection.
bool is_served(const std::string& path) {
  const Fd socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
  const auto address = unix_address(path);
  if (!becomes([&] { return ::connect(socket.get(), generic(*address), sizeof(*address)) == 0; }) ||
      ::shutdown(socket.get(), SHUT_WR) < 0)
    return false;
  return becomes([&] {
    char none = 0;
    return ::recv(socket.get(), &none, 1, MSG_DONTWAIT) == 0;
  });
}

TEST_F(StartTest, TheRelayOfAwdsWaitsNeitherForSystemdNorForWhoeverReadsItsLines) {
  const std::string socket = gateway_.path("awds");
  Process relay({"mlcca-awds", "lan0", socket}, gateway_.path("log"), Readers::none);
  EXPECT_TRUE(is_served(socket));
  // It reports that it is ready as soon as it has a reader.
  EXPECT_TRUE(relay.ready());
  relay.signal(SIGTERM);
  EXPECT_TRUE(relay.ends());
  EXPECT_EQ(relay.end(), 0);
}

}  // namespace
}  // namespace mlcca::test
