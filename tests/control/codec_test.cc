// SPDX-License-Identifier: BSD-2-Clause
// The control protocol on the wire: nothing is lost, nothing is believed.
#include "control/codec.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string_view>

#include "tests/control/messages.hpp"

namespace mlcca::control {
namespace {

/// A buffer that ends where its content ends, so that a sanitizer sees any read after it.
Buffer exactly(std::string_view bytes) {
  Buffer buffer;
  buffer.append(bytes);
  return buffer;
}

std::string varint(std::size_t n) {
  std::string bytes;
  for (; n >= 0x80; n >>= 7U) bytes.push_back(static_cast<char>((n & 0x7fU) | 0x80U));
  bytes.push_back(static_cast<char>(n));
  return bytes;
}

/// The next request, or nothing where there is none or it is wrong.
std::optional<Request> next_request(Buffer& buffer) {
  auto decoded = decode_request(buffer);
  return decoded ? std::move(*decoded) : std::nullopt;
}

std::string framed(const std::string& message) { return varint(message.size()) + message; }

struct CodecRequestTest : ::testing::TestWithParam<test::NamedRequest> {};
struct CodecReplyTest : ::testing::TestWithParam<test::NamedReply> {};

TEST_P(CodecRequestTest, ComesBackAsItWas) {
  auto buffer = exactly(encode(GetParam().request));
  const auto decoded = decode_request(buffer);
  ASSERT_TRUE(decoded) << decoded.error().text;
  ASSERT_TRUE(*decoded);
  EXPECT_EQ(**decoded, GetParam().request);
  EXPECT_EQ(buffer.content(), "");
}

TEST_P(CodecReplyTest, ComesBackAsItWas) {
  auto buffer = exactly(encode(GetParam().reply));
  const auto decoded = decode_reply(buffer);
  ASSERT_TRUE(decoded) << decoded.error().text;
  ASSERT_TRUE(*decoded);
  EXPECT_EQ(**decoded, GetParam().reply);
  EXPECT_EQ(buffer.content(), "");
}

TEST_P(CodecRequestTest, WaitsForTheRestWhereverItIsCut) {
  const auto bytes = encode(GetParam().request);
  for (std::size_t cut = 0; cut < bytes.size(); ++cut) {
    auto buffer = exactly(std::string_view(bytes).substr(0, cut));
    const auto partial = decode_request(buffer);
    ASSERT_TRUE(partial) << "cut at " << cut << ": " << partial.error().text;
    ASSERT_FALSE(*partial) << "cut at " << cut;
    buffer.append(std::string_view(bytes).substr(cut));
    const auto whole = decode_request(buffer);
    ASSERT_TRUE(whole && *whole) << "cut at " << cut;
    EXPECT_EQ(**whole, GetParam().request);
  }
}

TEST_P(CodecReplyTest, WaitsForTheRestWhereverItIsCut) {
  const auto bytes = encode(GetParam().reply);
  for (std::size_t cut = 0; cut < bytes.size(); ++cut) {
    auto buffer = exactly(std::string_view(bytes).substr(0, cut));
    const auto partial = decode_reply(buffer);
    ASSERT_TRUE(partial) << "cut at " << cut << ": " << partial.error().text;
    ASSERT_FALSE(*partial) << "cut at " << cut;
  }
}

/// A message that ends early although its length says that it is whole.
TEST_P(CodecReplyTest, NeverReadsPastTheEndOfAMessageThatWasCutShort) {
  const auto whole = encode(GetParam().reply);
  const auto message = whole.substr(varint(whole.size() - 1).size());
  for (std::size_t cut = 0; cut < message.size(); ++cut) {
    auto buffer = exactly(framed(message.substr(0, cut)));
    const auto decoded = decode_reply(buffer);
    EXPECT_TRUE(!decoded || *decoded);
  }
}

TEST_P(CodecRequestTest, SurvivesEveryFlippedBit) {
  const auto bytes = encode(GetParam().request);
  for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    auto changed = bytes;
    changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ (1 << bit % 8));
    auto buffer = exactly(changed);
    while (true) {
      const auto decoded = decode_request(buffer);
      if (!decoded || !*decoded) break;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, CodecRequestTest, ::testing::ValuesIn(test::all_requests()),
                         [](const auto& row) { return row.param.name; });
INSTANTIATE_TEST_SUITE_P(All, CodecReplyTest, ::testing::ValuesIn(test::all_replies()),
                         [](const auto& row) { return row.param.name; });

TEST(CodecTest, WritesWhatEveryProtobufRuntimeWrites) {
  EXPECT_EQ(encode(Request{1, StatusRequest{}}), std::string("\x04\x08\x01\x12\x00", 5));
  EXPECT_EQ(encode(Reply{300, Done{"ok"}}), "\x09\x08\xac\x02\x32\x04\x0a\x02ok");
}

TEST(CodecTest, TakesMessagesOffOneByOne) {
  auto buffer = exactly(encode(Request{1, StatusRequest{}}) + encode(Request{2, ReloadRequest{}}) +
                        encode(Request{3, MonitorRequest{}}).substr(0, 2));
  EXPECT_EQ(next_request(buffer), (Request{1, StatusRequest{}}));
  EXPECT_EQ(next_request(buffer), (Request{2, ReloadRequest{}}));
  EXPECT_EQ(next_request(buffer), std::nullopt);
  EXPECT_EQ(buffer.content().size(), 2U);
}

/// An Explain whose message has `size` bytes: 1 id, tag and length of Explain, of its text.
Request request_of(std::size_t size) {
  for (std::size_t text = size - 16;; ++text) {
    Request request{1, ExplainRequest{std::string(text, 'a')}};
    const auto bytes = encode(request).size();
    if (bytes - varint(size).size() == size) return request;
  }
}

TEST(CodecTest, TakesTheLargestRequestAndNoLarger) {
  auto largest = exactly(encode(request_of(Request::kMaxBytes)));
  const auto decoded = decode_request(largest);
  ASSERT_TRUE(decoded) << decoded.error().text;
  EXPECT_TRUE(*decoded);

  auto larger = exactly(encode(request_of(Request::kMaxBytes + 1)));
  const auto refused = decode_request(larger);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().text, "message too large: 65537 bytes, at most 65536");
}

TEST(CodecTest, RefusesALargeRequestBeforeItArrives) {
  auto buffer = exactly(varint(Request::kMaxBytes + 1));
  EXPECT_FALSE(decode_request(buffer));
  auto endless = exactly("\xff\xff\xff\xff");
  EXPECT_FALSE(decode_request(endless));
}

TEST(CodecTest, TakesTheLargestReplyAndTurnsALargerOneIntoAnError) {
  const auto overhead = encode(Reply{7, Done{std::string(Reply::kMaxBytes - 100, 'a')}}).size() -
                        (Reply::kMaxBytes - 100) - varint(Reply::kMaxBytes).size();
  const Reply largest{7, Done{std::string(Reply::kMaxBytes - overhead, 'a')}};
  auto buffer = exactly(encode(largest));
  const auto decoded = decode_reply(buffer);
  ASSERT_TRUE(decoded) << decoded.error().text;
  EXPECT_TRUE(*decoded == largest);

  const Reply larger{7, Done{std::string(Reply::kMaxBytes - overhead + 1, 'a')}};
  buffer = exactly(encode(larger));
  const auto error = decode_reply(buffer);
  ASSERT_TRUE(error && *error);
  EXPECT_EQ((*error)->id, 7U);
  ASSERT_TRUE(std::holds_alternative<Error>((*error)->body));
  EXPECT_NE(std::get<Error>((*error)->body).message.find("16777217 bytes"), std::string::npos);
}

TEST(CodecTest, RefusesALargerReplyThanTheLargest) {
  auto buffer = exactly(varint(Reply::kMaxBytes + 1));
  const auto refused = decode_reply(buffer);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().text, "message too large: 16777217 bytes, at most 16777216");
}

