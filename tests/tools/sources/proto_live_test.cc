// SPDX-License-Identifier: BSD-2-Clause
// Sources against what runs beside mlccad: mlcca-awds on an interface on which AWDS nodes send, and
// babeld. Network namespaces of our own; needs root.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "base/handle.hpp"
#include "tests/support/require.hpp"
#include "tests/tools/sources/proto_loop.hpp"

namespace mlcca::net {
namespace {

using core::mesh::Snapshot;
using core::mesh::Source;
using core::mesh::SourceKind;
using test::require;

void run(const std::string& command) {
  if (std::system(command.c_str()) != 0) ADD_FAILURE() << command;
}

/// A program that was built beside this one: "../mlcca-awds".
std::string built(const std::string& name) {
  return (std::filesystem::read_symlink("/proc/self/exe").parent_path() / name).string();
}

Fd own_namespace() { return Fd(::open("/proc/self/ns/net", O_RDONLY | O_CLOEXEC)); }

Fd new_namespace() {
  require(::unshare(CLONE_NEWNET) == 0, "unshare (needs root)");
  run("ip link set lo up");
  return own_namespace();
}

/// What is done while it lives is done in that namespace.
class Inside {
 public:
  explicit Inside(const Fd& there) : back_(own_namespace()) {
    require(::setns(there.get(), CLONE_NEWNET) == 0, "setns");
  }
  Inside(const Inside&) = delete;
  Inside& operator=(const Inside&) = delete;
  ~Inside() { require(::setns(back_.get(), CLONE_NEWNET) == 0, "setns"); }

 private:
  Fd back_;
};

/// A program in the present namespace; it is asked to end with this object.
class Child {
 public:
  explicit Child(const std::vector<std::string>& command) {
    std::array<int, 2> pipe{};
    require(::pipe2(pipe.data(), O_CLOEXEC) == 0, "pipe");
    input_ = Fd(pipe[1]);
    const Fd far(pipe[0]);
    std::vector<char*> arguments;
    for (const auto& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    pid_ = ::fork();
    if (pid_ == 0) {
      ::dup2(far.get(), STDIN_FILENO);
      ::execvp(arguments[0], arguments.data());
      ::_exit(127);
    }
    require(pid_ > 0, "fork");
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    ::kill(pid_, SIGTERM);
    ::waitpid(pid_, nullptr, 0);
  }
  void write(const std::string& line) const {
    require(::write(input_.get(), line.data(), line.size()) == std::ssize(line),
            "write to a child");
  }
  [[nodiscard]] pid_t pid() const { return pid_; }

 private:
  Fd input_;
  pid_t pid_ = -1;
};

std::string file_text(const std::string& path) {
  std::ostringstream out;
  out << std::ifstream(path).rdbuf();
  return out.str();
}

const std::string kOne = "02:00:00:00:00:01";
const std::string kTwo = "02:00:00:00:00:02";
const std::string kThree = "02:00:00:00:00:03";

class AwdsLive : public ::testing::Test {
 protected:
  AwdsLive() : there_(new_namespace()) { add_interface(); }

  static void add_interface() { run("ip link add mesh0 type veth peer name air0"); }
  static void bring_up() { run("ip link set mesh0 up && ip link set air0 up"); }

  [[nodiscard]] std::vector<std::string> relay() const {
    return {built("../mlcca-awds"), "mesh0", folder_ / "socket"};
  }
  static std::vector<std::string> emulator() {
    return {built("awds-emulator"), "air0", "3", "100"};
  }
  [[nodiscard]] Source source() const {
    Source out;
    out.kind = SourceKind::awds;
    out.interface = "mesh0";
    out.endpoint = folder_ / "socket";
    return out;
  }
  static bool whole(const Snapshot& s) { return s.links.size() == 4; }
  static test::Watched::Predicate loss_is(const std::string& from, const std::string& to,
                                          Value loss) {
    return [=](const Snapshot& s) {
      const auto* link = test::find(s, from, to);
      return link != nullptr && link->loss == loss;
    };
  }

