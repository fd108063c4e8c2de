// SPDX-License-Identifier: BSD-2-Clause
// libxml2's validator with the published schema, and ours with its table, accept and refuse the
// same documents: the corpora, and thousands of documents made from them by random mutations.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <libxml/parser.h>
#include <libxml/tree.h>
#include <libxml/xmlschemas.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "base/handle.hpp"
#include "description/grammar.hpp"
#include "description/problems.hpp"
#include "description/read.hpp"
#include "description/xml.hpp"

namespace mlcca::description {
namespace {

using Document = std::unique_ptr<xmlDoc, FreeWith<xmlFreeDoc>>;

const xmlChar* bytes(const std::string& text) {
  return reinterpret_cast<const xmlChar*>(text.c_str());
}

Document parsed(const std::string& xml) {
  return Document(xmlReadMemory(xml.data(), static_cast<int>(xml.size()), "d.xml", nullptr,
                                XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING));
}

/// libxml2's validator.
class Reference {
 public:
  explicit Reference(const std::string& xsd = std::string(schema())) {
    const std::unique_ptr<xmlSchemaParserCtxt, FreeWith<xmlSchemaFreeParserCtxt>> parser(
        xmlSchemaNewMemParserCtxt(xsd.data(), static_cast<int>(xsd.size())));
    schema_.reset(xmlSchemaParse(parser.get()));
    EXPECT_NE(schema_, nullptr);
  }
  [[nodiscard]] bool accepts(xmlDoc* document) const {
    const std::unique_ptr<xmlSchemaValidCtxt, FreeWith<xmlSchemaFreeValidCtxt>> validator(
        xmlSchemaNewValidCtxt(schema_.get()));
    xmlSchemaSetValidStructuredErrors(validator.get(), [](void*, xmlError*) {}, nullptr);
    return xmlSchemaValidateDoc(validator.get(), document) == 0;
  }

 private:
  std::unique_ptr<xmlSchema, FreeWith<xmlSchemaFree>> schema_;
};

/// What ours has against the text; empty: accepted.
std::string objections(const std::string& xml) {
  Problems problems("d.xml");
  const bool valid = parse_text(xml, "", problems, {});
  std::string out;
  for (const auto& p : problems.take()) out += to_string(p) + "\n";
  EXPECT_EQ(valid, out.empty());
  return out;
}

std::string text_of(xmlDoc* document) {
  xmlChar* memory = nullptr;
  int size = 0;
  xmlDocDumpMemoryEnc(document, &memory, &size, "UTF-8");
  std::string out(reinterpret_cast<const char*>(memory), static_cast<std::size_t>(size));
  xmlFree(memory);
  return out;
}

/// One random change of a tree after the other, the same for the same seed.
class Mutator {
 public:
  explicit Mutator(std::uint32_t seed) : random_(seed) {
    for (const auto* type : element_types()) {
      for (const auto& step : type->steps)
        for (const auto& child : step.children) names_.emplace_back(child.name);
      for (const auto& key : type->keys) keys_.emplace_back(key.name);
    }
    names_.emplace_back("Unknown");
    keys_.emplace_back("unknown");
    for (const auto* type : value_types())
      for (const auto& value : type->values) values_.emplace_back(value);
    for (const std::size_t length : {14U, 15U, 16U, 62U, 63U, 64U, 65U, 255U, 256U, 1024U, 1025U})
      values_.emplace_back(length, 'x');
    std::string umlauts = "x";
    for (int i = 1; i < 255; ++i) umlauts += "ä";
    values_.push_back(umlauts);
    values_.push_back(umlauts + "ä");
    values_.push_back("0x" + std::string(16, 'f'));
    values_.push_back("0x" + std::string(17, 'f'));
    values_.push_back(std::string(20, '9') + "." + std::string(20, '9'));
    values_.push_back(std::string(21, '9'));
    values_.push_back("0." + std::string(21, '9'));
    values_.push_back("000000000000000000000000000000000007");
  }

  void mutate(xmlDoc* document) {
    elements_.clear();
    collect(xmlDocGetRootElement(document));
    auto* const element = any(elements_);
    switch (below(16)) {
      case 0:
        return remove(element);
      case 1:
        return duplicate(element);
      case 2:
        return swap(element);
      case 3:
        return xmlNodeSetName(element, bytes(any(names_)));
      case 4:
        return move(element);
      case 5:
        return insert(element, xmlNewNode(nullptr, bytes(any(names_))));
      case 6:
        return insert(element, xmlNewText(bytes(any(values_))));
      case 7:
        return insert(element, xmlNewComment(bytes("comment")));
      case 8:
        return insert(element, xmlNewPI(bytes("target"), bytes("data")));
      case 9:
        return insert(element, xmlNewText(bytes(" \n\t")));
      case 10:
        return insert_cdata(document, element);
      case 11:
        return remove_key(element);
      case 12:
        return rename_key(element);
      case 13:
        return set_key(element, any(keys_));
      case 14:
        return set_known_key(element);
      default:
        return set_text(element);
    }
  }

