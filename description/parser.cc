// SPDX-License-Identifier: BSD-2-Clause
// The SAX interface is used instead of a tree: lines are exact beyond 65535, a DTD is refused at
// its first character, and only a few KiB of the document are in memory.
#include "description/parser.hpp"

#include <fmt/format.h>
#include <libxml/parser.h>
#include <libxml/parserInternals.h>
#include <libxml/xmlerror.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <functional>
#include <memory>
#include <span>

#include "base/handle.hpp"
#include "description/guard.hpp"
#include "description/suggest.hpp"

namespace mlcca::description {
namespace {

using core::FindingId;
using ParserContext = std::unique_ptr<xmlParserCtxt, FreeWith<xmlFreeParserCtxt>>;

std::string_view view(const xmlChar* text) {
  return text == nullptr ? std::string_view{} : reinterpret_cast<const char*>(text);
}

/// Redirects messages of libxml2 that belong to no context from stderr to this object, during one
/// parse.
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

/// The text for an end tag that does not match the open element. `open`: the names of the open
/// elements, the innermost last.
std::string wrong_end(const xmlError& error, std::span<const xmlChar* const> open) {
  const std::string_view wanted(error.str1);
  const std::string_view got(error.str2);
  const bool crossed =
      std::ranges::any_of(open, [&](const xmlChar* name) { return view(name) == got; });
  const std::array known{wanted};
  const std::string text = fmt::format("not well-formed XML: </{}> in line {} ", got, error.line);
  if (crossed)
    return text +
           fmt::format("closes <{0}> of line {1}: </{0}> has to come first", wanted, error.int1);
  if (!closest(got, known).empty())
    return text + fmt::format(
                      "is not spelt like the start tag <{0}> of line {1}: write </{0}>, or "
                      "correct the start tag",
                      wanted, error.int1);
  return text + fmt::format("has no start tag: <{0}> of line {1} is open, and ends with </{0}>",
                            wanted, error.int1);
}

/// The text for a message of libxml2; messages about its internal limits are replaced.
std::string words_for(const xmlError& error, std::span<const xmlChar* const> open) {
  std::string_view text = error.message;
  while (text.ends_with('\n')) text.remove_suffix(1);
  if (text.contains("Huge input lookup") || text.contains("AttValue length too long"))
    return "a name or value is longer than 10 MB; that is the limit";
  if (error.code == XML_ERR_NO_MEMORY) return "cannot read the file: out of memory";
  if (text.contains("not proper UTF-8")) {
    const auto bytes = text.find("Bytes:");
    return fmt::format("not well-formed XML: the text is not proper UTF-8 here{}: save it in UTF-8",
                       bytes == std::string_view::npos
                           ? ""
                           : fmt::format(", at the bytes{}", text.substr(bytes + 6)));
  }
  if (error.code == XML_ERR_INVALID_CHAR)
    return "not well-formed XML: a control character, which XML does not allow: remove it";
  if (error.code == XML_ERR_NAME_REQUIRED && text.contains("StartTag"))
    return "not well-formed XML: no name of an element follows '<': a comment begins with "
           "\"<!--\", "
           "and the character itself is written &lt;";
  if (error.code == XML_ERR_TAG_NAME_MISMATCH && error.str1 != nullptr && error.str2 != nullptr)
    return wrong_end(error, open);
  return fmt::format("not well-formed XML: {}", text);
}

/// If memory runs out, nothing is known about the file.
FindingId id_of(const xmlError& error) {
  return error.code == XML_ERR_NO_MEMORY ? FindingId::unreadable : FindingId::not_xml;
}

std::string_view view_of(const xmlError& error) { return error.message; }

/// The problem for errors in a comment or a CDATA section, with the line in which it begins;
/// libxml2 reports the end of the file if one does not end.
std::optional<Guard::Wrong> comment_message(const Guard& guard, const xmlError& error) {
  switch (error.code) {
    case XML_ERR_COMMENT_NOT_FINISHED:
    case XML_ERR_CDATA_NOT_FINISHED:
      // libxml2 reports one that is too long with the same code.
      if (guard.open_since() == 0 || view_of(error).contains("too big")) return std::nullopt;
      return Guard::Wrong{
          guard.open_since(),
          error.code == XML_ERR_COMMENT_NOT_FINISHED
              ? "not well-formed XML: the comment that begins here does not end: \"-->\" is missing"
              : "not well-formed XML: the CDATA section that begins here does not end: \"]]>\" is "
                "missing"};
    case XML_ERR_HYPHEN_IN_COMMENT:
      return Guard::Wrong{
          error.line,
          fmt::format("not well-formed XML: \"--\" within a comment{}: only \"-->\", its end, may "
                      "have two hyphens; write one, or end the comment before",
                      guard.wrong_comment() == 0 || guard.wrong_comment() == error.line
                          ? ""
                          : fmt::format(", which begins in line {}", guard.wrong_comment()))};
    default:
      return std::nullopt;
  }
}

class Parser {
 public:
  Parser(Source& source, std::uint32_t file, Builder& builder, const Account& account)
      : source_(source), file_(file), builder_(builder), account_(account) {}

