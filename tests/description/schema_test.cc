// SPDX-License-Identifier: BSD-2-Clause
// The published schema, read once more, and the table that is made of it say the same: every type,
// element, attribute, order, number and limit of one is in the other.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <libxml/parser.h>
#include <libxml/tree.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "description/grammar.hpp"
#include "description/read.hpp"
#include "description/values.hpp"
#include "tests/description/pattern.hpp"

namespace mlcca::description {
namespace {

using Lines = std::vector<std::string>;

std::string attribute(const xmlNode* node, const char* key) {
  const std::unique_ptr<xmlChar, void (*)(void*)> value(
      xmlGetNoNsProp(node, reinterpret_cast<const xmlChar*>(key)), xmlFree);
  return value ? reinterpret_cast<const char*>(value.get()) : "";
}

std::string text_of(const xmlNode* node) {
  const std::unique_ptr<xmlChar, void (*)(void*)> text(xmlNodeGetContent(node), xmlFree);
  return text ? reinterpret_cast<const char*>(text.get()) : "";
}

std::string name_of(const xmlNode* node) { return reinterpret_cast<const char*>(node->name); }

std::vector<const xmlNode*> elements(const xmlNode* parent) {
  std::vector<const xmlNode*> out;
  for (const auto* child = parent->children; child != nullptr; child = child->next)
    if (child->type == XML_ELEMENT_NODE && name_of(child) != "annotation") out.push_back(child);
  return out;
}

/// The schema as a tree, and its types as sorted lines of text that the table can be turned into
/// too.
class Schema {
 public:
  Schema()
      : document_(xmlReadMemory(schema().data(), static_cast<int>(schema().size()), "system.xsd",
                                nullptr, XML_PARSE_NONET)) {
    for (const auto* node : elements(xmlDocGetRootElement(document_.get())))
      by_name_[name_of(node)][attribute(node, "name")] = node;
  }

  using Nodes = std::map<std::string, const xmlNode*>;
  const Nodes& all(const std::string& kind) { return by_name_[kind]; }

  /// "text T", then "step 0..1 A:T|B:T", then sorted "key name:T required default 'D'".
  Lines lines_of(const xmlNode* type) {
    Lines out;
    Lines keys;
    add_content(type, out, keys);
    std::ranges::sort(keys);
    out.insert(out.end(), keys.begin(), keys.end());
    return out;
  }

 private:
  static std::string times(unsigned least, unsigned most) {
    return fmt::format("{}..{}", least, most == kUnlimited ? "" : fmt::format("{}", most));
  }
  static unsigned number(const xmlNode* node, const char* key) {
    const auto text = attribute(node, key);
    if (text.empty()) return 1;
    return text == "unbounded" ? kUnlimited : static_cast<unsigned>(std::stoul(text));
  }
  static std::string particle(const xmlNode* node) {
    if (name_of(node) == "any") {
      EXPECT_EQ(attribute(node, "namespace"), "http://www.w3.org/2001/XInclude");
      EXPECT_EQ(attribute(node, "processContents"), "lax");
      return "xi:include";
    }
    EXPECT_EQ(name_of(node), "element");
    return attribute(node, "name") + ":" + attribute(node, "type");
  }

  void add_content(const xmlNode* node, Lines& out, Lines& keys) {
    for (const auto* child : elements(node)) {
      const auto kind = name_of(child);
      if (kind == "attribute") {
        keys.push_back(fmt::format(
            "key {}:{}{} default '{}'", attribute(child, "name"), attribute(child, "type"),
            attribute(child, "use") == "required" ? " required" : "", attribute(child, "default")));
      } else if (kind == "attributeGroup" || kind == "group") {
        const auto* group = all(kind).at(attribute(child, "ref"));
        add_content(group, out, keys);
      } else if (kind == "simpleContent") {
        const auto* extension = elements(child).front();
        out.push_back("text " + attribute(extension, "base"));
        add_content(extension, out, keys);
      } else if (kind == "element") {
        out.push_back(fmt::format("step {} {}",
                                  times(number(child, "minOccurs"), number(child, "maxOccurs")),
                                  particle(child)));
      } else if (kind == "choice") {
        Lines names;
        for (const auto* one : elements(child)) names.push_back(particle(one));
        out.push_back(fmt::format("step {} {}",
                                  times(number(child, "minOccurs"), number(child, "maxOccurs")),
                                  fmt::join(names, "|")));
      } else if (kind == "all") {
        out.emplace_back("any order");
        add_content(child, out, keys);
      } else if (kind == "sequence") {
        add_sequence(child, out, keys, node);
      } else {
        ADD_FAILURE() << "the table has no way to say " << kind;
      }
    }
  }

  /// An optional sequence in a sequence: its first may be absent, and the others only follow it.
  void add_sequence(const xmlNode* child, Lines& out, Lines& keys, const xmlNode* parent) {
    if (name_of(parent) != "sequence") {
      add_content(child, out, keys);
      return;
    }
    EXPECT_EQ(number(child, "minOccurs"), 0U);
    EXPECT_EQ(number(child, "maxOccurs"), 1U);
    Lines inner;
    add_content(child, inner, keys);
    ASSERT_TRUE(inner.front().starts_with("step 1..1 "));
    inner.front().replace(5, 4, "0..1");
    for (std::size_t i = 1; i < inner.size(); ++i) inner[i] += " after the one before";
    out.insert(out.end(), inner.begin(), inner.end());
  }

