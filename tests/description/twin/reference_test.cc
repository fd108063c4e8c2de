// SPDX-License-Identifier: BSD-2-Clause
// The HTML reference says everything that the schema says, and stands by itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <set>
#include <string>

#include "description/read.hpp"
#include "description/values.hpp"
#include "tests/description/twin/twin.hpp"

namespace mlcca::testing {
namespace {

const std::string& page() {
  static const std::string text =
      output_of("xsltproc --nonet description/reference.xsl description/system.xsd");
  return text;
}

/// What the only group of `pattern` matches in `text`.
std::set<std::string> all(const std::string& text, const std::string& pattern) {
  const std::regex expression(pattern);
  std::set<std::string> out;
  for (std::sregex_iterator it(text.begin(), text.end(), expression), end; it != end; ++it)
    out.insert((*it)[1]);
  return out;
}

std::set<std::string> in_schema(const std::string& pattern) {
  return all(std::string(description::schema()), pattern);
}

std::string without_tags(const std::string& text) {
  return std::regex_replace(text, std::regex("<[^>]*>"), "");
}

TEST(Reference, HasEveryElementAndAttribute) {
  const auto elements = in_schema(R"r(<xs:element name="([^"]+)")r");
  const auto attributes = in_schema(R"r(<xs:attribute name="([^"]+)")r");
  ASSERT_TRUE(elements.contains("EventChannel") && attributes.contains("id-path"));
  const auto shown = all(page(), "<code>([^<]+)</code>");
  for (const auto& name : elements) EXPECT_TRUE(shown.contains(name)) << "element " << name;
  for (const auto& name : attributes) EXPECT_TRUE(shown.contains(name)) << "attribute " << name;
}

/// What stands between `start` and the next `end`.
std::string between(const std::string& text, const std::string& start, const std::string& end) {
  const auto first = text.find(start);
  if (first == std::string::npos) return {};
  const auto from = first + start.size();
  return text.substr(from, text.find(end, from) - from);
}

TEST(Reference, HasThemWhereTheyBelong) {
  const std::string schema(description::schema());
  for (const auto& type : in_schema(R"r(<xs:complexType name="([^"]+)")r")) {
    const auto defined =
        between(schema, "<xs:complexType name=\"" + type + "\">", "</xs:complexType>");
    const auto part = between(page(), "id=\"" + type + "\"", "<div class=\"part\"");
    const auto shown = all(part, "(?:<li[^>]*>|<td>)<code>([^<]+)</code>");
    for (const auto& name : all(defined, R"r(<xs:(?:element|attribute) name="([^"]+)")r"))
      EXPECT_TRUE(shown.contains(name)) << name << " in " << type;
  }
}

TEST(Reference, HasEveryType) {
  const auto types = in_schema(R"r(<xs:(?:complex|simple)Type name="([^"]+)")r");
  ASSERT_TRUE(types.contains("Provision") && types.contains("Decimal"));
  const auto ids = all(page(), R"r( id="([^"]+)")r");
  for (const auto& name : types) EXPECT_TRUE(ids.contains(name)) << name;
}

TEST(Reference, HasEverySentenceOfTheSchema) {
  const auto text = without_tags(page());
  const std::string schema(description::schema());
  const std::regex spaces("\\s+");
  std::size_t found = 0;
  const std::string start = "<xs:documentation>";
  for (auto at = schema.find(start); at != std::string::npos; at = schema.find(start, at + 1)) {
    const auto first = at + start.size();
    std::string body = schema.substr(first, schema.find("</xs:documentation>", at) - first);
    for (std::size_t end = 0; !body.empty(); body.erase(0, end)) {
      end = std::min(body.find("\n\n"), body.size());
      if (end == 0) end = 2;
      auto sentence = std::regex_replace(body.substr(0, end), spaces, " ");
      sentence.erase(0, sentence.find_first_not_of(' '));
      sentence.erase(sentence.find_last_not_of(' ') + 1);
      EXPECT_NE(text.find(sentence), std::string::npos) << sentence;
      ++found;
    }
  }
  EXPECT_GE(found, 50U);
}

TEST(Reference, SaysPatternsInTheWordsOfTheErrors) {
  const auto text = without_tags(page());
  for (const auto* type : description::value_types()) {
    if (type->pattern.empty()) continue;
    EXPECT_NE(text.find(std::string(type->words) + " (" + std::string(type->pattern) + ")"),
              std::string::npos)
        << type->name;
  }
}

TEST(Reference, LinksOnlyWithinItself) {
  const auto ids = all(page(), R"r( id="([^"]+)")r");
  const auto links = all(page(), R"r(<[a-z][^>]* href="([^"]+)")r");
  ASSERT_GE(links.size(), 40U);
  for (const auto& link : links)
    EXPECT_TRUE(link.starts_with('#') && ids.contains(link.substr(1))) << link;
  for (const auto* loads : {"<script", "<link", "<img", "src=", "url(", "@import"})
    EXPECT_EQ(page().find(loads), std::string::npos) << loads;
}

TEST(Reference, IsWellFormedHtml) {
  const Folder folder;
  const auto file = folder.add("reference.html", page());
  EXPECT_EQ(output_of("xmllint --html --noout --nonet '" + file + "' 2>&1"), "");
}

TEST(Reference, ShowsExamplesThatExist) {
  const auto& text = page();
  for (const auto* part : {"&lt;System ", "&lt;EventChannel name=\"emergency-switch\"",
                           "&lt;Attributes priority=\"1\" latency=\"", "&lt;Network ", "&lt;Bus ",
                           "&lt;Mesh ", "&lt;Provision omission=\"", "&lt;Gateway ",
                           "&lt;Component ", "&lt;Placement ", "&lt;Route "})
    EXPECT_NE(text.find(part), std::string::npos) << part;
}

}  // namespace
}  // namespace mlcca::testing
