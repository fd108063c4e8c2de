// SPDX-License-Identifier: BSD-2-Clause
// The parser's events go to the validator and, where it has no complaint, into our elements. SAX
// instead of a tree: a line is known exactly even beyond 65535, a DTD is stopped at its first
// character, and no more than one part of the System is in memory.
#include "description/xml.hpp"

#include <fmt/format.h>
#include <libxml/parser.h>
#include <libxml/parserInternals.h>
#include <libxml/xmlerror.h>
#include <libxml/xmlschemas.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <memory>
#include <optional>

#include "core/handle.hpp"
#include "description/schema.hpp"
#include "description/suggest.hpp"

namespace mlcca::description {
namespace {

using ParserContext = std::unique_ptr<xmlParserCtxt, FreeWith<xmlFreeParserCtxt>>;
using SchemaParser = std::unique_ptr<xmlSchemaParserCtxt, FreeWith<xmlSchemaFreeParserCtxt>>;
using Schema = std::unique_ptr<xmlSchema, FreeWith<xmlSchemaFree>>;
using Validator = std::unique_ptr<xmlSchemaValidCtxt, FreeWith<xmlSchemaFreeValidCtxt>>;
using Plug = std::unique_ptr<xmlSchemaSAXPlugStruct, FreeWith<xmlSchemaSAXUnplug>>;

std::string_view view(const xmlChar* text) {
  return text == nullptr ? std::string_view{} : reinterpret_cast<const char*>(text);
}

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

std::string collapsed(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (!is_space(c))
      out += c;
    else if (!out.empty() && out.back() != ' ')
      out += ' ';
  }
  if (out.ends_with(' ')) out.pop_back();
  return out;
}

/// Why the text cannot be read as UTF-8 XML, as far as its first bytes tell.
std::optional<std::string> wrong_start(std::string_view xml) {
  if (xml.starts_with("\xef\xbb\xbf")) xml.remove_prefix(3);
  const auto* first = std::ranges::find_if_not(xml, is_space);
  if (first == xml.end()) return "the file is empty: a System element is needed";
  if (*first != '<' || xml.substr(0, 4).contains('\0'))
    return "this is not XML in UTF-8: the first character must be '<'";
  if (!xml.starts_with("<?xml")) return std::nullopt;
  auto declaration = xml.substr(0, xml.find("?>"));
  const auto at = declaration.find("encoding");
  if (at == std::string_view::npos) return std::nullopt;
  declaration.remove_prefix(at);
  const auto quote = declaration.find_first_of("\"'");
  if (quote == std::string_view::npos) return std::nullopt;
  auto encoding = declaration.substr(quote + 1);
  encoding = encoding.substr(0, encoding.find_first_of("\"'"));
  const bool utf8 = std::ranges::equal(encoding, std::string_view("utf-8"), [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == b;
  });
  if (utf8) return std::nullopt;
  return fmt::format("encoding {} is not read: save the file in UTF-8 and declare that", encoding);
}

/// Library messages that belong to no context come here instead of stderr, for one parse.
class CaughtMessages {
 public:
  CaughtMessages(void* context, xmlStructuredErrorFunc function)
      : old_context_(xmlStructuredErrorContext), old_function_(xmlStructuredError) {
    xmlSetStructuredErrorFunc(context, function);
  }
  ~CaughtMessages() { xmlSetStructuredErrorFunc(old_context_, old_function_); }
  CaughtMessages(const CaughtMessages&) = delete;
  CaughtMessages(CaughtMessages&&) = delete;
  CaughtMessages& operator=(const CaughtMessages&) = delete;
  CaughtMessages& operator=(CaughtMessages&&) = delete;

 private:
  void* old_context_;
  xmlStructuredErrorFunc old_function_;
};

class Reader {
 public:
  Reader(Problems& problems, const std::function<void(const Element&)>& root,
         const std::function<void(const Element&)>& part)
      : problems_(problems), root_(root), part_(part) {}

  bool run(std::string_view xml);

 private:
  static Reader& of(void* data) { return *static_cast<Reader*>(data); }
  static xmlSAXHandler events();
  static void message(void* data, xmlError* error) noexcept;

  void start(const xmlChar* name, const xmlChar* prefix, const xmlChar* uri, int namespaces,
             const xmlChar** namespace_pairs, int attributes, int defaulted,
             const xmlChar** attribute_rows);
  bool root_is_right(std::string_view name, std::string_view uri);
  bool within_limits(std::string_view name, std::size_t attributes);
  void end(const xmlChar* name, const xmlChar* prefix, const xmlChar* uri);
  void text(const xmlChar* characters, int length);
  void schema_message(std::string_view message);
  void add(int line, std::string_view element, std::string_view text);
  void stop() {
    stopped_ = true;
    if (parser_) xmlStopParser(parser_.get());
  }
  [[nodiscard]] int line() const { return parser_->input == nullptr ? 0 : parser_->input->line; }

