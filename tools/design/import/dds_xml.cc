// SPDX-License-Identifier: BSD-2-Clause
// Reads XML profiles by SAX: <data_writer profile_name="..."><qos> of Fast DDS, <qos_profile
// name="..."> <datawriter_qos> of DDS-XML. The reader stops at the beginning of a DTD.
#include <fmt/format.h>
#include <libxml/parser.h>
#include <libxml/parserInternals.h>
#include <libxml/xmlerror.h>

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <utility>

#include "base/handle.hpp"
#include "base/number.hpp"
#include "base/text.hpp"
#include "description/guard.hpp"
#include "description/source.hpp"
#include "tools/design/import/dds.hpp"

namespace mlcca::tools::design {
namespace {

using ProfileContext = std::unique_ptr<xmlParserCtxt, FreeWith<xmlFreeParserCtxt>>;

constexpr std::size_t kMostElements = 262'144;
constexpr std::size_t kMostElementDepth = 64;
constexpr std::size_t kMostLeaf = 4'096;  // bytes of a text that are kept
constexpr std::size_t kMostCalled = 200;  // bytes of a name

std::string_view characters_of(const xmlChar* text) {
  return text == nullptr ? std::string_view() : reinterpret_cast<const char*>(text);
}

/// The elements that contain the policies of a writer or reader.
struct EndElement {
  std::string_view name;
  bool writes;
  std::string_view needs;  ///< an attribute that must be present; empty: none
};
constexpr auto kEndElements = std::to_array<EndElement>({
    {"data_writer", true, ""},
    {"data_reader", false, ""},
    {"publisher", true, "profile_name"},
    {"subscriber", false, "profile_name"},
    {"datawriter_qos", true, ""},
    {"datareader_qos", false, ""},
});

/// The parts of a duration.
struct DurationParts {
  std::optional<std::uint64_t> seconds;
  std::optional<std::uint64_t> nanoseconds;
  bool infinite = false;

  [[nodiscard]] std::optional<std::uint64_t> total() const {
    constexpr std::uint64_t second = 1'000'000'000;
    constexpr std::uint64_t most = 2'147'483'647;  // seconds that mean infinite
    if (infinite || seconds.value_or(0) >= most) return most * second;
    return seconds.value_or(0) * second + nanoseconds.value_or(0);
  }
};

class ProfileReader {
 public:
  explicit ProfileReader(const std::string& file) : file_(file) {}

  Result<ImportedNetwork> read(std::string_view text, const ImportOptions& options) {
    parse(text);
    return ends_.take(file_, options, error_,
                      "there is no profile of a data writer or data reader in it, such as "
                      "<data_writer profile_name=\"...\">");
  }

 private:
  using Attributes = std::vector<std::pair<std::string_view, std::string_view>>;

  static ProfileReader& of(void* data) { return *static_cast<ProfileReader*>(data); }

  void wrong(int line, std::string_view text) {
    if (error_.empty()) error_ = fmt::format("{}:{}: {}", file_, line, text);
    if (context_) xmlStopParser(context_.get());
  }
  [[nodiscard]] int line() const { return context_->input == nullptr ? 0 : context_->input->line; }

  void parse(std::string_view text) {
    if (const auto why = description::wrong_start(text, true)) return wrong(1, *why);
    description::Guard guard;
    if (const auto bad = guard.take(text)) return wrong(bad->line, bad->text);
    context_.reset(xmlCreateMemoryParserCtxt(text.data(), static_cast<int>(text.size())));
    if (!context_) {
      error_ = fmt::format("{}: the parser could not be set up: out of memory", file_);
      return;
    }
    *context_->sax = events();
    context_->userData = this;
    xmlCtxtUseOptions(context_.get(), XML_PARSE_NONET | XML_PARSE_NOENT);
    xmlParseDocument(context_.get());
  }

