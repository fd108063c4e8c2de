// SPDX-License-Identifier: BSD-2-Clause
// Builds the values from the events of libyaml in one pass. An aliased value is not copied, but the
// limits count it for each alias.
#include "tools/design/import/yaml.hpp"

#include <fmt/format.h>
#include <yaml.h>

#include <algorithm>
#include <set>
#include <unordered_map>
#include <utility>

#include "base/number.hpp"
#include "base/text.hpp"

namespace mlcca::tools::design {
namespace {

std::string_view text_of(const yaml_char_t* text) {
  return text == nullptr ? std::string_view() : reinterpret_cast<const char*>(text);
}

int line_of(const yaml_mark_t& mark) { return static_cast<int>(mark.line) + 1; }

class YamlEvent {
 public:
  YamlEvent() = default;
  ~YamlEvent() { yaml_event_delete(&event_); }
  YamlEvent(const YamlEvent&) = delete;
  YamlEvent(YamlEvent&&) = delete;
  YamlEvent& operator=(const YamlEvent&) = delete;
  YamlEvent& operator=(YamlEvent&&) = delete;
  yaml_event_t* operator->() { return &event_; }
  yaml_event_t* get() { return &event_; }

 private:
  yaml_event_t event_{};
};

}  // namespace

class YamlReader {
 public:
  YamlReader(std::string_view text, const std::string& file) : text_(text), file_(file) {
    ready_ = yaml_parser_initialize(&parser_) == 1;
    if (!ready_) return;
    yaml_parser_set_input_string(&parser_, reinterpret_cast<const unsigned char*>(text.data()),
                                 text.size());
    yaml_parser_set_encoding(&parser_, YAML_UTF8_ENCODING);
  }
  ~YamlReader() {
    if (ready_) yaml_parser_delete(&parser_);
  }
  YamlReader(const YamlReader&) = delete;
  YamlReader(YamlReader&&) = delete;
  YamlReader& operator=(const YamlReader&) = delete;
  YamlReader& operator=(YamlReader&&) = delete;

  Result<YamlText> read() {
    if (!ready_) return fail(fmt::format("{}: cannot be read: out of memory", file_));
    refuse_directives();
    for (bool more = error_.empty(); more;) {
      YamlEvent event;
      if (yaml_parser_parse(&parser_, event.get()) == 0) return fail(parser_error());
      take(event);
      more = error_.empty() && event->type != YAML_STREAM_END_EVENT;
    }
    if (!error_.empty()) return fail(error_);
    return std::move(out_);
  }

 private:
  /// A list or map that has not ended.
  struct Open {
    std::size_t value = 0;
    std::string anchor;
    std::optional<std::size_t> key;  ///< of a map, if its value comes next
  };

  void wrong(int line, const std::string& text) {
    if (error_.empty()) error_ = fmt::format("{}:{}: {}", file_, line, text);
  }

  /// Limits the %TAG directives: libyaml compares each of them with all before it.
  void refuse_directives() {
    constexpr std::size_t most = 16;
    constexpr std::string_view directive = "%TAG";
    std::size_t found = 0;
    for (auto at = text_.find(directive); at != std::string_view::npos;
         at = text_.find(directive, at + directive.size()))
      if (++found > most)
        return wrong(line_at(at), fmt::format("there are more than {} directives %TAG", most));
  }

  [[nodiscard]] int line_at(std::size_t offset) const {
    const auto before = text_.substr(0, std::min(offset, text_.size()));
    return static_cast<int>(std::ranges::count(before, '\n')) + 1;
  }

  [[nodiscard]] std::string parser_error() const {
    if (parser_.error == YAML_MEMORY_ERROR)
      return fmt::format("{}: cannot be read: out of memory", file_);
    const auto* const problem = parser_.problem == nullptr ? "is no YAML" : parser_.problem;
    const int line = parser_.error == YAML_READER_ERROR ? line_at(parser_.problem_offset)
                                                        : line_of(parser_.problem_mark);
    return fmt::format("{}:{}: neither YAML nor JSON: {}", file_, line, problem);
  }

  void take(YamlEvent& event) {
    const int line = line_of(event->start_mark);
    switch (event->type) {
      case YAML_DOCUMENT_START_EVENT:
        anchors_.clear();
        break;
      case YAML_SCALAR_EVENT:
        scalar(event, line);
        break;
      case YAML_ALIAS_EVENT:
        alias(text_of(event->data.alias.anchor), line);
        break;
      case YAML_SEQUENCE_START_EVENT:
        begin(YamlValue::Kind::list, text_of(event->data.sequence_start.anchor), line);
        break;
      case YAML_MAPPING_START_EVENT:
        begin(YamlValue::Kind::map, text_of(event->data.mapping_start.anchor), line);
        break;
      case YAML_SEQUENCE_END_EVENT:
      case YAML_MAPPING_END_EVENT:
        end();
        break;
      default:
        break;
    }
  }

  std::size_t add(YamlValue::Kind kind, int line) {
    if (out_.values_.size() >= kMostYamlValues)
      wrong(line, fmt::format("there are more than {} values", kMostYamlValues));
    out_.values_.emplace_back();
    out_.values_.back().kind = kind;
    out_.values_.back().line = line;
    return out_.values_.size() - 1;
  }