  Fd there_;
  test::Folder folder_;
};

TEST_F(AwdsLive, QualitiesAndSilenceOfNodesAreSeen) {
  bring_up();
  const Child relay(this->relay());
  const Child emulator(this->emulator());
  test::Watched watched(source(), {});
  const auto first = watched.await(whole);
  ASSERT_TRUE(first) << watched.last();
  EXPECT_EQ(first->links[0].loss, 0U);
  // What 2 says of 1 is the loss of 1 -> 2: 27 of 32.
  emulator.write("quality 2 1 10235\n");
  EXPECT_TRUE(watched.await(loss_is(kOne, kTwo, 156'250'000))) << watched.last();
  EXPECT_TRUE(loss_is(kTwo, kOne, 0)(*watched.await(whole)));
  emulator.write("drop 3\n");
  const auto left = watched.await([](const auto& s) { return s.links.size() == 2; });
  ASSERT_TRUE(left) << watched.last();
  EXPECT_EQ(test::find(*left, kTwo, kThree), nullptr);
}

TEST_F(AwdsLive, AnInterfaceMayVanishAndComeBack) {
  const Child relay(this->relay());
  bring_up();
  test::Watched watched(source(), {});
  {
    const Child emulator(this->emulator());
    ASSERT_TRUE(watched.await(whole)) << watched.last();
    run("ip link del mesh0");
    const auto gone = watched.await([](const auto& s) { return s.links.empty(); });
    ASSERT_TRUE(gone) << watched.last();
    EXPECT_NE(gone->problem, "");
  }
  add_interface();
  bring_up();
  const Child emulator(this->emulator());
  ASSERT_TRUE(watched.await(whole)) << watched.last();
  run("ip link set mesh0 down");
  ASSERT_TRUE(watched.await([](const auto& s) { return s.links.empty(); })) << watched.last();
  run("ip link set mesh0 up");
  EXPECT_TRUE(watched.await(whole)) << watched.last();
}

TEST_F(AwdsLive, TheHelperMayDieAndSeveralMayRead) {
  bring_up();
  const Child emulator(this->emulator());
  test::Watched one(source(), {});
  const auto missing = one.await([](const auto& s) { return !s.problem.empty(); });
  ASSERT_TRUE(missing);
  EXPECT_NE(missing->problem.find("socket"), std::string::npos) << missing->problem;
  {
    const Child relay(this->relay());
    ASSERT_TRUE(one.await(whole)) << one.last();
    test::Watched two(source(), {});
    EXPECT_TRUE(two.await(whole)) << two.last();
  }
  const auto lost = one.await([](const auto& s) { return s.links.empty(); });
  ASSERT_TRUE(lost) << one.last();
  EXPECT_NE(lost->problem.find("socket"), std::string::npos) << lost->problem;
  const Child relay(this->relay());
  EXPECT_TRUE(one.await(whole)) << one.last();
}

TEST_F(AwdsLive, TheHelperKeepsNoCapability) {
  bring_up();
  const Child relay(this->relay());
  const Child emulator(this->emulator());
  test::Watched watched(source(), {});
  ASSERT_TRUE(watched.await(whole)) << watched.last();
  const auto status = file_text("/proc/" + std::to_string(relay.pid()) + "/status");
  EXPECT_NE(status.find("CapEff:\t0000000000000000"), std::string::npos) << status;
  EXPECT_NE(status.find("CapPrm:\t0000000000000000"), std::string::npos) << status;
}

/// Two machines, babeld on each: a and b, 10.9.1.1 and 10.9.2.1.
class BabelLive : public ::testing::Test {
 protected:
  BabelLive() {
    b_ = new_namespace();
    a_ = new_namespace();
    run("ip link add mesh0 type veth peer name mesh1");
    run("ip link set mesh1 netns /proc/" + std::to_string(::getpid()) + "/fd/" +
        std::to_string(b_.get()));
    set_up("mesh0", "10.9.1.1");
    const Inside there(b_);
    set_up("mesh1", "10.9.2.1");
  }

  static void set_up(const std::string& interface, const std::string& address) {
    // The link-local address is usable at once.
    run("sysctl -q net.ipv6.conf." + interface + ".accept_dad=0");
    run("ip addr add " + address + "/32 dev lo && ip link set " + interface + " up");
  }

  [[nodiscard]] std::vector<std::string> babeld(const std::string& interface,
                                                const std::string& local) const {
    return {"babeld",
            "-I",
            folder_ / (interface + ".pid"),
            "-S",
            folder_ / (interface + ".state"),
            "-h",
            "1",
            "-H",
            "1",
            "-C",
            "skip-kernel-setup true",
            "-C",
            local,
            "-C",
            "interface " + interface + " type wireless update-interval 2",
            "-C",
            "redistribute local ip 10.9.0.0/16 eq 32 allow",
            interface};
  }

  Fd a_;
  Fd b_;
  test::Folder folder_;
};

TEST_F(BabelLive, NeighboursRoutesAndTheLossOfBothAreSeen) {
  Source source;
  source.kind = SourceKind::babel;
  source.endpoint = "[::1]:33123";
  const auto mesh = test::mesh_of({"10.9.1.1", "10.9.2.1"});
  test::Watched watched(source, mesh);
  ASSERT_TRUE(watched.await([](const auto& s) {
    return s.problem.find("refused") != std::string::npos;
  })) << watched.last();

  const Child a(babeld("mesh0", "local-port 33123"));
  std::unique_ptr<Child> b;
  {
    const Inside there(b_);
    b = std::make_unique<Child>(babeld("mesh1", "local-path " + (folder_ / "b.sock")));
  }
  const auto whole = [](const Snapshot& s) {
    const auto* there = test::find(s, "10.9.1.1", "10.9.2.1");
    const auto* back = test::find(s, "10.9.2.1", "10.9.1.1");
    return there != nullptr && back != nullptr && there->loss == 0U && back->loss == 0U &&
           there->weight == 256U && !s.next_hops.empty();
  };
  const auto seen = watched.await(whole);
  ASSERT_TRUE(seen) << watched.last();
  EXPECT_EQ(seen->next_hops[0].to, "10.9.2.1");
  EXPECT_EQ(seen->next_hops[0].via, "10.9.2.1");
  EXPECT_EQ(seen->next_hops[0].from, "10.9.1.1");

  // The same from the other side, through a path.
  source.endpoint = folder_ / "b.sock";
  test::Watched other(source, mesh);
  EXPECT_TRUE(other.await([](const auto& s) {
    return test::find(s, "10.9.2.1", "10.9.1.1") != nullptr;
  })) << other.last();

  b.reset();
  EXPECT_TRUE(watched.await([](const auto& s) {
    const auto* back = test::find(s, "10.9.2.1", "10.9.1.1");
    return s.problem.empty() && s.next_hops.empty() && (back == nullptr || back->loss > 0U);
  })) << watched.last();
}

}  // namespace
}  // namespace mlcca::net