  static xmlSAXHandler events() {
    xmlSAXHandler sax{};
    sax.initialized = XML_SAX2_MAGIC;
    sax.serror = [](void* data, xmlError* error) noexcept {
      if (error->level == XML_ERR_FATAL && error->message != nullptr)
        of(data).not_well_formed(*error);
    };
    sax.startElementNs = [](void* data, const xmlChar* name, const xmlChar*, const xmlChar*, int,
                            const xmlChar**, int count, int, const xmlChar** rows) noexcept {
      // Each attribute has five pointers: name, prefix, namespace, begin and end of its value.
      constexpr std::size_t row = 5;
      Attributes attributes;
      for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        const auto at = std::span(rows + i * row, row);
        const auto* const begin = reinterpret_cast<const char*>(at[3]);
        attributes.emplace_back(characters_of(at[0]),
                                std::string_view(begin, static_cast<std::size_t>(at[4] - at[3])));
      }
      of(data).start(characters_of(name), attributes);
    };
    sax.endElementNs = [](void* data, const xmlChar*, const xmlChar*, const xmlChar*) noexcept {
      of(data).end();
    };
    sax.characters = [](void* data, const xmlChar* text, int size) noexcept {
      of(data).text({reinterpret_cast<const char*>(text), static_cast<std::size_t>(size)});
    };
    sax.cdataBlock = sax.characters;
    sax.internalSubset = [](void* data, const xmlChar*, const xmlChar*, const xmlChar*) noexcept {
      auto& self = of(data);
      self.wrong(self.line(), "a DOCTYPE is refused, and entities with it: remove it");
    };
    return sax;
  }

  void not_well_formed(const xmlError& error) {
    std::string_view text = error.message;
    while (text.ends_with('\n')) text.remove_suffix(1);
    wrong(error.line, fmt::format("not well-formed XML: {}", text));
  }

  static std::string_view value_of(const Attributes& attributes, std::string_view name) {
    const auto found = std::ranges::find(attributes, name, &Attributes::value_type::first);
    return found == attributes.end() ? std::string_view() : found->second;
  }

  void start(std::string_view name, const Attributes& attributes) {
    if (!error_.empty()) return;
    if (++elements_ > kMostElements)
      return wrong(line(), fmt::format("there are more than {} elements", kMostElements));
    if (path_.size() >= kMostElementDepth)
      return wrong(line(), fmt::format("is nested deeper than {} elements", kMostElementDepth));
    text_.clear();
    is_leaf_ = true;
    path_.emplace_back(name.substr(0, kMostCalled));
    const auto called = std::string(value_of(attributes, "name").substr(0, kMostCalled));
    if (name == "qos_library") library_ = called;
    if (name == "qos_profile") profile_ = called;
    for (const auto* const base : {"base_name", "base_profile_name"})
      if (const auto other = value_of(attributes, base); !other.empty())
        ends_.lacks.add("base", "what a profile takes from another one is not read", line(),
                        fmt::format("{} from {}", called, other.substr(0, kMostCalled)));
    const auto* const found = std::ranges::find(kEndElements, name, &EndElement::name);
    if (found == kEndElements.end() || open_) return;
    if (!found->needs.empty() && value_of(attributes, found->needs).empty()) return;
    begin(*found, attributes);
  }

  void begin(const EndElement& element, const Attributes& attributes) {
    open_ = DdsEnd{};
    open_->writes = element.writes;
    open_->line = line();
    open_depth_ = path_.size();
    deadline_ = lifespan_ = lease_ = {};
    std::string called;
    if (element.name.ends_with("_qos"))
      called = library_.empty() ? profile_ : library_ + "::" + profile_;
    for (const auto* const key : {"profile_name", "name"})
      if (const auto own = value_of(attributes, key); !own.empty()) {
        called += (called.empty() ? "" : "::") + std::string(own.substr(0, kMostCalled));
        break;
      }
    if (called.empty()) called = "unnamed";
    open_->node = fmt::format("{}-{}", element.writes ? "writer" : "reader", called);
    open_->topic = called;
    for (const auto* const key : {"topic_filter", "topic_ref"})
      if (const auto topic = value_of(attributes, key); !topic.empty())
        open_->topic = topic.substr(0, kMostCalled);
  }