TEST(CodecTest, SaysThatARequestIsUnknown) {
  for (const auto* message : {"", "\x08\x05", "\x08\x05\x9a\x06\x02hi"}) {
    auto buffer = exactly(framed(message));
    const auto decoded = decode_request(buffer);
    ASSERT_FALSE(decoded);
    EXPECT_TRUE(decoded.error().text.starts_with("unknown request")) << decoded.error().text;
  }
}

TEST(CodecTest, SaysThatAReplyIsUnknown) {
  auto buffer = exactly(framed("\x08\x05\x9a\x06\x02hi"));
  const auto decoded = decode_reply(buffer);
  ASSERT_FALSE(decoded);
  EXPECT_TRUE(decoded.error().text.starts_with("unknown reply")) << decoded.error().text;
}

TEST(CodecTest, IgnoresFieldsOfANewerPeer) {
  auto buffer = exactly(framed("\x08\x05\x1a\x04\x9a\x06\x01x"));
  EXPECT_EQ(next_request(buffer), (Request{5, NetworksRequest{}}));
}

TEST(CodecTest, AnOutcomeThatIsNotStatedIsUnfit) {
  Row row;
  row.outcome = Outcome::unfit;
  // channels { channels { rows { } } }, and the same with an outcome of a newer daemon
  for (const auto& message : {std::string("\x2a\x04\x0a\x02\x5a\x00", 6),
                              std::string("\x2a\x06\x0a\x04\x5a\x02\x40\x63", 8)}) {
    auto buffer = exactly(framed(message));
    const auto decoded = decode_reply(buffer);
    ASSERT_TRUE(decoded && *decoded);
    const auto& channel = std::get<Channels>((*decoded)->body).channels.at(0);
    EXPECT_FALSE(channel.granted);
    EXPECT_EQ(channel.rows.at(0), row);
  }
}

