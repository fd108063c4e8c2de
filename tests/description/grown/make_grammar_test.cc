// SPDX-License-Identifier: BSD-2-Clause
// What a schema may say and the recogniser cannot do is refused when its table is made.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "tests/description/folder.hpp"

namespace mlcca::description {
namespace {

class MakeGrammarTest : public WithFolder {
 protected:
  /// What it says of system.xsd with the only `before` replaced; empty where it makes a table.
  std::string refusal_of(std::string_view before, std::string_view after) {
    std::ifstream original("description/system.xsd");
    std::string xsd(std::istreambuf_iterator<char>(original), {});
    const auto at = xsd.find(before);
    EXPECT_NE(at, std::string::npos) << before;
    EXPECT_EQ(xsd.find(before, at + 1), std::string::npos) << before;
    xsd.replace(at, before.size(), after);
    const auto command =
        "description/make-grammar " + file("changed.xsd", xsd) + " 2>&1 >" + path("table");
    auto* const pipe = popen(command.c_str(), "r");
    std::string said;
    std::array<char, 256> piece{};
    while (std::fgets(piece.data(), piece.size(), pipe) != nullptr) said += piece.data();
    const int status = pclose(pipe);
    EXPECT_EQ(WIFEXITED(status) && WEXITSTATUS(status) == 0, said.empty()) << said;
    return said.substr(said.find(": ") == std::string::npos ? 0 : said.find(": ") + 2);
  }
};

constexpr std::string_view kPortNumber =
    "<xs:minInclusive value=\"0\"/>\n      <xs:maxInclusive value=\"65535\"/>\n"
    "    </xs:restriction>\n  </xs:simpleType>\n\n  <xs:simpleType name=\"Bitrate\">";

TEST_F(MakeGrammarTest, TakesTheSchemaAsItIs) {
  EXPECT_EQ(refusal_of("xs:pattern value=\"0x[0-9a-fA-F]{1,8}\"",
                       "xs:pattern value=\"0x[0-9a-fA-F]{1,8}\""),
            "");
}

TEST_F(MakeGrammarTest, RefusesAPatternThatNeedsGoingBack) {
  const std::string_view before = "value=\"[0-9a-fA-F.:]{2,45}\"";
  EXPECT_EQ(refusal_of(before, "value=\"[0-9a-f:]{2,45}:[0-9]\""),
            "pattern [0-9a-f:]{2,45}:[0-9]: what a run takes might be needed behind it\n");
  // What is between the two may be absent.
  EXPECT_EQ(refusal_of(before, "value=\"[a-f]{2,45}:?f\""),
            "pattern [a-f]{2,45}:?f: what a run takes might be needed behind it\n");
  EXPECT_EQ(refusal_of(before, "value=\"[a-f]{2}:?f\""), "");
}

TEST_F(MakeGrammarTest, RefusesAPatternThatItHasNoRuleFor) {
  const std::string_view before = "value=\"[0-9a-fA-F.:]{2,45}\"";
  EXPECT_EQ(refusal_of(before, "value=\"(ab)*\""),
            "pattern (ab)*: a group is repeated without a limit\n");
  EXPECT_EQ(refusal_of(before, "value=\"\\d+\""), "pattern \\d+: \\d has no rule\n");
  EXPECT_EQ(refusal_of(before, "value=\".+\""), "pattern .+: . has no rule\n");
  EXPECT_EQ(refusal_of(before, "value=\"[^a]+\""), "pattern [^a]+: ^ in a set has no rule\n");
  EXPECT_EQ(refusal_of(before, "value=\"(a\""), "pattern (a: unbalanced\n");
  EXPECT_EQ(refusal_of(before, "value=\"ä\""),
            "pattern ä: characters that are not printable ASCII have no rule\n");
}

TEST_F(MakeGrammarTest, RefusesAFacetThatItHasNoRuleFor) {
  EXPECT_EQ(refusal_of(kPortNumber,
                       "<xs:totalDigits value=\"5\"/>\n    </xs:restriction>\n"
                       "  </xs:simpleType>\n\n  <xs:simpleType name=\"Bitrate\">"),
            "simpleType PortNumber: has no rule; a pattern needs an xs:documentation\n");
}

TEST_F(MakeGrammarTest, RefusesARangeThatItCannotRead) {
  const std::string_view before = "<xs:appinfo source=\"range\">0.000001 to 1</xs:appinfo>";
  EXPECT_EQ(refusal_of(before, "<xs:appinfo source=\"range\">up to 1</xs:appinfo>"),
            "simpleType Limit: a range is \"0 to 1 seconds\", rounded is \"up, 6 digits\"\n");
  EXPECT_EQ(refusal_of(before, "<xs:appinfo source=\"range\">0.0000001 to 1</xs:appinfo>"),
            "simpleType Limit: 0.0000001 is no whole number of its digits\n");
}

TEST_F(MakeGrammarTest, RefusesContentThatItHasNoRuleFor) {
  EXPECT_EQ(refusal_of("<xs:element name=\"Port\" type=\"Port\" maxOccurs=\"unbounded\">",
                       "<xs:element name=\"Port\" type=\"Port\" nillable=\"true\">"),
            "element Port: nillable has no rule\n");
  EXPECT_EQ(refusal_of("<xs:attribute name=\"place\" type=\"Name\" use=\"required\"/>",
                       "<xs:anyAttribute/>"),
            "Hop: anyAttribute has no rule\n");
}

TEST_F(MakeGrammarTest, RefusesATypeThatIsNotDefined) {
  EXPECT_EQ(refusal_of("<xs:attribute name=\"place\" type=\"Name\" use=\"required\"/>",
                       "<xs:attribute name=\"place\" type=\"Nam\" use=\"required\"/>"),
            "Hop: unknown types Nam\n");
}

TEST_F(MakeGrammarTest, RefusesAPartThatIsNoRootOfAFile) {
  EXPECT_EQ(refusal_of("  <xs:element name=\"Route\" type=\"Route\"/>\n", ""),
            "System: what it holds and the roots of included files differ\n");
}

}  // namespace
}  // namespace mlcca::description