  void run();

 private:
  static Parser& of(void* data) { return *static_cast<Parser*>(data); }
  static xmlSAXHandler events();
  static int read(void* data, char* to, int size) noexcept;
  static void message(void* data, xmlError* error) noexcept;

  void start(const xmlChar* name, const xmlChar* uri, int attributes, const xmlChar** rows);
  [[nodiscard]] int line() const { return context_->input == nullptr ? 0 : context_->input->line; }
  [[nodiscard]] int line_of(const char* text) const;
  /// The names of the open elements, the innermost last.
  [[nodiscard]] std::span<const xmlChar* const> open() const {
    if (!context_ || context_->nameTab == nullptr || context_->nameNr <= 0) return {};
    return {context_->nameTab, static_cast<std::size_t>(context_->nameNr)};
  }
  [[nodiscard]] const char* tag_begin() const;
  [[nodiscard]] core::Origin here() const { return {.file = file_, .line = line()}; }
  void end_here() {
    ended_ = true;
    if (context_) xmlStopParser(context_.get());
  }
  void end_if_stopped() {
    if (builder_.stopped()) end_here();
  }

  /// Returns false if libxml2 must not read these bytes.
  bool pass(std::string_view bytes) {
    const auto wrong = guard_.take(bytes);
    if (wrong)
      builder_.stop({.file = file_, .line = wrong->line}, "", wrong->text, FindingId::not_xml);
    return !wrong;
  }

