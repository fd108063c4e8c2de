// SPDX-License-Identifier: BSD-2-Clause
#include "cluster/grpc.hpp"

#include <gtest/gtest.h>

#include <string>

#include "cluster/outcome.hpp"

namespace mlcca::cluster {
namespace {

using core::cluster::Outcome;

TEST(ClusterGrpc, MessagesComeOutAsTheyWentIn) {
  const std::string long_one(70'000, 'x');
  const std::string all = grpc::framed("a") + grpc::framed("") + grpc::framed(long_one);
  for (const std::size_t piece : {std::size_t{1}, std::size_t{7}, all.size()}) {
    grpc::FrameReader reader(100'000);
    std::string read;
    std::size_t count = 0;
    for (std::size_t at = 0; at < all.size(); at += piece) {
      ASSERT_TRUE(reader.push(std::string_view(all).substr(at, piece)));
      while (const auto message = reader.next()) {
        read += *message;
        ++count;
      }
    }
    EXPECT_EQ(count, 3U);
    EXPECT_EQ(read, "a" + long_one);
    EXPECT_TRUE(reader.at_end());
  }
}

TEST(ClusterGrpc, ALengthAboveTheBoundIsRefusedBeforeItsContentComes) {
  grpc::FrameReader reader(10);
  EXPECT_TRUE(reader.push(grpc::framed("0123456789")));
  EXPECT_FALSE(reader.push(std::string_view("\0\0\0\0\x0b", 5)));
  EXPECT_TRUE(reader.too_long());
  EXPECT_EQ(reader.next(), "0123456789");
  EXPECT_FALSE(reader.next().has_value());
  EXPECT_FALSE(reader.push("x")) << "it stays broken";
  grpc::FrameReader largest(10);
  EXPECT_FALSE(largest.push(std::string_view("\0\xff\xff\xff\xff", 5)));
}

TEST(ClusterGrpc, ACompressedMessageIsRefused) {
  grpc::FrameReader reader(10);
  EXPECT_FALSE(reader.push(std::string_view("\1\0\0\0\0", 5)));
  EXPECT_FALSE(reader.too_long());
}

TEST(ClusterGrpc, WhatIsCutOffIsNotAtItsEnd) {
  grpc::FrameReader reader(10);
  EXPECT_TRUE(reader.push(std::string_view("\0\0\0\0\2a", 6)));
  EXPECT_FALSE(reader.next().has_value());
  EXPECT_FALSE(reader.at_end());
}

TEST(ClusterGrpc, TrailersSayStatusAndWords) {
  grpc::Trailers trailers;
  EXPECT_TRUE(trailers.take("HTTP/2 200 \r\n"));
  EXPECT_TRUE(trailers.take("Content-Type: application/grpc\r\n"));
  EXPECT_FALSE(trailers.status().has_value());
  EXPECT_TRUE(trailers.take("Grpc-Status: 7\r\n"));
  EXPECT_TRUE(trailers.take("grpc-message: etcdserver: permission%20denied%0a%\r\n"));
  EXPECT_EQ(trailers.status(), 7);
  EXPECT_EQ(trailers.message(), "etcdserver: permission denied?%");
  EXPECT_TRUE(trailers.take("grpc-status: none\r\n"));
  EXPECT_FALSE(trailers.status().has_value());
}

TEST(ClusterGrpc, WhoDoesNotSpeakGrpcOrGoesOnWithoutEndIsRefused) {
  EXPECT_FALSE(grpc::Trailers().take("HTTP/1.1 200 OK\r\n"));
  EXPECT_FALSE(grpc::Trailers().take("HTTP/2 404 \r\n"));
  grpc::Trailers trailers;
  int lines = 0;
  while (trailers.take("x: " + std::string(1000, 'x')) && lines < 1000) ++lines;
  EXPECT_LT(lines, 100);
  EXPECT_NE(trailers.problem(), "");
}

Outcome outcome(int status, const char* words, bool sent = true) {
  return outcome_of({.status = status, .text = words, .sent = sent});
}

TEST(ClusterOutcome, WhatIsNotSurelyNotCarriedOutIsUnsure) {
  EXPECT_EQ(outcome(End::kNoStatus, "connection refused", false), Outcome::unavailable);
  EXPECT_EQ(outcome(End::kNoStatus, "timeout"), Outcome::unsure);
  EXPECT_EQ(outcome(grpc::kUnavailable, "etcdserver: no leader"), Outcome::unavailable);
  EXPECT_EQ(outcome(grpc::kUnavailable, "etcdserver: request timed out"), Outcome::unsure);
  EXPECT_EQ(outcome(2, "unknown"), Outcome::unsure);
  EXPECT_EQ(outcome(grpc::kOk, ""), Outcome::unsure) << "an answer that is not understood";
}

TEST(ClusterOutcome, RefusalsSayWhatIsRefused) {
  EXPECT_EQ(outcome(grpc::kResourceExhausted, "etcdserver: mvcc: database space exceeded"),
            Outcome::full);
  EXPECT_EQ(outcome(grpc::kResourceExhausted, "etcdserver: too many requests"),
            Outcome::unavailable);
  EXPECT_EQ(outcome(grpc::kResourceExhausted, "grpc: received message larger than max"),
            Outcome::invalid);
  EXPECT_EQ(outcome(grpc::kInvalidArgument, "etcdserver: duplicate key given in txn request"),
            Outcome::invalid);
  EXPECT_EQ(outcome(grpc::kInvalidArgument, "etcdserver: revision of auth store is old"),
            Outcome::stale_auth);
  EXPECT_EQ(outcome(grpc::kPermissionDenied, "etcdserver: permission denied"), Outcome::forbidden);
  EXPECT_EQ(outcome(grpc::kUnauthenticated, "etcdserver: invalid auth token"), Outcome::forbidden);
}

}  // namespace
}  // namespace mlcca::cluster