  Problems& problems_;
  const std::function<void(const Element&)>& root_;
  const std::function<void(const Element&)>& part_;
  ParserContext parser_;
  xmlSAXHandler unused_{};  ///< where the validator would pass events on to
  xmlSAXHandlerPtr validator_events_ = nullptr;
  void* validator_data_ = nullptr;
  std::vector<Element> open_;
  std::size_t unknown_depth_ = 0;  ///< inside an unknown part: neither validated nor kept
  std::size_t items_ = 0;
  bool valid_ = true;
  bool stopped_ = false;  ///< further messages would be consequences
  bool part_valid_ = true;
};

void Reader::add(int line, std::string_view element, std::string_view text) {
  valid_ = false;
  part_valid_ = false;
  problems_.add(line, element, text);
  if (problems_.overflowing()) stop();
}

void Reader::message(void* data, xmlError* error) noexcept {
  auto& self = of(data);
  if (self.stopped_ || error->level == XML_ERR_WARNING || error->message == nullptr) return;
  if (error->domain == XML_FROM_SCHEMASV) {
    self.schema_message(error->message);
    return;
  }
  std::string_view text = error->message;
  while (text.ends_with('\n')) text.remove_suffix(1);
  const std::string_view inside =
      self.open_.empty() ? "" : std::string_view(self.open_.back().name);
  const int line = error->domain == XML_FROM_PARSER || error->domain == XML_FROM_NAMESPACE
                       ? error->line
                       : self.line();
  self.add(line, inside, fmt::format("not well-formed XML: {}", text));
  if (error->level == XML_ERR_FATAL) self.stop();
}

void Reader::schema_message(std::string_view message) {
  const auto& about = open_.back();
  const std::string_view parent =
      open_.size() < 2 ? "" : std::string_view(open_[open_.size() - 2].name);
  add(about.line, about.name, explain_schema_message(message, about.name, parent));
}

bool Reader::root_is_right(std::string_view name, std::string_view uri) {
  if (name == "System" && uri.empty()) return true;
  add(line(), name, "the root element must be System, without a namespace");
  stop();
  return false;
}

bool Reader::within_limits(std::string_view name, std::size_t attributes) {
  items_ += 1 + attributes;
  if (items_ > kMaxItems)
    add(line(), name,
        fmt::format("the file has more than {} elements and attributes; that is the limit",
                    kMaxItems));
  else if (open_.size() + unknown_depth_ >= kMaxDepth)
    add(line(), name,
        fmt::format("is nested deeper than {} elements; that is the limit", kMaxDepth));
  else
    return true;
  stop();
  return false;
}

void Reader::start(const xmlChar* name, const xmlChar* prefix, const xmlChar* uri, int namespaces,
                   const xmlChar** namespace_pairs, int attributes, int defaulted,
                   const xmlChar** attribute_rows) {
  if (!within_limits(view(name), static_cast<std::size_t>(attributes))) return;
  if (unknown_depth_ > 0) {
    ++unknown_depth_;
    return;
  }
  if (open_.empty() && !root_is_right(view(name), view(uri))) return;
  if (open_.size() == 1) {
    part_valid_ = true;
    const auto parts = words_of("System")->children;
    if (std::ranges::find(parts, view(name)) == parts.end()) {
      add(line(), view(name), fmt::format("is not known here; {}", known_names(view(name), parts)));
      unknown_depth_ = 1;
      return;
    }
  }
  Element element{std::string(view(name)), line(), {}, {}, {}};
  for (int i = 0; i < attributes; ++i) {
    const auto row = std::span(attribute_rows, static_cast<std::size_t>(attributes) * 5)
                         .subspan(static_cast<std::size_t>(i) * 5, 5);
    if (row[2] != nullptr) continue;
    const auto* from = reinterpret_cast<const char*>(row[3]);
    const auto* to = reinterpret_cast<const char*>(row[4]);
    element.attributes.emplace_back(view(row[0]), collapsed(std::string_view(from, to)));
  }
  open_.push_back(std::move(element));
  validator_events_->startElementNs(validator_data_, name, prefix, uri, namespaces, namespace_pairs,
                                    attributes, defaulted, attribute_rows);
  if (open_.size() == 1) root_(open_.front());
}

void Reader::end(const xmlChar* name, const xmlChar* prefix, const xmlChar* uri) {
  if (unknown_depth_ > 0) {
    --unknown_depth_;
    return;
  }
  validator_events_->endElementNs(validator_data_, name, prefix, uri);
  auto& top = open_.back();
  top.text = collapsed(top.text);
  auto closed = std::move(top);
  open_.pop_back();
  if (open_.size() == 1 && part_valid_) part_(closed);
  if (open_.size() > 1) open_.back().children.push_back(std::move(closed));
}

void Reader::text(const xmlChar* characters, int length) {
  if (unknown_depth_ > 0 || open_.empty()) return;
  validator_events_->characters(validator_data_, characters, length);
  const std::string_view piece(reinterpret_cast<const char*>(characters),
                               static_cast<std::size_t>(length));
  auto& text = open_.back().text;
  if (!text.empty() || !std::ranges::all_of(piece, is_space)) text += piece;
}

xmlSAXHandler Reader::events() {
  xmlSAXHandler sax{};
  sax.initialized = XML_SAX2_MAGIC;
  sax.serror = message;
  sax.startElementNs = [](void* data, const xmlChar* name, const xmlChar* prefix,
                          const xmlChar* uri, int namespaces, const xmlChar** pairs, int attributes,
                          int defaulted, const xmlChar** rows) noexcept {
    of(data).start(name, prefix, uri, namespaces, pairs, attributes, defaulted, rows);
  };
  sax.endElementNs = [](void* data, const xmlChar* name, const xmlChar* prefix,
                        const xmlChar* uri) noexcept { of(data).end(name, prefix, uri); };
  sax.characters = [](void* data, const xmlChar* characters, int length) noexcept {
    of(data).text(characters, length);
  };
  sax.cdataBlock = sax.characters;
  sax.ignorableWhitespace = sax.characters;
  sax.internalSubset = [](void* data, const xmlChar*, const xmlChar*, const xmlChar*) noexcept {
    auto& self = of(data);
    self.add(self.line(), "", "a DOCTYPE is refused, and entities with it: remove it");
    self.stop();
  };
  return sax;
}

bool Reader::run(std::string_view xml) {
  const CaughtMessages caught(this, message);
  const auto size = static_cast<int>(xml.size());  // at most kMaxFileBytes
  const SchemaParser schema_parser(
      xmlSchemaNewMemParserCtxt(schema().begin(), static_cast<int>(schema().size())));
  const Schema compiled(schema_parser ? xmlSchemaParse(schema_parser.get()) : nullptr);
  const Validator validator(compiled ? xmlSchemaNewValidCtxt(compiled.get()) : nullptr);
  parser_.reset(xmlCreateMemoryParserCtxt(xml.begin(), size));
  if (!validator || !parser_) {
    add(0, "", "the parser or the compiled-in schema could not be set up: out of memory");
    return false;
  }
  xmlSchemaSetValidStructuredErrors(validator.get(), message, this);
  *parser_->sax = events();
  parser_->userData = this;
  // HUGE lifts the library's own limits, one of which any file beyond 10 MB reaches; ours hold.
  xmlCtxtUseOptions(parser_.get(), XML_PARSE_NONET | XML_PARSE_HUGE);

  unused_ = xmlSAXHandler{};
  unused_.initialized = XML_SAX2_MAGIC;
  unused_.startElementNs = [](void*, const xmlChar*, const xmlChar*, const xmlChar*, int,
                              const xmlChar**, int, int, const xmlChar**) {};
  validator_events_ = &unused_;
  validator_data_ = this;
  const Plug plug(xmlSchemaSAXPlug(validator.get(), &validator_events_, &validator_data_));
  if (!plug) {
    add(0, "", "the validator could not be set up: out of memory");
    return false;
  }
  xmlParseDocument(parser_.get());
  return valid_;
}

}  // namespace

std::string_view Element::attribute(std::string_view key) const {
  for (const auto& [found, value] : attributes)
    if (found == key) return value;
  return {};
}

const Element* Element::child(std::string_view key) const {
  const auto found = std::ranges::find(children, key, &Element::name);
  return found == children.end() ? nullptr : &*found;
}

bool parse(std::string_view xml, Problems& problems,
           const std::function<void(const Element&)>& root,
           const std::function<void(const Element&)>& part) {
  if (xml.size() > kMaxFileBytes) {
    problems.add(0, "",
                 fmt::format("the file has {} bytes; the limit is {}", xml.size(), kMaxFileBytes));
    return false;
  }
  if (const auto wrong = wrong_start(xml)) {
    problems.add(1, "", *wrong);
    return false;
  }
  return Reader(problems, root, part).run(xml);
}

}  // namespace mlcca::description