  std::unique_ptr<xmlDoc, FreeWith<xmlFreeDoc>> document_;
  std::map<std::string, Nodes> by_name_;
};

std::string type_name(const ElementType& type) {
  return std::string(type.name.empty() ? type.value->name : type.name);
}

/// The same lines from the table.
Lines lines_of(const ElementType& type) {
  Lines out;
  if (type.any_order) out.emplace_back("any order");
  if (type.value != nullptr) out.push_back(fmt::format("text {}", type.value->name));
  for (const auto& step : type.steps) {
    Lines names;
    for (const auto& child : step.children)
      names.push_back(fmt::format("{}:{}", child.name, type_name(*child.type)));
    if (step.includes) names.emplace_back("xi:include");
    out.push_back(fmt::format(
        "step {}..{} {}{}", step.least, step.most == kUnlimited ? "" : fmt::format("{}", step.most),
        fmt::join(names, "|"), step.needs_previous ? " after the one before" : ""));
  }
  Lines keys;
  for (const auto& key : type.keys)
    keys.push_back(fmt::format("key {}:{}{} default '{}'", key.name, key.type->name,
                               key.required ? " required" : "", key.otherwise));
  std::ranges::sort(keys);
  out.insert(out.end(), keys.begin(), keys.end());
  return out;
}

TEST(Schema, IsTheFileThatTheSourceHas) {
  std::ifstream file("description/system.xsd");
  EXPECT_EQ(schema(), std::string(std::istreambuf_iterator<char>(file), {}));
}

TEST(Schema, HasExactlyTheElementTypesOfTheTable) {
  Schema xsd;
  std::set<std::string> defined;
  for (const auto& [name, node] : xsd.all("complexType")) defined.insert(name);
  std::set<std::string> known;
  for (const auto* type : element_types()) known.insert(std::string(type->name));
  EXPECT_EQ(known, defined);
}

TEST(Schema, SaysOfEveryElementTypeWhatTheTableSays) {
  Schema xsd;
  for (const auto* type : element_types()) {
    const auto found = xsd.all("complexType").find(std::string(type->name));
    ASSERT_NE(found, xsd.all("complexType").end()) << type->name;
    EXPECT_EQ(lines_of(*type), xsd.lines_of(found->second)) << type->name;
  }
}

TEST(Schema, HasExactlyTheRootsOfTheTable) {
  Schema xsd;
  std::set<std::string> roots;
  for (const auto& [name, node] : xsd.all("element"))
    roots.insert(name + ":" + attribute(node, "type"));
  std::set<std::string> known{fmt::format("{}:{}", system_root().name, system_root().type->name)};
  for (const auto& part : system_parts())
    known.insert(fmt::format("{}:{}", part.name, part.type->name));
  EXPECT_EQ(known, roots);
}

/// What "source" of a type's own annotation says.
std::string appinfo(const xmlNode* type, std::string_view source) {
  for (const auto* child = type->children; child != nullptr; child = child->next) {
    if (child->type != XML_ELEMENT_NODE || name_of(child) != "annotation") continue;
    for (const auto* info : elements(child))
      if (name_of(info) == "appinfo" && attribute(info, "source") == source) return text_of(info);
  }
  return "";
}

/// The facets of a simple type, as "base token pattern X" and so on.
Lines facets(const xmlNode* type) {
  const auto* restriction = elements(type).front();
  Lines out{"base " + attribute(restriction, "base")};
  if (const auto range = appinfo(type, "range"); !range.empty())
    out.push_back("range " + range + " rounded " + appinfo(type, "rounded"));
  for (const auto* facet : elements(restriction))
    out.push_back(name_of(facet) + " " + attribute(facet, "value"));
  return out;
}

Lines facets(const ValueType& type) {
  const auto& scale = type.scale;
  if (!scale.range.empty())
    return {"base Decimal",
            fmt::format("range {} rounded {}, {} digits", scale.range,
                        scale.rounding == Rounding::up ? "up" : "down", scale.digits)};
  Lines out{type.integer ? "base xs:integer" : "base xs:token"};
  if (!type.pattern.empty()) out.push_back(fmt::format("pattern {}", type.pattern));
  for (const auto& value : type.values) out.push_back(fmt::format("enumeration {}", value));
  if (type.integer) {
    out.push_back(fmt::format("minInclusive {}", type.least));
    out.push_back(fmt::format("maxInclusive {}", type.most));
  }
  if (type.shortest > 0) out.push_back(fmt::format("minLength {}", type.shortest));
  if (type.longest > 0) out.push_back(fmt::format("maxLength {}", type.longest));
  return out;
}

TEST(Schema, SaysOfEveryValueWhatTheTableSays) {
  Schema xsd;
  std::set<std::string> defined{"xs:boolean"};
  for (const auto& [name, node] : xsd.all("simpleType")) defined.insert(name);
  std::set<std::string> known;
  for (const auto* type : value_types()) {
    known.insert(std::string(type->name));
    if (type->name == "xs:boolean") continue;
    const auto found = xsd.all("simpleType").find(std::string(type->name));
    ASSERT_NE(found, xsd.all("simpleType").end()) << type->name;
    EXPECT_EQ(facets(*type), facets(found->second)) << type->name;
  }
  EXPECT_EQ(known, defined);
}

TEST(Schema, DocumentsEveryElement) {
  const auto text = std::string(schema());
  const auto documented = Pattern(
                              "<xs:element name=\"([A-Za-z]*)\" "
                              "type=\"[^\"]*\"[^>/]*>[[:space:]]*<([a-z:]*)>[[:space:]]*"
                              "<([a-z:]*)>")
                              .find_all(text);
  for (const auto& [name, first, second] : documented) {
    EXPECT_EQ(first, "xs:annotation") << name;
    EXPECT_EQ(second, "xs:documentation") << name;
  }
  // The roots refer to types whose elements are documented where they are parts of System.
  const auto roots = system_parts().size() + 1;
  EXPECT_EQ(documented.size() + roots, Pattern("<xs:element name=()").find_all(text).size());
}

}  // namespace
}  // namespace mlcca::description
