// SPDX-License-Identifier: BSD-2-Clause
// The tables of words, the attribute table and the schema say the same.
#include "description/schema.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include "description/pattern.hpp"
#include "description/read.hpp"
#include "description/suggest.hpp"
#include "mlcca/attribute.hpp"

namespace mlcca::description {
namespace {

/// The first groups of all matches, in the schema or a part of it.
std::set<std::string> all(const std::string& text, const std::string& form) {
  std::set<std::string> out;
  for (auto& groups : Pattern(form).find_all(text)) out.insert(groups[0]);
  return out;
}

std::string xsd() { return std::string(schema()); }

/// The text of a top-level definition.
std::string definition(const std::string& kind, const std::string& name) {
  const auto text = xsd();
  const auto from = text.find("\n  <xs:" + kind + " name=\"" + name + "\">");
  const auto to = text.find("\n  </xs:" + kind + ">", from);
  return from == std::string::npos ? "" : text.substr(from, to - from);
}

TEST(Schema, IsTheFileThatTheSourceHas) {
  std::ifstream file("description/system.xsd");
  EXPECT_EQ(schema(), std::string(std::istreambuf_iterator<char>(file), {}));
}

TEST(Schema, NamesExactlyTheAttributesOfTheTable) {
  std::set<std::string> table;
  for (const auto& row : kAttributeTable) table.insert(row.name);
  EXPECT_EQ(all(definition("simpleType", "AttributeName"), "enumeration value=\"([^\"]*)\""),
            table);
}

TEST(Schema, DocumentsEveryElement) {
  const auto text = xsd();
  const auto elements = Pattern(
                            "<xs:element name=\"([A-Za-z]*)\" "
                            "type=\"[^\"]*\"[^>/]*>[[:space:]]*<([a-z:]*)>[[:space:]]*"
                            "<([a-z:]*)>")
                            .find_all(text);
  for (const auto& [name, first, second] : elements) {
    EXPECT_EQ(first, "xs:annotation") << name;
    EXPECT_EQ(second, "xs:documentation") << name;
  }
  // The others refer to nothing: the root, whose type is documented.
  EXPECT_EQ(elements.size() + 1, Pattern("<xs:element name=()").find_all(text).size());
  EXPECT_TRUE(definition("complexType", "System").contains("<xs:documentation>"));
}

TEST(TypeWords, ExistForEveryTypeThatIsNoEnumeration) {
  const auto text = xsd();
  std::set<std::string> named;
  for (const auto& row : type_words())
    if (row.type != "xs:boolean") named.insert(std::string(row.type));
  std::set<std::string> defined;
  for (const auto& name : all(text, "<xs:simpleType name=\"([A-Za-z]*)\""))
    if (!definition("simpleType", name).contains("enumeration")) defined.insert(name);
  EXPECT_EQ(named, defined);
}

TEST(TypeWords, HaveThePatternsOfTheSchema) {
  for (const auto& row : type_words()) {
    const auto patterns =
        all(definition("simpleType", std::string(row.type)), "pattern value=\"([^\"]*)\"");
    if (row.pattern.empty())
      EXPECT_TRUE(patterns.empty()) << row.type;
    else
      EXPECT_EQ(patterns, std::set<std::string>{std::string(row.pattern)}) << row.type;
  }
}

TEST(ElementWords, HaveTheChildrenAndAttributesOfTheSchema) {
  for (const auto& row : element_words()) {
    const std::string name(row.element);
    auto text = definition("complexType", name);
    if (text.contains("ref=\"Quantity\"")) text += definition("group", "Quantity");
    if (text.contains("ref=\"End\"")) text += definition("attributeGroup", "End");
    if (name == "Attribute") text += definition("complexType", "ProvidedAttribute");
    ASSERT_FALSE(text.empty()) << name;
    EXPECT_EQ(all(text, "<xs:element name=\"([^\"]*)\""),
              std::set<std::string>(row.children.begin(), row.children.end()))
        << name;
    EXPECT_EQ(all(text, "<xs:attribute name=\"([^\"]*)\""),
              std::set<std::string>(row.attributes.begin(), row.attributes.end()))
        << name;
  }
}

TEST(ExplainSchemaMessage, KeepsAMessageItDoesNotKnow) {
  EXPECT_EQ(explain_schema_message("Element 'Port': Something new.\n", "Port", "Gateway"),
            "Something new.");
  EXPECT_EQ(explain_schema_message("Something newer.\n", "Port", "Gateway"), "Something newer.");
}

TEST(ExplainSchemaMessage, KnowsThatACutMessageIsAboutAValueThatIsTooLong) {
  for (const std::string_view cut :
       {"", "Element '", "Element 'Port', attribute 'netw",
        "Element 'Port', attribute 'network': [facet 'pattern'] The v"})
    EXPECT_TRUE(explain_schema_message(cut, "Port", "Gateway").ends_with("is far too long")) << cut;
}

using Names = std::vector<std::string_view>;

TEST(Closest, FindsSlipsAndNotOtherNames) {
  const Names known{"robot-can", "second-can", "air"};
  EXPECT_EQ(closest("robot-cam", known), "robot-can");
  EXPECT_EQ(closest("robotcan", known), "robot-can");
  EXPECT_EQ(closest("Robot-Can", known), "robot-can");
  EXPECT_EQ(closest("robto-cna", known), "robot-can");
  EXPECT_EQ(closest("robot", known), "");
  EXPECT_EQ(closest("ari", known), "air");
  EXPECT_EQ(closest("abc", known), "");
  EXPECT_EQ(closest("", known), "");
  EXPECT_EQ(closest(std::string(100, 'a'), known), "");
}

TEST(KnownNames, ListsEightAndCountsTheRest) {
  const Names eight{"n0", "n1", "n2", "n3", "n4", "n5", "n6", "n7"};
  EXPECT_EQ(known_names("x", eight), "known: n0, n1, n2, n3, n4, n5, n6, n7");
  auto nine = eight;
  nine.push_back("other");
  EXPECT_EQ(known_names("x", nine), "known: n0, n1, n2, n3, n4, n5, n6, n7 and 1 more");
  EXPECT_EQ(known_names("othr", nine),
            "did you mean other? Known: n0, n1, n2, n3, n4, n5, n6, n7 and 1 more");
  EXPECT_EQ(known_names("x", {}), "none is described");
}

}  // namespace
}  // namespace mlcca::description
