// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/recording.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <span>
#include <string_view>

#include "tests/tools/design/describe/program.hpp"
#include "tests/tools/learn/read_back.hpp"
#include "tests/tools/learn/traffic.hpp"
#include "tools/learn/input.hpp"

namespace mlcca::learn {
namespace {

using test::ReadBack;
using test::Sent;

ReadBack read(const std::string& text, const std::string& name = "can0.log") {
  const mlcca::test::Folder folder;
  const auto path = folder.write(name, text);
  return test::read_back([&](Interfaces& interfaces, const auto& take) {
    return read_recording(path, interfaces, take);
  });
}

std::string little(std::uint64_t value, unsigned bytes) {
  std::string out;
  for (unsigned i = 0; i < bytes; ++i) out += static_cast<char>(value >> 8 * i & 0xff);
  return out;
}
std::string big(std::uint64_t value, unsigned bytes) {
  std::string out;
  for (unsigned i = bytes; i-- > 0;) out += static_cast<char>(value >> 8 * i & 0xff);
  return out;
}
std::string socketcan(std::uint32_t id, const std::string& data, bool fd = false) {
  return big(id, 4) + static_cast<char>(data.size()) + std::string(1, fd ? '\4' : '\0') +
         std::string(2, '\0') + data;
}

TEST(Recording, ReadsALogOfCandump) {
  const auto is = read(
      "(1436509052.249713) can0 123#1122\n"
      "(1436509052.249714) vcan1 18FEF100#\n"
      "(1436509052.250) can0 123##1AABB\r\n"
      "(1436509053.000001) can0 7FF#R8\n"
      "(1436509054.000001) can0 20000080#0000000000000000\n"
      "(1436509055.000001) can0 001#01 T\n");
  ASSERT_EQ(is.error, "");
  EXPECT_EQ(is.names, (std::vector<std::string>{"can0", "vcan1"}));
  ASSERT_EQ(is.sent.size(), 5U) << "an error frame is none";
  EXPECT_EQ(is.sent[0].ns, 1'436'509'052'249'713'000U);
  EXPECT_EQ(is.sent[0].id, 0x123U);
  EXPECT_EQ(is.sent[0].data, (std::vector<std::uint8_t>{0x11, 0x22}));
  EXPECT_EQ(is.sent[1].id, 0x18fef100U | kExtended);
  EXPECT_EQ(is.sent[1].interface, 1U);
  EXPECT_TRUE(is.sent[2].fd);
  EXPECT_EQ(is.sent[2].data, (std::vector<std::uint8_t>{0xaa, 0xbb}));
  EXPECT_EQ(is.sent[3].id, 0x7ffU | kRemote);
  EXPECT_TRUE(is.sent[4].local);
  EXPECT_EQ(is.left.lines, 0U);
  EXPECT_EQ(is.left.errors, 1U);
}

TEST(Recording, SaysWhichLinesAreNoFrames) {
  const auto is = read(
      "(1.0) can0 123#11\n(1.1) can0 12#11\n(1.2) can0 123#1\n(x) can0 123#11\n"
      "(1.3) can0 123#112233445566778899\n(1.4) can0 FFF#\n");
  EXPECT_EQ(is.sent.size(), 1U);
  EXPECT_EQ(is.left.lines, 5U);
  EXPECT_TRUE(is.left.first.starts_with("line 2: '(1.1) can0 12#11' is no frame")) << is.left.first;
}

TEST(Recording, PassesOverLinesThatAreTooLong) {
  const std::string asc = "date Wed Apr 20 10:10:10 am 2016\nbase hex  timestamps absolute\n";
  struct Case {
    std::string head, first, second;
  };
  const Case cases[] = {
      {"", "(1.0) can0 123#11\n", "(2.0) can0 123#22\n"},
      {"", "(1.0)  can0  123   [1]  11\n", "(2.0)  can0  123   [1]  22\n"},
      {asc, "   1.0 1  123             Rx   d 1 11\n", "   2.0 1  123             Rx   d 1 22\n"}};
  for (const auto& [head, first, second] : cases)
    for (const std::size_t size : {4097U, 100'000U, 1'000'000U, 3'000'000U}) {
      const std::string text = head + first + std::string(size, 'x') + "\r\n" + second;
      const auto whole = read(text);
      const auto pieces = test::read_back([&](Interfaces& interfaces, const auto& take) {
        std::string_view left = text;
        Input input([&](std::span<std::uint8_t> to) -> Result<std::size_t> {
          const std::size_t count = std::min({std::size_t{61}, to.size(), left.size()});
          std::copy_n(left.begin(), count, to.begin());
          left.remove_prefix(count);
          return count;
        });
        return read_recording(input, "can0", interfaces, take);
      });
      for (const auto& is : {whole, pieces}) {
        ASSERT_EQ(is.error, "") << size;
        ASSERT_EQ(is.sent.size(), 2U) << size << head;
        EXPECT_EQ(is.sent[1].data, (std::vector<std::uint8_t>{0x22}));
        EXPECT_EQ(is.left.lines, 1U);
        EXPECT_TRUE(is.left.first.contains("has more than 4096 characters")) << is.left.first;
        EXPECT_EQ(is.left.cut, "");
      }
    }
}

TEST(Recording, ALongLineAtTheEndIsCutOff) {
  const auto is = read("(1.0) can0 123#11\n(1.0) can0 " + std::string(5000, 'A'));
  EXPECT_EQ(is.sent.size(), 1U);
  EXPECT_EQ(is.left.cut, "the file ends within line 2");
}

TEST(Recording, ReadsPcapOfBothOrdersAndResolutions) {
  for (const bool is_big : {false, true})
    for (const bool ns : {false, true}) {
      const auto put = [&](std::uint64_t v, unsigned n) {
        return is_big ? big(v, n) : little(v, n);
      };
      const auto packet = socketcan(0x123, "ab");
      const auto is = read(put(ns ? 0xa1b23c4d : 0xa1b2c3d4, 4) + put(2, 2) + put(4, 2) +
                               std::string(8, '\0') + put(65535, 4) + put(227, 4) + put(7, 4) +
                               put(5, 4) + put(packet.size(), 4) + put(packet.size(), 4) + packet,
                           "bus-a.pcap");
      ASSERT_EQ(is.error, "");
      ASSERT_EQ(is.sent.size(), 1U);
      EXPECT_EQ(is.sent[0].ns, 7'000'000'000U + (ns ? 5 : 5'000));
      EXPECT_EQ(is.sent[0].id, 0x123U);
      EXPECT_EQ(is.names, std::vector<std::string>{"bus-a"});
    }
}

/// A block of pcapng.
std::string block(std::uint32_t type, std::string body) {
  body.resize((body.size() + 3) / 4 * 4);
  const auto size = little(body.size() + 12, 4);
  return little(type, 4) + size + body + size;
}
/// The block with which a section of pcapng begins.
std::string section() {
  return block(0x0a0d0d0a,
               little(0x1a2b3c4d, 4) + little(1, 2) + little(0, 2) + std::string(8, '\xff'));
}

TEST(Recording, ReadsPcapngWithTheNamesOfItsInterfaces) {
  const auto packet = socketcan(0x98fef100, "12345678");
  const auto is = read(
      section() +
      block(1, little(227, 2) + little(0, 2) + little(0, 4) + little(2, 2) + little(4, 2) + "can7" +
                   little(9, 2) + little(1, 2) + std::string("\x09\0\0\0", 4) + little(0, 4)) +
      block(6, little(0, 4) + little(1, 4) + little(2, 4) + little(packet.size(), 4) +
                   little(packet.size(), 4) + packet) +
      block(6, little(5, 4) + little(1, 4) + little(2, 4) + little(0, 4) + little(0, 4)));
  ASSERT_EQ(is.error, "");
  EXPECT_EQ(is.names, std::vector<std::string>{"can7"});
  ASSERT_EQ(is.sent.size(), 1U);
  EXPECT_EQ(is.sent[0].ns, (std::uint64_t{1} << 32U) + 2);
  EXPECT_EQ(is.sent[0].data.size(), 8U);
  EXPECT_EQ(is.left.lines, 1U) << "of an interface that is not described";
}

TEST(Recording, OfPcapngSaysWhichLinkTypesItReads) {
  // Wireshark exports packets of upper layers with link type 252.
  const auto is = read(
      section() + block(1, little(252, 2) + little(0, 2) + little(0, 4)) +
      block(6, little(0, 4) + little(1, 4) + little(2, 4) + little(4, 4) + little(4, 4) + "1234"));
  ASSERT_EQ(is.error, "");
  EXPECT_TRUE(is.sent.empty());
  EXPECT_EQ(is.left.lines, 1U);
  EXPECT_TRUE(is.left.first.contains(
      "link type 252 has neither frames of CAN nor of Ethernet: record a CAN interface "
      "(SocketCAN, 227), an Ethernet interface (1) or any (113, 276)"))
      << is.left.first;
}

TEST(Recording, OfPcapngSaysWhichBlocksOfPacketsItDoesNotRead) {
  for (const std::uint32_t type : {2, 3}) {
    const auto is = read(section() + block(1, little(227, 2) + little(0, 2) + little(0, 4)) +
                         block(type, std::string(32, '\0')));
    ASSERT_EQ(is.error, "");
    EXPECT_EQ(is.left.lines, 1U);
    EXPECT_TRUE(is.left.first.contains("a block of type " + std::to_string(type) +
                                       ", whose packets are not read"))
        << is.left.first;
  }
}

TEST(Recording, ReadsLogsOfVectorInText) {
  const auto is = read(
      "date Wed Apr 20 10:10:10 am 2016\nbase hex  timestamps absolute\n"
      "internal events logged\n"
      "   0.000000 Start of measurement\n"
      "   2.501000 1  223             Rx   d 4 01 02 03 a4\n"
      "   2.502000 2  18EBFF00x       Tx   d 2 01 A0\n"
      "   2.503000 1  100             Rx   r\n"
      "   2.504000 CANFD   2 Rx  300                                  1 0 9 12 01 02 03 04 05 06 "
      "07 08 09 0a 0b 0c\n"
      "   2.505000 1  ErrorFrame\n",
      "x.asc");
  ASSERT_EQ(is.error, "");
  EXPECT_EQ(is.names, (std::vector<std::string>{"can1", "can2"}));
  ASSERT_EQ(is.sent.size(), 4U);
  EXPECT_EQ(is.sent[0].ns, 2'501'000'000U);
  EXPECT_EQ(is.sent[0].data.back(), 0xa4);
  EXPECT_EQ(is.sent[1].id, 0x18ebff00U | kExtended);
  EXPECT_TRUE(is.sent[1].local);
  EXPECT_EQ(is.sent[2].id, 0x100U | kRemote);
  EXPECT_TRUE(is.sent[3].fd);
  EXPECT_EQ(is.sent[3].data.size(), 12U);
  EXPECT_EQ(is.left.errors, 1U);
}

/// As programs write it in countries where a number has a comma.
TEST(Recording, ReadsTimesWithACommaInLogsOfVectorInText) {
  const auto is = read(
      "date Mit Apr 20 10:10:10 2016\nbase hex  timestamps absolute\nno internal events logged\n"
      "Begin Triggerblock Mit Apr 20 10:10:10 2016\n"
      "   0,000000 Start of measurement\n"
      "   2,501000 1  223             Rx   d 1 01\n"
      "End TriggerBlock\n",
      "x.asc");
  ASSERT_EQ(is.error, "");
  ASSERT_EQ(is.sent.size(), 1U);
  EXPECT_EQ(is.sent[0].ns, 2'501'000'000U);
  EXPECT_EQ(is.left.lines, 0U) << is.left.first;
}

TEST(Recording, CountsLinesThatAreNeitherEventsNorOfAHeaderInLogsOfVectorInText) {
  const auto is = read(
      "date Wed Apr 20 10:10:10 am 2016\nbase hex  timestamps absolute\n// version 9.0.0\n"
      "previous log file: x.asc\n"
      "   2:501 1  223             Rx   d 1 01\n"
      "?  2.501000 1  223             Rx   d 1 01\n"
      "   2.501000 1  223             Rx   d 1 01\n",
      "x.asc");
  ASSERT_EQ(is.error, "");
  EXPECT_EQ(is.sent.size(), 1U);
  EXPECT_EQ(is.left.lines, 2U);
  EXPECT_TRUE(is.left.first.starts_with("line 5: '   2:501 1")) << is.left.first;
}

/// The interfaces of several recordings, in the order in which they are read.
Interfaces interfaces_of(const std::vector<std::string>& texts) {
  Interfaces out;
  for (const std::string& text : texts) {
    Input input(Bytes{reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});  // NOLINT
    EXPECT_TRUE(read_recording(input, "x", out, [](const Frame&) {}));
  }
  return out;
}

TEST(Recording, AMadeUpNameIsNotThatOfAnotherInterface) {
  const std::string asc = "base hex  timestamps absolute\n 2.5 1  223  Rx   d 1 01\n";
  const std::string log = "(1.0) can1 123#11\n";
  EXPECT_EQ(interfaces_of({asc}).names(), (std::vector<std::string>{"can1"}));
  EXPECT_EQ(interfaces_of({log, asc}).names(), (std::vector<std::string>{"can1", "can1-2"}));
  EXPECT_EQ(interfaces_of({asc, log}).names(), (std::vector<std::string>{"can1-2", "can1"}));
  EXPECT_EQ(interfaces_of({asc, asc}).names(), (std::vector<std::string>{"can1", "can1-2"}));
  const Interfaces all = interfaces_of({asc, log, asc});
  EXPECT_EQ(all.names(), (std::vector<std::string>{"can1-2", "can1", "can1-3"}));
  EXPECT_EQ(all.made_up().size(), 2U);
  EXPECT_EQ(all.made_up().at("can1-3").wanted, "can1");
}

TEST(Recording, AMadeUpNameIsNoLongerThanThatOfAnInterface) {
  Interfaces all;
  all.reserve("a-long-name-can");
  EXPECT_EQ(all.number_of_made_up("a-long-name-can"), 0U);
  EXPECT_EQ(all.number_of_made_up("a-long-name-can"), 0U);
  EXPECT_EQ(all.names(), (std::vector<std::string>{"a-long-name-c-2"}));
}

std::string blf_object(std::uint32_t type, const std::string& body, std::uint64_t time = 0) {
  return "LOBJ" + little(32, 2) + little(1, 2) + little(32 + body.size(), 4) + little(type, 4) +
         little(2, 4) + little(0, 4) + little(time, 8) + body;
}
std::string blf_of(const std::vector<std::string>& containers, bool compressed) {
  std::string out = "LOGG" + little(144, 4) + std::string(136, '\0');
  for (const std::string& inner : containers) {
    std::string packed = inner;
    if (compressed) {
      uLongf size = ::compressBound(inner.size());
      packed.resize(size);
      ::compress(reinterpret_cast<Bytef*>(packed.data()), &size,
                 reinterpret_cast<const Bytef*>(inner.data()), inner.size());
      packed.resize(size);
    }
    const auto size = 32 + packed.size();
    out += "LOBJ" + little(16, 2) + little(1, 2) + little(size, 4) + little(10, 4) +
           little(compressed ? 2 : 0, 2) + std::string(6, '\0') + little(inner.size(), 4) +
           std::string(4, '\0') + packed + std::string(size % 4, '\0');
  }
  return out;
}

TEST(Recording, ReadsLogsOfVectorInBinaryAlsoOverTheEndsOfContainers) {
  const std::string first = blf_object(
      1, little(1, 2) + std::string("\0\2", 2) + little(0x123, 4) + "ab\0\0\0\0\0\0", 42);
  const std::string second =
      blf_object(86, little(2, 2) + std::string("\1\1", 2) + little(0x80000123, 4) +
                         std::string("c\0\0\0\0\0\0\0", 8));
  const std::string all = first + second;
  for (const bool compressed : {false, true}) {
    const auto is = read(blf_of({all.substr(0, 60), all.substr(60)}, compressed), "x.blf");
    ASSERT_EQ(is.error, "");
    ASSERT_EQ(is.sent.size(), 2U);
    EXPECT_EQ(is.sent[0].id, 0x123U);
    EXPECT_EQ(is.sent[0].ns, 42U);
    EXPECT_EQ(is.sent[0].data, (std::vector<std::uint8_t>{'a', 'b'}));
    EXPECT_EQ(is.sent[1].id, 0x123U | kExtended);
    EXPECT_TRUE(is.sent[1].local);
    EXPECT_EQ(is.names, (std::vector<std::string>{"can1", "can2"}));
  }
}

TEST(Recording, OfALogInBinaryThatIsCutOffWhatIsCompleteIsRead) {
  std::string all;
  for (std::size_t i = 0; i < 400; ++i)
    all += blf_object(1,
                      little(1, 2) + std::string("\0\2", 2) + little(0x100 + i, 4) +
                          little(i * 0x9e3779b97f4a7c15, 8),
                      i);
  for (const bool compressed : {false, true}) {
    const std::string whole = blf_of({all, all}, compressed);
    // Cut within the second container, and within the only one.
    const auto later = read(whole.substr(0, whole.size() - 500), "x.blf");
    EXPECT_EQ(later.error, "");
    EXPECT_GT(later.sent.size(), 500U);
    EXPECT_LT(later.sent.size(), 800U);
    EXPECT_TRUE(later.left.cut.contains("the file ends within an object of")) << later.left.cut;
    EXPECT_EQ(later.left.lines, 0U);
    const std::string one = blf_of({all}, compressed);
    const auto first = read(one.substr(0, one.size() / 2), "x.blf");
    EXPECT_EQ(first.error, "");
    EXPECT_GT(first.sent.size(), 50U);
    EXPECT_LT(first.sent.size(), 400U);
    EXPECT_NE(read(whole.substr(0, 170), "x.blf").error, "") << "there is no frame in it";
  }
}

TEST(Recording, SaysWhatIsWrongWithAFile) {
  EXPECT_TRUE(read("hello\n").error.contains("this is no recording that can be read"));
  EXPECT_TRUE(read("").error.contains("the file is empty"));
  EXPECT_TRUE(
      read(big(0xa1b2c3d4, 4) + std::string(10, '\0')).error.contains("ends within its header"));
  EXPECT_TRUE(read(big(0xa1b2c3d4, 4) + std::string(16, '\0') + big(6, 4))
                  .error.contains("link type 6 has neither frames of CAN nor of Ethernet"));
  EXPECT_TRUE(read("LOGG" + little(144, 4) + std::string(136, '\0') + std::string(20, 'x'))
                  .error.contains("offset 144: no object begins here"));
  Interfaces none;
  EXPECT_TRUE(read_recording("/nowhere/x.log", none, [](const Frame&) {})
                  .error()
                  .text.contains("/nowhere/x.log: No such file"));
}

TEST(Recording, OfMoreInterfacesThanThereMayBeTheOthersAreCounted) {
  std::string text;
  for (std::size_t i = 0; i < Interfaces::kMost + 5; ++i)
    text += "(1.0) can" + std::to_string(i) + " 123#11\n";
  const auto is = read(text);
  EXPECT_EQ(is.sent.size(), Interfaces::kMost);
  EXPECT_EQ(is.left.interfaces, 5U);
}

}  // namespace
}  // namespace mlcca::learn
