// SPDX-License-Identifier: BSD-2-Clause
// Tests of recordings in the forms in which users have them: compressed by gzip, through a pipe,
// with a byte-order mark, cut off; and logs of Vector tools with names.
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tests/tools/design/describe/program.hpp"
#include "tests/tools/learn/pcap_file.hpp"
#include "tests/tools/learn/read_back.hpp"
#include "tests/tools/learn/traffic.hpp"
#include "tools/learn/input.hpp"
#include "tools/learn/recording.hpp"

namespace mlcca::learn {
namespace {

using mlcca::test::Folder;
using mlcca::test::Ran;
using mlcca::test::run;
using mlcca::test::run_program;
using test::ReadBack;

ReadBack unpack(Input& input) {
  return test::read_back([&](Interfaces& interfaces, const auto& take) {
    return read_recording(input, "bus", interfaces, take);
  });
}

Bytes bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};  // NOLINT
}

ReadBack unpack(const std::string& text) {
  Input input(bytes_of(text));
  return unpack(input);
}

/// Reads a recording in pieces of `size` bytes, as a pipe may give them.
ReadBack unpack_in_pieces(const std::string& text, std::size_t size) {
  std::size_t at = 0;
  Input input([&](std::span<std::uint8_t> to) -> Result<std::size_t> {
    const auto piece = std::min({size, to.size(), text.size() - at});
    std::ranges::copy(bytes_of(text).subspan(at, piece), to.begin());
    at += piece;
    return piece;
  });
  return unpack(input);
}

std::string gzip(const std::string& text) {
  z_stream stream{};
  EXPECT_EQ(::deflateInit2(&stream, 6, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY), Z_OK);
  std::string out(::deflateBound(&stream, text.size()), '\0');
  stream.next_in = const_cast<Bytef*>(bytes_of(text).data());  // NOLINT
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());  // NOLINT
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(::deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  ::deflateEnd(&stream);
  return out;
}