  std::size_t below(std::size_t limit) { return random_() % limit; }
  [[nodiscard]] const std::vector<std::string>& values() const { return values_; }

 private:
  template <class T>
  T& any(std::vector<T>& from) {
    return from[below(from.size())];
  }

  void collect(xmlNode* node) {
    elements_.push_back(node);
    for (auto* child = node->children; child != nullptr; child = child->next)
      if (child->type == XML_ELEMENT_NODE) collect(child);
  }

  static bool is_root(const xmlNode* node) { return node->parent->type != XML_ELEMENT_NODE; }

  static void remove(xmlNode* node) {
    if (is_root(node)) return;
    xmlUnlinkNode(node);
    xmlFreeNode(node);
  }

  static void duplicate(xmlNode* node) {
    if (!is_root(node)) xmlAddNextSibling(node, xmlCopyNode(node, 1));
  }

  static void swap(xmlNode* node) {
    auto* const next = xmlNextElementSibling(node);
    if (next == nullptr || is_root(node)) return;
    xmlUnlinkNode(next);
    xmlAddPrevSibling(node, next);
  }

  void move(xmlNode* node) {
    auto* const to = any(elements_);
    for (const auto* n = to; n != nullptr; n = n->parent)
      if (n == node) return;
    xmlUnlinkNode(node);
    insert(to, node);
  }

  void insert(xmlNode* parent, xmlNode* node) {
    if (parent->children == nullptr || below(2) == 0)
      xmlAddChild(parent, node);
    else
      xmlAddPrevSibling(parent->children, node);
  }

  void insert_cdata(xmlDoc* document, xmlNode* parent) {
    // With an x: libxml2 refuses a CDATA section of white space between elements, which the
    // recommendation allows.
    const auto value = "x" + any(values_);
    insert(parent, xmlNewCDataBlock(document, bytes(value), static_cast<int>(value.size())));
  }

  std::vector<xmlAttr*> keys_of(const xmlNode* node) {
    std::vector<xmlAttr*> out;
    for (auto* a = node->properties; a != nullptr; a = a->next) out.push_back(a);
    return out;
  }

  void remove_key(const xmlNode* node) {
    if (auto keys = keys_of(node); !keys.empty()) xmlRemoveProp(any(keys));
  }

  void rename_key(xmlNode* node) {
    auto keys = keys_of(node);
    if (keys.empty()) return;
    auto* const key = any(keys);
    const std::unique_ptr<xmlChar, void (*)(void*)> value(xmlNodeGetContent(key->children),
                                                          xmlFree);
    const std::string kept = value ? reinterpret_cast<const char*>(value.get()) : "";
    xmlRemoveProp(key);
    set(node, any(keys_), kept);
  }

  void set_key(xmlNode* node, const std::string& key) { set(node, key, any(values_)); }

  void set_known_key(xmlNode* node) {
    if (auto keys = keys_of(node); !keys.empty())
      set_key(node, reinterpret_cast<const char*>(any(keys)->name));
  }

  static void set(xmlNode* node, const std::string& key, const std::string& value) {
    xmlSetProp(node, bytes(key), bytes(value));
  }

  void set_text(xmlNode* node) {
    while (node->properties == nullptr && xmlFirstElementChild(node) != nullptr)
      node = xmlFirstElementChild(node);
    auto value = any(values_);
    if (below(4) == 0) value = " \n" + value + "\t ";
    if (below(8) == 0) value.insert(std::min<std::size_t>(1, value.size()), "  ");
    const std::unique_ptr<xmlChar, void (*)(void*)> escaped(
        xmlEncodeSpecialChars(nullptr, bytes(value)), xmlFree);
    xmlNodeSetContent(node, escaped.get());
  }