  Source& source_;
  Guard guard_;
  std::uint32_t file_;
  Builder& builder_;
  const Account& account_;
  ParserContext context_;
  std::vector<ParsedAttribute> attributes_;
  bool ended_ = false;  ///< further messages would be consequences of the first one
};

int Parser::read(void* data, char* to, int size) noexcept {
  auto& self = of(data);
  if (self.ended_) return 0;
  const auto got = self.source_.read(to, static_cast<std::size_t>(size));
  if (got < 0) {
    self.builder_.stop({.file = self.file_, .line = 0}, "",
                       fmt::format("cannot read the file: {}", std::strerror(errno)),
                       FindingId::unreadable);
  } else if (self.account_(static_cast<std::size_t>(got)) &&
             self.pass({to, static_cast<std::size_t>(got)})) {
    return static_cast<int>(got);
  }
  // Acts as if the file ended; messages of libxml2 about that are ignored.
  self.ended_ = true;
  return 0;
}

void Parser::message(void* data, xmlError* error) noexcept {
  auto& self = of(data);
  if (self.ended_ || error->level == XML_ERR_WARNING || error->message == nullptr) return;
  if (const auto in_comment = comment_message(self.guard_, *error)) {
    self.builder_.fail({.file = self.file_, .line = in_comment->line}, self.builder_.inside(),
                       in_comment->text, FindingId::not_xml);
    self.end_here();
    return;
  }
  const bool has_line = error->domain == XML_FROM_PARSER || error->domain == XML_FROM_NAMESPACE;
  self.builder_.fail({.file = self.file_, .line = has_line ? error->line : self.line()},
                     self.builder_.inside(), words_for(*error, self.open()), id_of(*error));
  if (error->level == XML_ERR_FATAL) self.end_here();
}

/// The line of `text`, a place in the start tag that was just read. If the place is not in the
/// buffer (libxml2 stores values with references elsewhere), the line that was read last.
int Parser::line_of(const char* text) const {
  const auto* const input = context_->input;
  if (input == nullptr || text == nullptr) return line();
  const auto* const begin = reinterpret_cast<const char*>(input->base);
  const auto* const now = reinterpret_cast<const char*>(input->cur);
  if (std::less<>()(text, begin) || std::less<>()(now, text)) return line();
  return line() - static_cast<int>(std::count(text, now, '\n'));
}

/// The "<" of the start tag that was just read, found backwards, because values contain no "<".
/// Null if it is not in the buffer any more.
const char* Parser::tag_begin() const {
  const auto* const input = context_->input;
  if (input == nullptr) return nullptr;
  const std::string_view read(reinterpret_cast<const char*>(input->base),
                              static_cast<std::size_t>(input->cur - input->base));
  const auto at = read.rfind('<');
  return at == std::string_view::npos ? nullptr : read.data() + at;
}

void Parser::start(const xmlChar* name, const xmlChar* uri, int attributes, const xmlChar** rows) {
  attributes_.clear();
  // libxml2 passes five pointers for each attribute: name, prefix, namespace, begin and end of the
  // value.
  for (const auto row = std::span(rows, static_cast<std::size_t>(attributes) * 5);
       attributes_.size() * 5 < row.size();) {
    const auto at = row.subspan(attributes_.size() * 5, 5);
    attributes_.push_back(
        {{.space = view(at[2]), .local = view(at[0])},
         {reinterpret_cast<const char*>(at[3]), reinterpret_cast<const char*>(at[4])},
         line_of(reinterpret_cast<const char*>(at[3]))});
  }
  builder_.start(line_of(tag_begin()), {.space = view(uri), .local = view(name)}, attributes_);
  end_if_stopped();
}

xmlSAXHandler Parser::events() {
  xmlSAXHandler sax{};
  sax.initialized = XML_SAX2_MAGIC;
  sax.serror = message;
  sax.startElementNs = [](void* data, const xmlChar* name, const xmlChar*, const xmlChar* uri, int,
                          const xmlChar**, int attributes, int, const xmlChar** rows) noexcept {
    of(data).start(name, uri, attributes, rows);
  };
  sax.endElementNs = [](void* data, const xmlChar*, const xmlChar*, const xmlChar*) noexcept {
    auto& self = of(data);
    self.builder_.end();
    self.end_if_stopped();
  };
  sax.characters = [](void* data, const xmlChar* characters, int length) noexcept {
    auto& self = of(data);
    self.builder_.text(
        self.line(), {reinterpret_cast<const char*>(characters), static_cast<std::size_t>(length)});
    self.end_if_stopped();
  };
  sax.cdataBlock = sax.characters;
  sax.ignorableWhitespace = sax.characters;
  sax.internalSubset = [](void* data, const xmlChar*, const xmlChar*, const xmlChar*) noexcept {
    auto& self = of(data);
    self.builder_.fail(self.here(), "", "a DOCTYPE is refused, and entities with it: remove it",
                       FindingId::not_xml);
    self.end_here();
  };
  return sax;
}

void Parser::run() {
  const CaughtMessages caught(this, message);
  auto sax = events();
  context_.reset(xmlCreateIOParserCtxt(&sax, this, read, nullptr, this, XML_CHAR_ENCODING_NONE));
  if (!context_) {
    if (!ended_)
      builder_.stop({.file = file_, .line = 0}, "", "the parser could not be set up: out of memory",
                    FindingId::unreadable);
    return;
  }
  // XML_PARSE_NOENT replaces the five predefined entities in attributes as well; without a DTD
  // there are no others. The limits of libxml2 (10 MB for a token) stay in force.
  xmlCtxtUseOptions(context_.get(), XML_PARSE_NONET | XML_PARSE_NOENT);
  xmlParseDocument(context_.get());
}

}  // namespace

void parse_document(Source& source, std::uint32_t file, Builder& builder, const Account& account) {
  Parser(source, file, builder, account).run();
}

}  // namespace mlcca::description