std::string log_of(unsigned frames) {
  std::string out;
  for (unsigned i = 0; i < frames; ++i) {
    const std::string tenths = std::to_string(i % 10);
    out += "(" + std::to_string(1'700'000'000 + i / 10) + "." + tenths + "00000) can" +
           std::to_string(i % 3) + " 123#" + std::to_string(10 + i * 7919 % 90) + "A" + tenths +
           "\n";
  }
  return out;
}

/// A pcap file with `frames` frames.
std::string trace_of(unsigned frames) {
  test::PcapFile file(227);
  for (unsigned i = 0; i < frames; ++i)
    file.add(i * test::kMs * 10, {0, 0, 1, 0x23, 2, 0, 0, 0, static_cast<std::uint8_t>(i), 8});
  return file.bytes();
}

void expect_same(const ReadBack& is, const ReadBack& as) {
  EXPECT_EQ(is.error, as.error);
  EXPECT_EQ(is.names, as.names);
  EXPECT_EQ(is.left.lines, as.left.lines);
  EXPECT_EQ(is.left.first, as.left.first);
  EXPECT_EQ(is.left.cut, as.left.cut);
  ASSERT_EQ(is.sent.size(), as.sent.size());
  for (std::size_t i = 0; i < is.sent.size(); ++i) {
    EXPECT_EQ(is.sent[i].ns, as.sent[i].ns);
    EXPECT_EQ(is.sent[i].interface, as.sent[i].interface);
    EXPECT_EQ(is.sent[i].data, as.sent[i].data) << i;
  }
}

TEST(Packed, WhatGzipHasPackedIsRead) {
  for (const std::string& text : {log_of(2000), trace_of(500)}) {
    const auto plain = unpack(text);
    EXPECT_GE(plain.sent.size(), 500U);
    const std::string packed = gzip(text);
    EXPECT_LT(packed.size(), text.size());
    expect_same(unpack(packed), plain);
    // Several gzip members, as cat joins them.
    const auto half = text.find('\n', text.size() / 2) + 1;
    expect_same(unpack(gzip(text.substr(0, half)) + gzip(text.substr(half))), plain);
    // The last block of a tape is filled with zeros.
    expect_same(unpack(packed + std::string(512, '\0')), plain);
  }
}

TEST(Packed, PiecesOfAnySizeGiveTheSame) {
  for (const std::string& text :
       {log_of(300), trace_of(100), gzip(log_of(300)), log_of(5) + "hello\n" + log_of(5),
        log_of(3) + "(1.0) can0 123", "(1.0) can0 " + std::string(9000, 'A') + "\n"}) {
    const auto at_once = unpack(text);
    for (const std::size_t size : {1U, 7U, 1000U})
      expect_same(unpack_in_pieces(text, size), at_once);
  }
}

TEST(Packed, OfWhatIsCutOffTheCompletePartIsRead) {
  const std::string packed = gzip(log_of(5000));
  const auto is = unpack(packed.substr(0, packed.size() / 2));
  EXPECT_EQ(is.error, "");
  EXPECT_GT(is.sent.size(), 1000U);
  EXPECT_LT(is.sent.size(), 5000U);
  EXPECT_EQ(is.left.cut, "the file ends within what gzip has packed");
  EXPECT_EQ(is.left.lines, 0U) << is.left.first;
  for (const std::string end : {"(9.0) can0 12", "(9.0) ca", "(9"}) {
    const auto plain = unpack(log_of(10) + end);
    EXPECT_EQ(plain.sent.size(), 10U);
    EXPECT_EQ(plain.left.cut, "the file ends within line 11");
    EXPECT_EQ(plain.left.lines, 0U) << plain.left.first;
  }
  const std::string trace = trace_of(100);
  for (const std::size_t less : {1U, 20U}) {
    const auto cut = unpack(trace.substr(0, trace.size() - less));
    EXPECT_EQ(cut.sent.size(), 99U);
    EXPECT_TRUE(cut.left.cut.starts_with("offset ")) << cut.left.cut;
  }
  const auto nothing = unpack(packed.substr(0, 12));
  EXPECT_EQ(nothing.error, "the file ends within what gzip has packed");
}

TEST(Packed, WhatIsDamagedIsRefused) {
  std::string packed = gzip(log_of(5000));
  for (std::size_t i = 0; i < 40; ++i) packed[packed.size() / 2 + i] = '\xff';
  EXPECT_TRUE(unpack(packed).error.contains("what gzip has packed is damaged at offset"))
      << unpack(packed).error;
  const auto behind = unpack(gzip(log_of(10)) + "and more");
  EXPECT_EQ(behind.sent.size(), 10U);
  EXPECT_TRUE(behind.left.cut.contains("not packed by gzip, as what is before it"))
      << behind.left.cut;
}

TEST(Packed, OtherPackersAreNamedWithWhatToDo) {
  const std::pair<std::string, const char*> cases[] = {
      {std::string("\xfd"
                   "7zXZ\0\1\2",
                   8),
       "xzcat FILE | mlccactl learn -"},
      {"\x28\xb5\x2f\xfd\1\2", "zstdcat FILE"},
      {"BZh91AY", "bzcat FILE"},
      {"PK\3\4\5\6", "unzip -p FILE"},
      {gzip(gzip("(1.0) can0 123#11\n")), "packed by gzip twice"},
      {std::string("\xff\xfe(\0001\0", 6), "iconv -f UTF-16"},
      {"hello\n", "this is no recording that can be read"}};
  for (const auto& [text, says] : cases)
    EXPECT_TRUE(unpack(text).error.contains(says)) << says << ": " << unpack(text).error;
}

TEST(Packed, AByteOrderMarkIsNoPartOfTheFirstLine) {
  for (const std::string& text :
       {log_of(5), " (1.0)  can0  123   [1]  11\n" + std::string(" (1.1)  can0  123   [1]  12\n"),
        std::string("date Wed Apr 20 10:10:10 am 2016\nbase hex  timestamps absolute\n"
                    "   2.501000 1  223             Rx   d 1 01\n")}) {
    EXPECT_FALSE(unpack(text).sent.empty()) << text;
    expect_same(unpack("\xef\xbb\xbf" + text), unpack(text));
    expect_same(unpack(gzip("\xef\xbb\xbf" + text)), unpack(text));
  }
}

TEST(Packed, FramesOfCandumpWithoutTimesAreRefusedWithWhatIsRight) {
  for (const char* text : {"can0 123#1122\ncan0 124#\n", "18FEF100#1122\n"}) {
    const auto is = unpack(text);
    EXPECT_TRUE(is.error.contains("without time stamps: record with candump -l")) << is.error;
  }
}

// --- logs of Vector tools ------------------------------------------------------------------------

TEST(VectorLog, NamesHaveTheIdentifierAtTheEndOfTheLine) {
  const auto is = unpack(
      "\n// version 9.0.0\ndate Wed Apr 20 10:10:10 am 2016\nbase hex  timestamps absolute\n"
      "   2.501000 1  EngineData      Rx   d 2 01 0f  Length = 135910 BitCount = 70 ID = 547\n"
      "   2.502000 1  Engine2         Tx   d 1 01 Length = 1 BitCount = 2 ID = 418119424x\n"
      "   2.503000 1  AB              Rx   d 0 Length = 1 BitCount = 2 ID = 291\n"
      "   2.504000 1  AB              Rx   d 0\n"
      "   2.505000 1  123             Rx   d 0 Length = 1 BitCount = 2 ID = 5\n"
      "   2.506000 CANFD   1 Rx  300  EngineFd  1 0 9 12 01 02 03 04 05 06 07 08 09 0a 0b 0c\n"
      "   2.507000 1  EngineData      TxRq d 2 01 0f  Length = 0 BitCount = 0 ID = 547\n"
      "   2.508000 1  Brake           Rx   r\n"
      "   2.509000 1  J1939TP FEE3p 6   0   0 -  Rx   d 1 01\n");
  ASSERT_EQ(is.error, "");
  ASSERT_EQ(is.sent.size(), 6U);
  EXPECT_EQ(is.sent[0].id, 0x223U);
  EXPECT_EQ(is.sent[0].data, (std::vector<std::uint8_t>{1, 15}));
  EXPECT_EQ(is.sent[1].id, 0x18ebff00U | kExtended);
  EXPECT_TRUE(is.sent[1].local);
  EXPECT_EQ(is.sent[2].id, 0x123U) << "AB is a name here";
  EXPECT_EQ(is.sent[3].id, 0xabU);
  EXPECT_EQ(is.sent[4].id, 0x123U);
  EXPECT_EQ(is.sent[5].data.size(), 12U);
  EXPECT_EQ(is.left.lines, 2U) << "a name alone, and no frame; what was only asked for is none";
  EXPECT_EQ(is.left.first,
            "line 12: the message Brake has a name and no identifier: record identifiers, as "
            "numbers");
}

TEST(VectorLog, NumbersMayBeDecimalAndTimesRelative) {
  const auto is = unpack(
      "date Mit Apr 20 10:10:10 2016\nbase dec  timestamps relative\n"
      "   1.000000 1  547             Rx   d 2 16 255\n"
      "   0.500000 Start of something\n"
      "   0.250000 1  418119424x      Rx   d 1 10\n");
  ASSERT_EQ(is.error, "");
  ASSERT_EQ(is.sent.size(), 2U);
  EXPECT_EQ(is.sent[0].id, 547U);
  EXPECT_EQ(is.sent[0].data, (std::vector<std::uint8_t>{16, 255}));
  EXPECT_EQ(is.sent[1].id, 418119424U | kExtended);
  EXPECT_EQ(is.sent[1].ns, 1'750'000'000U);
}

// --- as a user runs it ---------------------------------------------------------------------------

struct PackedVerb : ::testing::Test {
  Ran shell(const std::string& command) {
    const auto program =
        std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path() / "mlccactl";
    std::string text = command;
    for (std::size_t at = 0; (at = text.find("mlccactl", at)) != std::string::npos;
         at += program.string().size())
      text.replace(at, 8, program.string());
    return run_program({"sh", "-c", "cd " + folder.path("") + " && " + text});
  }
  Folder folder;
};

/// The pipe stays open, as that of a candump that goes on.
TEST_F(PackedVerb, ASignalEndsAPipeAndWhatWasReadIsDrafted) {
  folder.write("a.log", log_of(300));
  const std::string plain = run({"learn", folder.path("a.log")}).out;
  for (const std::string number : {"INT", "TERM", "HUP"}) {
    const std::string text =
        shell(
            "rm -f p; mkfifo p; exec 3<>p; cat a.log >&3; mlccactl learn - <p >out 2>err & "
            "sleep 0.5; kill -" +
            number + " $!; wait $!; echo status $?; cat err out")
            .out;
    EXPECT_TRUE(text.starts_with("status 0\n")) << number << text;
    EXPECT_TRUE(text.ends_with(plain)) << number << text;
  }
}

TEST_F(PackedVerb, AFileAPipeAndStandardInputGiveTheSameDraft) {
  folder.write("a.log", log_of(300));
  folder.write("a.log.gz", gzip(log_of(300)));
  const std::string plain = run({"learn", folder.path("a.log")}).out;
  ASSERT_TRUE(plain.contains("<EventChannel ")) << plain;
  for (const char* command :
       {"mlccactl learn a.log.gz", "mlccactl learn - < a.log", "cat a.log | mlccactl learn -",
        "cat a.log | mlccactl learn /dev/stdin", "cat a.log.gz | mlccactl learn -",
        "mkfifo p && (cat a.log > p & mlccactl learn p)"}) {
    const Ran ran = shell(command);
    EXPECT_EQ(ran.status, 0) << command << ran.out;
    EXPECT_EQ(ran.out, plain) << command;
  }
}

TEST_F(PackedVerb, AnInterfaceIsCalledByTheFileWithoutWhatPackedIt) {
  folder.write("bus-a.pcap.gz", gzip(trace_of(100)));
  EXPECT_TRUE(shell("mlccactl learn bus-a.pcap.gz").out.contains("<Network name=\"bus-a\">"));
  EXPECT_TRUE(
      shell("cat bus-a.pcap.gz | mlccactl learn -").out.contains("<Network name=\"stdin\">"));
}

TEST_F(PackedVerb, StandardInputIsReadOnceAndIsNoTerminalOrDevice) {
  folder.write("a.log", log_of(30));
  EXPECT_TRUE(shell("mlccactl learn - - < a.log").out.contains("- is given twice"));
  EXPECT_TRUE(shell("mlccactl learn - < /dev/zero")
                  .out.contains("standard input: a recording is a regular file or a pipe"));
  EXPECT_TRUE(shell("true | mlccactl learn -").out.contains("standard input: the file is empty"));
  EXPECT_TRUE(shell("mlccactl learn .").out.contains("a recording is a regular file or a pipe"));
}

}  // namespace
}  // namespace mlcca::learn
