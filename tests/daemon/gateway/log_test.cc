// SPDX-License-Identifier: BSD-2-Clause
// Lines of the log towards a journald that does not read for a while.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "base/unix_address.hpp"
#include "daemon/system_log.hpp"
#include "tests/support/source_tree.hpp"

namespace mlcca {
namespace {

class Journald {
 public:
  Journald() : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
    EXPECT_NE(::mkdtemp(folder_.data()), nullptr);
    const auto address = unix_address(path());
    EXPECT_EQ(::bind(socket_.get(), generic(*address), sizeof(*address)), 0);
  }
  Journald(const Journald&) = delete;
  Journald(Journald&&) = delete;
  Journald& operator=(const Journald&) = delete;
  Journald& operator=(Journald&&) = delete;
  ~Journald() { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::string path() const { return folder_ + "/socket"; }
  /// The next entry; empty where there is none.
  [[nodiscard]] std::string read() const {
    std::array<char, 65536> text{};
    const ssize_t size = ::recv(socket_.get(), text.data(), text.size(), 0);
    return size < 0 ? "" : std::string(text.data(), static_cast<std::size_t>(size));
  }

 private:
  std::string folder_ = std::filesystem::temp_directory_path() / "mlcca-log-XXXXXX";
  Fd socket_;
};

/// A field as the native protocol has it.
std::string field(const std::string& name, const std::string& value) {
  std::string text = name + '\n';
  text.push_back(static_cast<char>(value.size()));
  return text + std::string(7, '\0') + value + '\n';
}

TEST(Log, AnEntryHasItsFieldsWhateverTheirValuesAre) {
  const Journald journald;
  const SystemLog journal = SystemLog::to_journald(journald.path());
  journal.write({.kind = Kind::granted,
                 .message = "two\nlines=",
                 .channel = "stop",
                 .publisher = "lever",
                 .by = control::Actor{.uid = 1000, .user = "alice", .pid = 42}});
  const std::string entry = journald.read();
  for (const std::string& part :
       {field("MESSAGE", "two\nlines="), field("PRIORITY", "6"), field("MLCCA_KIND", "granted"),
        field("CHANNEL", "stop"), field("PUBLISHER", "lever"), field("CLIENT_UID", "1000"),
        field("CLIENT_PID", "42"), field("CLIENT_USER", "alice"), field("VERDICT", "granted")})
    EXPECT_NE(entry.find(part), std::string::npos) << part;
}

TEST(Log, LinesWithoutAReaderAreLostAndCounted) {
  const Journald journald;
  const SystemLog journal = SystemLog::to_journald(journald.path());
  constexpr int kWritten = 5000;  // more than a queue of datagrams holds
  for (int i = 0; i < kWritten; ++i) journal.write({.message = "line"});
  int read = 0;
  while (!journald.read().empty()) ++read;
  ASSERT_LT(read, kWritten);
  journal.write({.message = "after"});
  EXPECT_NE(journald.read().find("(" + std::to_string(kWritten - read) +
                                 " lines before this one were lost: they were not read) after"),
            std::string::npos);
  journal.write({.message = "last"});
  EXPECT_NE(journald.read().find(field("MESSAGE", "last")), std::string::npos);
}

TEST(Log, ALineThatWasTakenInPartEndsBeforeTheNextOne) {
  std::array<int, 2> ends{-1, -1};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
  const Fd reader(ends[0]);
  Fd writer(ends[1]);
  const Fd before(::dup(STDERR_FILENO));
  ASSERT_EQ(::dup2(writer.get(), STDERR_FILENO), STDERR_FILENO);
  writer.reset();
  const SystemLog journal = SystemLog::to_stderr();
  journal.write({.message = std::string(std::size_t{16} << 20, 'x')});
  std::string read;
  std::array<char, 65536> text{};
  const auto drain = [&] {
    for (ssize_t n = 0; (n = ::recv(reader.get(), text.data(), text.size(), MSG_DONTWAIT)) > 0;)
      read.append(text.data(), static_cast<std::size_t>(n));
  };
  drain();
  ASSERT_FALSE(read.empty());
  EXPECT_NE(read.back(), '\n') << "all of it was taken";
  journal.write({.message = "after"});
  drain();
  ASSERT_EQ(::dup2(before.get(), STDERR_FILENO), STDERR_FILENO);
  EXPECT_TRUE(read.ends_with("x\n(1 line before this one was lost: it was not read) after\n"))
      << read.substr(read.size() - 100);
}

std::string content_of(const std::string& file) {
  std::ifstream stream(testing::source_tree() / file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::vector<Kind> all_kinds() {
  std::vector<Kind> kinds;
  std::istringstream names(kind_names());
  for (std::string name; std::getline(names >> std::ws, name, ',');)
    kinds.push_back(kind_named(name).value());
  return kinds;
}

TEST(Kinds, HaveOneNameInTheManualPagesAndInTheSchema) {
  const auto daemon = content_of("docs/man/mlccad.8");
  const auto client = content_of("docs/man/mlccactl.1");
  const auto schema = content_of("proto/mlcca/v1/control.proto");
  for (const Kind kind : all_kinds()) {
    const std::string name = name_of(kind);
    std::string entry = name;
    entry.resize(13, ' ');
    EXPECT_NE(daemon.find("\n" + entry + message_id_of(kind) + "\n"), std::string::npos) << name;
    EXPECT_NE(client.find(name), std::string::npos) << name;
    EXPECT_NE(schema.find(name), std::string::npos) << name;
  }
}

/// The words from "started" on to the end of the list.
std::vector<std::string> kinds_in(const std::string& file) {
  const std::string text = content_of(file);
  const auto begin = text.find("started stopped");
  std::istringstream list(text.substr(begin, text.find_first_of("'\")", begin) - begin));
  return {std::istream_iterator<std::string>(list), {}};
}

TEST(Kinds, AreWhatEachShellCompletes) {
  std::vector<std::string> names;
  for (const Kind kind : all_kinds()) names.emplace_back(name_of(kind));
  for (const char* shell : {"mlccactl.bash", "_mlccactl", "mlccactl.fish"})
    EXPECT_EQ(kinds_in(std::string("tools/completion/") + shell), names) << shell;
}

}  // namespace
}  // namespace mlcca
