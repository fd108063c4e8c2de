// SPDX-License-Identifier: BSD-2-Clause
// libxml2 validates against the published schema. A file may have any of its elements as root.
#include "tools/design/describe/validate.hpp"

#include <fmt/format.h>
#include <libxml/parser.h>
#include <libxml/xmlerror.h>
#include <libxml/xmlschemas.h>

#include <algorithm>
#include <cctype>
#include <memory>

#include "base/handle.hpp"
#include "description/read.hpp"
#include "tools/design/describe/markup.hpp"

namespace mlcca::tools::design {
namespace {

using ParserContext = std::unique_ptr<xmlParserCtxt, FreeWith<xmlFreeParserCtxt>>;
using Document = std::unique_ptr<xmlDoc, FreeWith<xmlFreeDoc>>;
using SchemaParser = std::unique_ptr<xmlSchemaParserCtxt, FreeWith<xmlSchemaFreeParserCtxt>>;
using Schema = std::unique_ptr<xmlSchema, FreeWith<xmlSchemaFree>>;
using Validator = std::unique_ptr<xmlSchemaValidCtxt, FreeWith<xmlSchemaFreeValidCtxt>>;

constexpr std::size_t kMaxMessages = 20;

class Messages {
 public:
  Messages() : old_context_(xmlStructuredErrorContext), old_function_(xmlStructuredError) {
    xmlSetStructuredErrorFunc(this, receive);
  }
  ~Messages() { xmlSetStructuredErrorFunc(old_context_, old_function_); }
  Messages(const Messages&) = delete;
  Messages(Messages&&) = delete;
  Messages& operator=(const Messages&) = delete;
  Messages& operator=(Messages&&) = delete;

  static void receive(void* self, xmlError* error) noexcept {
    auto& found = static_cast<Messages*>(self)->found;
    if (error->message == nullptr || found.size() >= kMaxMessages) return;
    std::string text = error->message;
    while (text.ends_with('\n')) text.pop_back();
    std::ranges::replace_if(text, [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
    found.push_back(fmt::format("line {}: {}", error->line, text));
  }

  std::vector<std::string> found;

 private:
  void* old_context_;
  xmlStructuredErrorFunc old_function_;
};

bool is_utf8(const xmlChar* encoding) {
  const std::string_view name =
      encoding == nullptr ? "UTF-8" : reinterpret_cast<const char*>(encoding);
  return std::ranges::equal(name, std::string_view("utf-8"), [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == b;
  });
}

}  // namespace

std::vector<std::string> problems_of_text(std::string_view text) {
  if (text.size() > kMaxEdited)
    return {fmt::format("the text has {} bytes; the limit is {}", text.size(), kMaxEdited)};
  if (const auto prolog = check_prolog(text); !prolog) return {prolog.error().text};
  Messages messages;
  const ParserContext parser(xmlNewParserCtxt());
  const Document document(parser ? xmlCtxtReadMemory(parser.get(), text.data(),
                                                     static_cast<int>(text.size()), nullptr,
                                                     nullptr, XML_PARSE_NONET | XML_PARSE_BIG_LINES)
                                 : nullptr);
  if (!document) {
    if (messages.found.empty()) messages.found.emplace_back("the text cannot be parsed");
    return messages.found;
  }
  if (!is_utf8(document->encoding))
    return {fmt::format("encoding {} is not read: save the file in UTF-8 and declare that",
                        reinterpret_cast<const char*>(document->encoding))};
  const auto xsd = description::schema();
  const SchemaParser schema_parser(
      xmlSchemaNewMemParserCtxt(xsd.data(), static_cast<int>(xsd.size())));
  const Schema schema(schema_parser ? xmlSchemaParse(schema_parser.get()) : nullptr);
  const Validator validator(schema ? xmlSchemaNewValidCtxt(schema.get()) : nullptr);
  if (!validator) return {"the compiled-in schema could not be set up"};
  xmlSchemaSetValidStructuredErrors(validator.get(), Messages::receive, &messages);
  if (xmlSchemaValidateDoc(validator.get(), document.get()) != 0 && messages.found.empty())
    messages.found.emplace_back("the text does not fit the schema");
  return messages.found;
}

}  // namespace mlcca::tools::design