  void scalar(YamlEvent& event, int line) {
    const auto& from = event->data.scalar;
    const auto value = add(YamlValue::Kind::scalar, line);
    out_.values_[value].text.assign(reinterpret_cast<const char*>(from.value), from.length);
    if (const auto anchor = text_of(from.anchor); !anchor.empty())
      anchors_[std::string(anchor)] = value;
    const bool is_empty =
        from.length == 0 && from.style == YAML_PLAIN_SCALAR_STYLE && open_.empty();
    if (!is_empty) place(value, line);
  }

  void alias(std::string_view name, int line) {
    const auto found = anchors_.find(std::string(name));
    if (found == anchors_.end())
      return wrong(line, fmt::format("*{}: nothing before it is called &{}", name, name));
    place(found->second, line);
  }

  void begin(YamlValue::Kind kind, std::string_view anchor, int line) {
    if (open_.size() >= kMostYamlDepth) return too_deep(line);
    open_.push_back({add(kind, line), std::string(anchor), {}});
  }

  void too_deep(int line) {
    wrong(line, fmt::format("values are in each other deeper than {}", kMostYamlDepth));
  }

  void end() {
    const auto open = std::move(open_.back());
    open_.pop_back();
    auto& value = out_.values_[open.value];
    if (value.kind == YamlValue::Kind::map) {
      take_over(value);
      refuse_twice(value);
    }
    measure(value);
    if (!open.anchor.empty()) anchors_[open.anchor] = open.value;
    place(open.value, value.line);
  }

  /// Adds a complete value to the list or map that contains it.
  void place(std::size_t value, int line) {
    if (!error_.empty()) return;
    if (open_.empty()) return root(value, line);
    auto& open = open_.back();
    auto& into = out_.values_[open.value];
    if (into.kind == YamlValue::Kind::list) return into.items.push_back(value);
    if (open.key) {
      into.entries.push_back({.key = *std::exchange(open.key, {}), .value = value});
      return;
    }
    if (out_.values_[value].kind != YamlValue::Kind::scalar)
      return wrong(line, "a key is a text or a number, and no list or map");
    open.key = value;
  }

  void root(std::size_t value, int line) {
    counted_ += out_.values_[value].count;
    if (counted_ > kMostYamlValues) return too_many(line);
    out_.roots_.push_back(value);
  }

  void too_many(int line) {
    wrong(line,
          fmt::format("with what aliases name there are more than {} values", kMostYamlValues));
  }

  /// Appends the entries that "<<" names, unless the map has the same key itself.
  void take_over(YamlValue& map) {
    const auto key_of = [&](const YamlValue::Entry& entry) {
      return std::string_view(out_.values_[entry.key].text);
    };
    const auto is_merge = [&](const YamlValue::Entry& entry) { return key_of(entry) == "<<"; };
    if (std::ranges::none_of(map.entries, is_merge)) return;
    std::vector<YamlValue::Entry> own;
    std::vector<std::size_t> sources;
    std::set<std::string_view> known;
    for (const auto& entry : map.entries) {
      if (!is_merge(entry)) {
        own.push_back(entry);
        known.insert(key_of(entry));
        continue;
      }
      const auto& from = out_.values_[entry.value];
      if (from.kind == YamlValue::Kind::list)
        sources.insert(sources.end(), from.items.begin(), from.items.end());
      else
        sources.push_back(entry.value);
    }
    for (const auto source : sources) {
      const auto& from = out_.values_[source];
      if (from.kind != YamlValue::Kind::map) return wrong(map.line, "\"<<\" names maps");
      merged_ += from.entries.size() + 1;
      if (merged_ > kMostYamlValues)
        return wrong(map.line, fmt::format("\"<<\" names more than {} values", kMostYamlValues));
      for (const auto& entry : from.entries)
        if (known.insert(key_of(entry)).second) own.push_back(entry);
    }
    map.entries = std::move(own);
  }

  void refuse_twice(const YamlValue& map) {
    std::set<std::string_view> known;
    for (const auto& entry : map.entries) {
      const auto& key = out_.values_[entry.key];
      if (!known.insert(key.text).second)
        return wrong(key.line, fmt::format("\"{}\" is there twice", cut(key.text, 80)));
    }
  }

  void measure(YamlValue& value) {
    value.depth = 1;
    const auto below = [&](std::size_t index) {
      value.count += out_.values_[index].count;
      value.depth = std::max(value.depth, out_.values_[index].depth + 1);
    };
    for (const auto item : value.items) below(item);
    for (const auto& entry : value.entries) {
      below(entry.key);
      below(entry.value);
    }
    if (value.count > kMostYamlValues) too_many(value.line);
    if (value.depth > kMostYamlDepth) too_deep(value.line);
  }

  std::string_view text_;
  const std::string& file_;
  yaml_parser_t parser_{};
  bool ready_ = false;
  YamlText out_;
  std::string error_;
  std::vector<Open> open_;
  std::unordered_map<std::string, std::size_t> anchors_;
  std::size_t merged_ = 0;
  std::size_t counted_ = 0;  ///< values of the complete documents
};

const YamlValue* YamlText::find(const YamlValue& map, std::string_view key) const {
  const auto found = std::ranges::find_if(
      map.entries, [&](const YamlValue::Entry& entry) { return values_[entry.key].text == key; });
  return found == map.entries.end() ? nullptr : &values_[found->value];
}

Result<YamlText> read_yaml(std::string_view text, const std::string& file) {
  return YamlReader(text, file).read();
}

std::optional<std::uint64_t> whole_number(std::string_view text) {
  return prefixed_number_in<std::uint64_t>(text);
}

}  // namespace mlcca::tools::design