  std::mt19937 random_;  // its sequence is the same everywhere
  std::vector<xmlNode*> elements_;
  std::vector<std::string> names_;
  std::vector<std::string> keys_;
  std::vector<std::string> values_{
      "",           " ",           "0",       "1",       "-1",      "+5",         "-0",
      "+0",         "00012",       "9",       "-9",      "10",      "-10",        "30",
      "-30",        "31",          "-31",     "1000",    "1001",    "5 5",        "65535",
      "65536",      "1000000",     "1000001", "500k",    "8000000", "8000001",    "1e3",
      "0.5",        ".5",          "5.",      "1.2.3",   "-0.5",    "true",       "false",
      "TRUE",       "yes",         "Can",     "0x1",     "0X1",     "0x",         "0xg",
      "0xFfF",      "0x123456789", "127",     "128",     "1234",    "a b",        "1a",
      "_a",         "a-b.c_d",     "Period",  "Latency", "can0",    "a@b",        "ä",
      "&<>\"",      "-",           "+",       "--1",     "stop",    "2147483648", "-1001",
      "]]>",        "a\nb",        "\t1\n",   "1 ",      "0.",      "a.-",        "1_000",
      "4294967296", "0x00000000"};
};

std::vector<std::string> corpus() {
  std::vector<std::string> out;
  for (const std::string folder :
       {"tests/corpus/description/good", "tests/corpus/description/bad", "examples"})
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      if (entry.path().extension() != ".xml") continue;
      std::ifstream file(entry.path(), std::ios::binary);
      std::string text(std::istreambuf_iterator<char>(file), {});
      // What the schema alone does not say: no entities, no inclusion, and nothing of the
      // validator's.
      const bool other = text.contains("<!DOCTYPE") || text.contains("XInclude") ||
                         text.contains("XMLSchema-instance") || text.contains("ISO-8859");
      if (!other && parsed(text)) out.push_back(std::move(text));
    }
  std::ranges::sort(out);
  return out;
}

bool has_system_root(xmlDoc* document) {
  return xmlStrEqual(xmlDocGetRootElement(document)->name, bytes("System")) != 0;
}

/// Compares the two for one document; true if it is accepted.
bool compare(const Reference& reference, xmlDoc* tree) {
  const auto xml = text_of(tree);
  const auto again = parsed(xml);  // as written: a neighbouring text may have become one with it
  if (!again) return false;
  const bool right = reference.accepts(again.get()) && has_system_root(again.get());
  const auto ours = objections(xml);
  EXPECT_EQ(ours.empty(), right) << xml << "\n" << ours;
  return right;
}

/// As a parser and a type of the schema leave it.
std::string collapsed(const std::string& text) {
  std::istringstream words(text);
  std::string out;
  for (std::string word; words >> word;) out += (out.empty() ? "" : " ") + word;
  return out;
}

TEST(Validators, AgreeOnEveryValueOfEveryType) {
  std::string xsd(schema());
  std::string more;
  for (const auto* type : value_types())
    more += fmt::format("<xs:element name=\"value.{0}\" type=\"{1}\"/>",
                        type->name.substr(type->name.find(':') + 1), type->name);
  xsd.insert(xsd.rfind("</xs:schema>"), more);
  const Reference reference(xsd);
  const Mutator pool(1);
  std::size_t accepted = 0;
  for (const auto* type : value_types()) {
    const auto element = fmt::format("value.{}", type->name.substr(type->name.find(':') + 1));
    for (const auto& value : pool.values()) {
      const Document tree(xmlNewDoc(bytes("1.0")));
      auto* const root = xmlNewDocRawNode(tree.get(), nullptr, bytes(element), bytes(value));
      xmlDocSetRootElement(tree.get(), root);
      const bool right = reference.accepts(tree.get());
      EXPECT_EQ(is_valid(*type, collapsed(value)), right) << type->name << ": " << value;
      accepted += right ? 1 : 0;
    }
  }
  EXPECT_GT(accepted, 500U);
}

TEST(Validators, AgreeOnTheCorpora) {
  const Reference reference;
  const auto documents = corpus();
  ASSERT_GT(documents.size(), 80U);
  for (const auto& xml : documents) compare(reference, parsed(xml).get());
}

TEST(Validators, AgreeOnThousandsOfMutations) {
  const Reference reference;
  const auto documents = corpus();
  std::size_t accepted = 0;
  std::size_t refused = 0;
  std::uint32_t seed = 0;
  for (int round = 0; round < 150; ++round)
    for (const auto& xml : documents) {
      Mutator mutator(++seed);
      const auto tree = parsed(xml);
      for (auto changes = 1 + mutator.below(3); changes > 0; --changes) mutator.mutate(tree.get());
      ++(compare(reference, tree.get()) ? accepted : refused);
      if (::testing::Test::HasFailure()) return;
    }
  // Both sides are really visited.
  EXPECT_GT(accepted, 1000U);
  EXPECT_GT(refused, 1000U);
}

}  // namespace
}  // namespace mlcca::description
