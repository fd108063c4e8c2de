// SPDX-License-Identifier: BSD-2-Clause
// What is written to a reader that does not read.
#include "base/at_once.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>

#include "base/handle.hpp"

namespace mlcca {
namespace {

struct Ends {
  Fd reader;
  Fd writer;
};

Ends new_pipe() {
  std::array<int, 2> ends{-1, -1};
  EXPECT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
  return {.reader = Fd(ends[0]), .writer = Fd(ends[1])};
}

Ends new_socket_pair() {
  std::array<int, 2> ends{-1, -1};
  EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
  return {.reader = Fd(ends[0]), .writer = Fd(ends[1])};
}

Ends new_terminal() {
  Fd main(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC));
  EXPECT_EQ(::grantpt(main.get()), 0);
  EXPECT_EQ(::unlockpt(main.get()), 0);
  Fd other(::open(::ptsname(main.get()), O_RDWR | O_NOCTTY | O_CLOEXEC));
  EXPECT_TRUE(other);
  return {.reader = std::move(main), .writer = std::move(other)};
}

/// Lines until one is not taken whole; none of them holds a mebibyte.
bool becomes_full(const Ends& ends, std::size_t line) {
  for (std::size_t written = 0; written < 1UL << 20U; written += line)
    if (!write_at_once(ends.writer.get(), std::string(line, 'x'))) return true;
  return false;
}

TEST(Manager, AFullPipeSocketOrTerminalIsNotWaitedFor) {
  for (const std::size_t line : {10UL, 100UL, 4096UL, 100'000UL}) {
    EXPECT_TRUE(becomes_full(new_pipe(), line)) << line;
    EXPECT_TRUE(becomes_full(new_socket_pair(), line)) << line;
    EXPECT_TRUE(becomes_full(new_terminal(), line)) << line;
  }
}

TEST(Manager, AStoppedTerminalIsNotWaitedFor) {
  const Ends terminal = new_terminal();
  ASSERT_EQ(::tcflow(terminal.writer.get(), TCOOFF), 0);
  EXPECT_FALSE(write_at_once(terminal.writer.get(), "a line"));
}

TEST(Manager, WhoSharesAnOpenFileIsNotMadeToFail) {
  for (const Ends& ends : {new_pipe(), new_socket_pair(), new_terminal()}) {
    EXPECT_TRUE(write_at_once(ends.writer.get(), "a line"));
    EXPECT_EQ(::fcntl(ends.writer.get(), F_GETFL) & O_NONBLOCK, 0);
    std::array<char, 16> text{};
    EXPECT_EQ(::read(ends.reader.get(), text.data(), text.size()), 6);
  }
}

TEST(Manager, AFileGrowsWhereItWasLeft) {
  std::string path = ::testing::TempDir() + "mlcca-lines-XXXXXX";
  const Fd file(::mkostemp(path.data(), O_CLOEXEC));
  EXPECT_TRUE(write_at_once(file.get(), "one\n"));
  EXPECT_TRUE(write_at_once(file.get(), "two\n"));
  EXPECT_EQ(::lseek(file.get(), 0, SEEK_END), 8);
  ::unlink(path.c_str());
}

TEST(Manager, AReaderThatHasGoneIsNoEnd) {
  ::signal(SIGPIPE, SIG_DFL);
  Ends pipe = new_pipe();
  pipe.reader.reset();
  EXPECT_FALSE(write_at_once(pipe.writer.get(), "a line"));
  Ends pair = new_socket_pair();
  pair.reader.reset();
  EXPECT_FALSE(write_at_once(pair.writer.get(), "a line"));
}

}  // namespace
}  // namespace mlcca
