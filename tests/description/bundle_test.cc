// SPDX-License-Identifier: BSD-2-Clause
// A description of several files in one text: the same System, the same digest, and no file of the
// machine.
#include "description/bundle.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <string>

#include "base/sha256.hpp"
#include "description/read.hpp"
#include "tests/description/folder.hpp"

namespace mlcca::description {
namespace {

constexpr const char* kIncluding =
    R"(<System name="s" xmlns:xi="http://www.w3.org/2001/XInclude"><xi:include href="n.xml"/>)"
    R"(<xi:include href="sub/m.xml"/></System>)";
constexpr const char* kBus =
    R"(<Network name="%"><Kind>can</Kind><Profile>raw</Profile></Network>)";

std::string bus_named(const std::string& name) {
  std::string out = kBus;
  return out.replace(out.find('%'), 1, name);
}

class Bundles : public WithFolder {
 protected:
  void SetUp() override {
    WithFolder::SetUp();
    file("s.xml", kIncluding);
    file("n.xml", bus_named("a"));
    file("sub/m.xml", bus_named("b"));
    const auto system = read(path("s.xml"), Users::any, &digest, &bundle);
    EXPECT_TRUE(system) << (system ? "" : to_string(system.error().front()));
  }
  std::string why_not(const std::string& text) {
    Sha256::Digest other{};
    const auto system = read_bundle(text, Users::any, other);
    return system ? "" : to_string(system.error().front());
  }

  Sha256::Digest digest{};
  std::string bundle;
};

TEST_F(Bundles, HaveTheSystemAndTheDigestOfTheirFiles) {
  ASSERT_FALSE(bundle.empty());
  std::filesystem::remove(path("n.xml"));
  Sha256::Digest other{};
  const auto system = read_bundle(bundle, Users::any, other);
  ASSERT_TRUE(system) << to_string(system.error().front());
  EXPECT_EQ(system->networks.size(), 2U);
  EXPECT_EQ(system->networks[1].name, "b");
  EXPECT_EQ(other, digest);
}

TEST_F(Bundles, HaveTheirDigestWithoutBeingRead) {
  EXPECT_EQ(digest_of(bundle), digest);
  const auto files = files_in(bundle);
  ASSERT_TRUE(files);
  for (const FileInBundle& file : *files) {
    std::string damaged = bundle;
    damaged[static_cast<std::size_t>(file.content.data() - bundle.data()) + 3] = '~';
    EXPECT_NE(digest_of(damaged), digest) << file.name;
  }
  EXPECT_FALSE(digest_of(""));
  EXPECT_FALSE(digest_of(bundle.substr(0, bundle.size() - 1)));
}

TEST_F(Bundles, AreRefusedWhereTheyAreDamaged) {
  EXPECT_NE(why_not(""), "");
  EXPECT_NE(why_not("<System name=\"s\"/>"), "");
  for (const std::size_t size : {std::size_t{20}, std::size_t{25}, bundle.size() - 1})
    EXPECT_NE(why_not(bundle.substr(0, size)), "") << size;
  EXPECT_NE(why_not(bundle + "3 x\n<a>").find("nothing includes"), std::string::npos);
  const auto files = files_in(bundle);
  ASSERT_TRUE(files);
  ASSERT_EQ(files->size(), 3U);
  const std::string less =
      bundle_of({{.name = "s.xml", .content = std::string(files->front().content)}});
  EXPECT_NE(why_not(less).find("no further file"), std::string::npos) << why_not(less);
}

TEST_F(Bundles, OpenNoFileOfTheMachine) {
  const std::string itself = bundle_of({{.name = path("s.xml"), .content = kIncluding},
                                        {.name = path("s.xml"), .content = kIncluding},
                                        {.name = path("n.xml"), .content = bus_named("a")}});
  EXPECT_NE(why_not(itself), "");
}

TEST_F(Bundles, ThatAreTooLongAreNotMade) {
  EXPECT_EQ(bundle_of({{.name = "s.xml", .content = std::string(kMaxBundle, ' ')}}), "");
  file("n.xml", bus_named("a") + "<!--" + std::string(kMaxBundle, ' ') + "-->");
  std::string none = "x";
  EXPECT_TRUE(read(path("s.xml"), Users::any, &digest, &none));
  EXPECT_EQ(none, "");
}

}  // namespace
}  // namespace mlcca::description