/// Bytes by hand, as another runtime would write them from control.proto.
TEST(CodecTest, ReadsTheNumbersOfTheFieldsAsTheyArePublished) {
  // id 5; what_if { links { from: "a" to: "b" rate: 6 one_way: true } without: "g" }
  auto what_if =
      exactly(framed("\x08\x05\x7a\x0f\x0a\x0a\x12\x01"
                     "a\x1a\x01"
                     "b\x20\x06\x28\x01\x12\x01g"));
  EXPECT_EQ(
      next_request(what_if),
      (Request{5,
               WhatIfRequest{
                   .links = {{.network = "", .from = "a", .to = "b", .rate = 6, .one_way = true}},
                   .without = {"g"}}}));
  // id 5; admit { channel: "c" key: "k" lease_ns: 7 hold: true }
  auto admit =
      exactly(framed("\x08\x05\x32\x0a\x0a\x01"
                     "c\x5a\x01k\x60\x07\x68\x01"));
  Admit expected;
  expected.channel = "c";
  expected.key = "k";
  expected.lease_ns = 7;
  expected.hold = true;
  EXPECT_EQ(next_request(admit), (Request{5, expected}));
  // id 5; renew { admission: 3 }
  auto renew = exactly(framed("\x08\x05\x62\x02\x08\x03"));
  EXPECT_EQ(next_request(renew), (Request{5, RenewRequest{.admission = 3, .key = ""}}));
}

TEST(CodecTest, AChannelOfAnOlderDaemonHasOneSet) {
  // channels { channels { } }
  auto buffer = exactly(framed(std::string("\x2a\x02\x0a\x00", 4)));
  const auto decoded = decode_reply(buffer);
  ASSERT_TRUE(decoded && *decoded);
  EXPECT_EQ(std::get<Channels>((*decoded)->body), Channels{{Channel{}}});
  EXPECT_EQ(Channel{}.sets, 1U);
}

TEST(CodecTest, AChannelThatSaysItHasNoSetHasOne) {
  // channels { channels { sets: 0 } }
  auto buffer = exactly(framed(std::string("\x2a\x05\x0a\x03\x88\x01\x00", 7)));
  const auto decoded = decode_reply(buffer);
  ASSERT_TRUE(decoded && *decoded);
  EXPECT_EQ(std::get<Channels>((*decoded)->body), Channels{{Channel{}}});
}

TEST(CodecTest, AReplyThatWasEncodedElsewhereGetsItsId) {
  for (const test::NamedReply& named : test::all_replies())
    for (const std::uint64_t id : {0UL, 1UL, 127UL, 128UL, ~0UL}) {
      Reply reply = named.reply;
      const std::string body = encode_body(reply);
      reply.id = id;
      auto buffer = exactly(with_id(id, body));
      const auto decoded = decode_reply(buffer);
      ASSERT_TRUE(decoded && *decoded) << named.name;
      EXPECT_EQ(**decoded, reply) << named.name;
      EXPECT_TRUE(buffer.content().empty()) << named.name;
    }
}

TEST(CodecTest, ABodyThatIsTooLargeIsAnErrorThatSaysSo) {
  auto buffer = exactly(with_id(7, encode_body(Reply{0, Done{std::string(2000, 'x')}}, 1000)));
  const auto decoded = decode_reply(buffer);
  ASSERT_TRUE(decoded && *decoded);
  EXPECT_EQ((*decoded)->id, 7U);
  EXPECT_EQ(std::get<Error>((*decoded)->body).message,
            "the reply would have 2006 bytes, at most 1000 are possible; ask for less");
}

TEST(CodecTest, ReplacesWhatIsNotUtf8) {
  auto status = test::full_status();
  status.interfaces[0].identity = "alias \xff\xfe";
  auto buffer = exactly(encode(Reply{1, status}));
  const auto decoded = decode_reply(buffer);
  ASSERT_TRUE(decoded) << decoded.error().text;
  EXPECT_EQ(std::get<Status>((*decoded)->body).interfaces[0].identity, "alias \ufffd\ufffd");
}

TEST(CodecTest, SurvivesGarbage) {
  std::mt19937 random(20261121);
  std::uniform_int_distribution<int> byte(0, 255);
  std::uniform_int_distribution<std::size_t> length(0, 60);
  for (int i = 0; i < 20000; ++i) {
    std::string message(length(random), '\0');
    std::ranges::generate(message, [&] { return static_cast<char>(byte(random)); });
    auto as_message = exactly(framed(message));
    static_cast<void>(decode_request(as_message));
    auto as_reply = exactly(framed(message));
    static_cast<void>(decode_reply(as_reply));
    auto as_stream = exactly(message);
    static_cast<void>(decode_request(as_stream));
  }
}

TEST(CodecTest, SaysNothingOnStandardErrorAboutMalformedMessages) {
  ::testing::internal::CaptureStderr();
  auto buffer = exactly(framed("\x42\x03\x0a\x01\xff"));  // explain { channel: not UTF-8 }
  const auto decoded = decode_request(buffer);
  EXPECT_FALSE(decoded);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace mlcca::control