  void text(std::string_view text) {
    text_ += text.substr(0, kMostLeaf - std::min(kMostLeaf, text_.size()));
  }

  void end() {
    if (!error_.empty() || path_.empty()) return;
    const auto first = text_.find_first_not_of(" \t\r\n");
    if (std::exchange(is_leaf_, false) && first != std::string::npos) {
      const auto last = text_.find_last_not_of(" \t\r\n");
      leaf(std::string_view(text_).substr(first, last - first + 1));
    }
    text_.clear();
    if (open_ && path_.size() == open_depth_) end_of_profile();
    if (path_.back() == "qos_library") library_.clear();
    if (path_.back() == "qos_profile") profile_.clear();
    path_.pop_back();
  }

  /// The path of an element within a profile, such as "deadline/period/sec", or from the root
  /// outside of one.
  [[nodiscard]] std::string where() const {
    std::string out;
    for (std::size_t i = open_ ? open_depth_ : 0; i < path_.size(); ++i)
      if (path_[i] != "qos" && !path_[i].ends_with("_qos"))
        out += (out.empty() ? "" : "/") + path_[i];
    return out.substr(0, kMostCalled);
  }

  void leaf(std::string_view value) {
    const auto at = where();
    if (!open_) {
      ends_.lacks.add("settings", "are of no data writer or data reader", line(), at);
      return;
    }
    constexpr std::string_view deadline = "deadline/period";
    constexpr std::string_view lifespan = "lifespan/duration";
    constexpr std::string_view lease = "liveliness/lease_duration";
    if (at.starts_with(deadline)) return part(at.substr(deadline.size()), value, deadline_);
    if (at.starts_with(lifespan)) return part(at.substr(lifespan.size()), value, lifespan_);
    if (at.starts_with(lease)) return part(at.substr(lease.size()), value, lease_);
    if (at == "topic/name") {
      open_->topic = value;
    } else if (at == "topic/dataType") {
      open_->type = value;
    } else {
      // "topic/historyQos/kind" of Fast DDS corresponds to "history/kind" elsewhere.
      const auto name = std::string_view(at).substr(at.starts_with("topic/") ? 6 : 0);
      open_->policies.push_back({std::string(name), std::string(value), line()});
    }
  }

  /// Takes a part of a duration: `which` is "/sec", "/nanosec", or empty for a word that states the
  /// duration.
  void part(std::string_view which, std::string_view value, DurationParts& of_duration) {
    if (value.starts_with("DURATION_INFIN") || value == "INFINITE") {
      of_duration.infinite = true;
      return;
    }
    auto number = number_in<std::uint64_t>(value);
    if (value.starts_with("DURATION_ZERO")) number = 0;
    if (!number || *number > 0xffffffffU || (which != "/sec" && which != "/nanosec"))
      return wrong(line(), fmt::format("\"{}\": must be sec or nanosec with a number, or "
                                       "DURATION_INFINITY",
                                       cut(value, 80)));
    (which == "/sec" ? of_duration.seconds : of_duration.nanoseconds) = number;
  }

  void end_of_profile() {
    auto end = *std::exchange(open_, std::nullopt);
    take_duration(deadline_.total(), end.deadline);
    take_duration(lifespan_.total(), end.lifespan);
    take_duration(lease_.total(), end.lease);
    if (const auto why = ends_.add(std::move(end)); !why.empty()) wrong(line(), why);
  }

  const std::string& file_;
  ProfileContext context_;
  std::string error_;
  DdsEnds ends_;
  std::vector<std::string> path_;  ///< names of the open elements
  std::size_t elements_ = 0;
  std::string library_;
  std::string profile_;
  std::optional<DdsEnd> open_;
  std::size_t open_depth_ = 0;
  DurationParts deadline_, lifespan_, lease_;
  std::string text_;
  bool is_leaf_ = false;
};

}  // namespace

Result<ImportedNetwork> import_dds_xml(std::string_view text, const std::string& file,
                                       const ImportOptions& options) {
  return ProfileReader(file).read(text, options);
}

}  // namespace mlcca::tools::design
