// SPDX-License-Identifier: BSD-2-Clause
// Values, names and other tokens of 100 MB: a clear problem, or none for a comment, and memory that
// does not follow them.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <string>

#include "base/handle.hpp"
#include "description/read.hpp"

namespace mlcca::description {
namespace {

constexpr std::size_t kHuge = std::size_t{100} << 20U;  // bytes
// Beyond what was in use before. The library holds no more than 10 MB of one token, grown by
// doubling. An address sanitizer keeps what was freed for a while.
#ifdef __SANITIZE_ADDRESS__
constexpr long kMostKib = 400L << 10U;
#else
constexpr long kMostKib = 64L << 10U;
#endif

long peak_kib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

struct Outcome {
  std::string problems;  ///< one a line
  long grown_kib = 0;
};

/// Reads the text in a process of its own, of which the text is a part before it starts.
Outcome read_apart(const std::string& xml) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) return {};
  const auto child = fork();
  if (child == 0) {
    const auto before = peak_kib();
    const auto result = read_memory(xml, "t.xml");
    std::string out;
    if (!result)
      for (const auto& p : result.error()) out += to_string(p) + "\n";
    out = std::to_string(peak_kib() - before) + "\n" + out;
    const auto written = write(ends[1], out.data(), out.size());
    _exit(written == static_cast<ssize_t>(out.size()) ? 0 : 1);
  }
  close(ends[1]);
  const Fd from(ends[0]);
  std::string text;
  std::array<char, 4096> buffer{};
  for (ssize_t got = 0; (got = ::read(from.get(), buffer.data(), buffer.size())) > 0;)
    text.append(buffer.data(), static_cast<std::size_t>(got));
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  const auto line = text.find('\n');
  if (line == std::string::npos) return {};
  return {text.substr(line + 1), std::stol(text)};
}

struct Case {
  const char* name;
  const char* before;
  const char* after;
  const char* problem;
};

class HugeToken : public ::testing::TestWithParam<Case> {};

TEST_P(HugeToken, IsAnsweredInBoundedMemory) {
  const auto& c = GetParam();
  std::string xml;
  xml.reserve(kHuge + 1000);
  xml = c.before;
  xml.append(kHuge, 'x');
  xml += c.after;
  const auto outcome = read_apart(xml);
  EXPECT_EQ(outcome.problems, c.problem);
  EXPECT_LT(outcome.grown_kib, kMostKib);
}

INSTANTIATE_TEST_SUITE_P(
    Read, HugeToken,
    ::testing::Values(
        Case{"Attribute", "<System name=\"", "\"/>",
             "t.xml:1: a name or value is longer than 10 MB; that is the limit\n"},
        Case{"Text", "<System name=\"a\"><Network name=\"n\"><Kind>", "</Kind></Network></System>",
             "t.xml:1: <Kind>: is longer than 65536 bytes; that is the limit\n"},
        Case{"WrongText", "<System name=\"a\">", "</System>",
             "t.xml:1: <System>: holds text, which has no meaning here: its content goes into "
             "elements\n"},
        Case{"Comment", "<System name=\"a\"><!--", "--></System>", ""},
        Case{"Instruction", "<System name=\"a\"><?a ", "?></System>",
             "t.xml:1: <System>: not well-formed XML: PI a too big found\n"},
        Case{"Section", "<System name=\"a\"><![CDATA[", "]]></System>",
             "t.xml:1: <System>: not well-formed XML: CData section too big found\n"},
        Case{"ElementName", "<System name=\"a\"><", "/></System>",
             "t.xml:1: <System>: a name or value is longer than 10 MB; that is the limit\n"},
        Case{"AttributeName", "<System name=\"a\" ", "=\"1\"/>",
             "t.xml:1: a name or value is longer than 10 MB; that is the limit\n"},
        Case{"NamespaceName", "<System name=\"a\" xmlns:a=\"", "\"/>",
             "t.xml:1: a name or value is longer than 10 MB; that is the limit\n"},
        Case{"Href",
             "<System name=\"a\"><a:include xmlns:a=\"http://www.w3.org/2001/XInclude\" href=\"",
             "\"/></System>",
             "t.xml:1: <System>: a name or value is longer than 10 MB; that is the limit\n"},
        Case{"Version", "<?xml version=\"1.", "\"?><System name=\"a\"/>",
             "t.xml:1: not well-formed XML: String not closed expecting \" or '\n"}),
    [](const ::testing::TestParamInfo<Case>& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace mlcca::description
