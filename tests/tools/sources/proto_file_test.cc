// SPDX-License-Identifier: BSD-2-Clause
// Links that people write down: in a file that may change, and in the description.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>

#include "tests/tools/sources/proto_loop.hpp"
#include "tools/sources/file.hpp"

namespace mlcca::net {
namespace {

using core::mesh::RateKind;
using core::mesh::Sample;

const core::mesh::Mesh kMesh =
    test::mesh_of({"02:00:00:00:00:01", "02:00:00:00:00:02", "02:00:00:00:00:03"});

std::vector<Sample> links_of(const std::string& text) {
  auto links = parse_links(text, "links", kMesh);
  EXPECT_TRUE(links) << links.error().text;
  return links ? *links : std::vector<Sample>{};
}

std::string error_of(const std::string& text) {
  const auto links = parse_links(text, "links", kMesh);
  return links ? "none" : links.error().text;
}

TEST(LinkFile, ALineIsALink) {
  const auto links = links_of("n1 02:00:00:00:00:02 24Mbit/s\n");
  ASSERT_EQ(links.size(), 1U);
  Sample expected;
  expected.from = "02:00:00:00:00:01";
  expected.to = "02:00:00:00:00:02";
  expected.rate = 24'000'000;
  EXPECT_EQ(links[0], expected);
}

TEST(LinkFile, EverythingOfALinkCanBeStated) {
  const auto links = links_of(
      "# the whole line\n\n"
      "\tn1  n2 5.5Mbit/s loss=0.01 channel=2412 kind=effective busy=0.1 weight=256 both # "
      "both\r\n");
  ASSERT_EQ(links.size(), 2U);
  const Sample& there = links[0];
  EXPECT_EQ(there.rate, 5'500'000U);
  EXPECT_EQ(there.loss, 10'000'000U);
  EXPECT_EQ(there.channel, 2412U);
  EXPECT_EQ(there.kind, RateKind::effective);
  EXPECT_EQ(there.busy, 100'000U);
  EXPECT_EQ(there.weight, 256U);
  Sample back = there;
  std::swap(back.from, back.to);
  EXPECT_EQ(links[1], back);
}

TEST(LinkFile, RatesHaveUnits) {
  EXPECT_EQ(links_of("n1 n2 2Gbit/s")[0].rate, 2'000'000'000U);
  EXPECT_EQ(links_of("n1 n2 40Gbit/s")[0].rate, 40'000'000'000U);
  EXPECT_EQ(links_of("n1 n2 250kbit/s")[0].rate, 250'000U);
  EXPECT_EQ(links_of("n1 n2 9600bit/s")[0].rate, 9600U);
  EXPECT_EQ(links_of("n1 n2 1.000000001Gbit/s")[0].rate, 1'000'000'001U);
}

TEST(LinkFile, WhatIsWrongIsReportedWithItsLine) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"n1 n2", "links:1: a link needs"},
      {"\n\nn1 n9 1Mbit/s", "links:3: no node has the name or address \"n9\""},
      {"n1 n1 1Mbit/s", "links:1: a link leads to another node"},
      {"n1 n2 24", "links:1: \"24\" is no rate"},
      {"n1 n2 0Mbit/s", "links:1: \"0Mbit/s\" is no rate"},
      {"n1 n2 -1Mbit/s", "links:1: \"-1Mbit/s\" is no rate"},
      {"n1 n2 1.Mbit/s", "links:1: \"1.Mbit/s\" is no rate"},
      {"n1 n2 1e3Mbit/s", "links:1: \"1e3Mbit/s\" is no rate"},
      {"n1 n2 99999999999Gbit/s", "links:1: \"99999999999Gbit/s\" is no rate"},
      {"n1 n2 1Mbit/s loss=1.1", "links:1: loss is a share"},
      {"n1 n2 1Mbit/s loss", "links:1: loss is a share"},
      {"n1 n2 1Mbit/s busy=x", "links:1: busy is a share"},
      {"n1 n2 1Mbit/s channel=1.5", "links:1: channel is a whole number"},
      {"n1 n2 1Mbit/s weight=", "links:1: weight is a whole number"},
      {"n1 n2 1Mbit/s kind=fast", "links:1: kind is phy"},
      {"n1 n2 1Mbit/s colour=red", "links:1: \"colour=red\" is unknown"},
      {"n1 n2 1Mbit/s both\nn2 n1 2Mbit/s", "links:2: the link from"},
  };
  for (const auto& [text, error] : cases)
    EXPECT_TRUE(error_of(text).starts_with(error)) << text << "\n" << error_of(text);
}

TEST(LinkFile, AllOfALossCanBeLost) {
  EXPECT_EQ(links_of("n1 n2 1Mbit/s loss=1")[0].loss, 1'000'000'000U);
  EXPECT_EQ(links_of("n1 n2 1Mbit/s loss=0.000000001")[0].loss, 1U);
  EXPECT_NE(error_of("n1 n2 1Mbit/s loss=0.0000000001"), "none");
}

class WatchedFile : public ::testing::Test {
 protected:
  static void write(const std::string& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
  }
  [[nodiscard]] std::string path() const { return folder_ / "links"; }
  [[nodiscard]] core::mesh::Source source() const {
    core::mesh::Source out;
    out.kind = core::mesh::SourceKind::file;
    out.endpoint = path();
    return out;
  }
  static test::Watched::Predicate rate_is(Value rate) {
    return [rate](const auto& s) { return s.links.size() == 1 && s.links[0].rate == rate; };
  }

  test::Folder folder_;
};

TEST_F(WatchedFile, ChangesAreSeenHoweverTheyAreMade) {
  write(path(), "n1 n2 24Mbit/s\n");
  test::Watched watched(source(), kMesh);
  ASSERT_TRUE(watched.await(rate_is(24'000'000))) << watched.last();
  write(path(), "n1 n2 11Mbit/s\n");
  ASSERT_TRUE(watched.await(rate_is(11'000'000))) << watched.last();
  write(path() + ".new", "n1 n2 6Mbit/s\n");
  std::filesystem::rename(path() + ".new", path());
  ASSERT_TRUE(watched.await(rate_is(6'000'000))) << watched.last();
}

TEST_F(WatchedFile, ItsLinksDoNotGrowOld) {
  write(path(), "n1 n2 24Mbit/s\n");
  test::Watched watched(source(), kMesh);
  const auto first = watched.await(rate_is(24'000'000));
  ASSERT_TRUE(first);
  EXPECT_TRUE(watched.await([&](const auto& s) {
    return s.links.size() == 1 && s.links[0].taken > first->links[0].taken;
  }));
}

TEST_F(WatchedFile, NothingOfABadFileIsUsed) {
  write(path(), "n1 n2 24Mbit/s\n");
  test::Watched watched(source(), kMesh);
  ASSERT_TRUE(watched.await(rate_is(24'000'000))) << watched.last();
  write(path(), "n1 n2 11Mbit/s\nn2 n1 much\n");
  const auto reported = watched.await([](const auto& s) { return !s.problem.empty(); });
  ASSERT_TRUE(reported) << watched.last();
  EXPECT_TRUE(reported->links.empty());
  EXPECT_TRUE(reported->problem.starts_with(path() + ":2: ")) << reported->problem;
  write(path(), "n1 n2 11Mbit/s\n");
  EXPECT_TRUE(watched.await(rate_is(11'000'000))) << watched.last();
}

TEST_F(WatchedFile, AFileThatIsRemovedHasNoLinksUntilItIsThereAgain) {
  write(path(), "n1 n2 24Mbit/s\n");
  test::Watched watched(source(), kMesh);
  ASSERT_TRUE(watched.await(rate_is(24'000'000))) << watched.last();
  std::filesystem::remove(path());
  const auto gone = watched.await([](const auto& s) { return s.links.empty(); });
  ASSERT_TRUE(gone) << watched.last();
  EXPECT_NE(gone->problem, "");
  write(path(), "n1 n2 6Mbit/s\n");
  EXPECT_TRUE(watched.await(rate_is(6'000'000))) << watched.last();
}

TEST_F(WatchedFile, AFolderMayComeLaterAndComeBack) {
  const std::string folder = folder_ / "later";
  auto later = source();
  later.endpoint = folder + "/links";
  test::Watched watched(later, kMesh);
  ASSERT_TRUE(watched.await([](const auto& s) { return !s.problem.empty(); }));
  for (const int rate : {24, 11}) {
    std::filesystem::create_directory(folder);
    write(later.endpoint, "n1 n2 " + std::to_string(rate) + "Mbit/s\n");
    ASSERT_TRUE(watched.await(rate_is(static_cast<Value>(rate) * 1'000'000))) << watched.last();
    std::filesystem::remove_all(folder);
    ASSERT_TRUE(watched.await([](const auto& s) { return s.links.empty(); })) << watched.last();
  }
}

TEST_F(WatchedFile, WhatASymbolicLinkLeadsToIsSeenWhateverTimeItBears) {
  const std::string elsewhere = folder_ / "elsewhere";
  std::filesystem::create_directory(elsewhere);
  write(elsewhere + "/a", "n1 n2 24Mbit/s\n");
  write(elsewhere + "/b", "n1 n2 11Mbit/s\n");
  std::filesystem::create_symlink(elsewhere + "/a", path());
  test::Watched watched(source(), kMesh);
  ASSERT_TRUE(watched.await(rate_is(24'000'000))) << watched.last();
  // Of a clock that was an hour ahead.
  std::filesystem::last_write_time(
      elsewhere + "/b", std::filesystem::file_time_type::clock::now() + std::chrono::hours(1));
  std::filesystem::rename(elsewhere + "/b", elsewhere + "/a");
  EXPECT_TRUE(watched.await(rate_is(11'000'000))) << watched.last();
}

TEST_F(WatchedFile, ARelativePathIsRefusedAtOnce) {
  auto relative = source();
  relative.endpoint = "links";
  EXPECT_NE(test::Watched(relative, kMesh).error(), "");
}

}  // namespace
}  // namespace mlcca::net
