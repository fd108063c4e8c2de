// SPDX-License-Identifier: BSD-2-Clause
// Reads a DBC file, one statement after the other.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <unordered_map>
#include <utility>

#include "base/number.hpp"
#include "base/text.hpp"
#include "tools/design/import/dbc.hpp"
#include "tools/design/import/dbc_attributes.hpp"
#include "tools/design/import/dbc_scan.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::string_view kNobody = "Vector__XXX";
/// The message to which tools of Vector assign signals without a message.
constexpr std::string_view kNoMessage = "VECTOR__INDEPENDENT_SIG_MSG";
constexpr std::uint32_t kNoMessageId = 0xc0000000;
constexpr std::size_t kMostSenders = 256;  // of one message

/// Whether a word begins a statement, and so is not the name of a node.
bool is_keyword(std::string_view word) {
  constexpr auto all = std::to_array<std::string_view>(
      {"NS_", "BS_", "BU_", "BO_", "SG_", "EV_", "CM_", "BA_", "VAL_", "VERSION"});
  return std::ranges::any_of(all, [&](std::string_view one) { return word == one; }) ||
         (word.ends_with('_') && std::ranges::any_of(all, [&](std::string_view one) {
            return one.ends_with('_') && word.starts_with(one);
          }));
}

bool is_number(std::string_view word) {
  return word.find_first_not_of("0123456789.+-") == std::string_view::npos;
}

class DbcReader {
 public:
  DbcReader(std::string_view text, const std::string& file) : scan_(text), file_(file) {}

  Result<DbcFile> read() {
    while (scan_.peek().kind != DbcToken::Kind::end) {
      statement();
      if (!error_.empty()) return fail(error_);
    }
    if (scan_.unclosed() != 0)
      return fail(fmt::format("{}:{}: these quotes are never closed", file_, scan_.unclosed()));
    if (out_.messages.empty())
      return fail(fmt::format(
          "{}: there is no message in it: a DBC file has lines such as \"BO_ 256 Name: 8 Node\"",
          file_));
    if (bit_timing_ && (!out_.baudrate || out_.baudrate->empty() || out_.baudrate == "0"))
      out_.baudrate = bit_timing_;
    definitions_.complete(out_);
    for (const auto& message : out_.messages)
      if (message.signals != 0)
        lack("signals", "have no counterpart: a channel has whole messages", message.line,
             fmt::format("{}: {}", message.name, message.signals));
    for (const auto& [name, seen] : unused_)
      lack("attributes", "have no counterpart; how many values of each", seen.line,
           fmt::format("{}: {}", name, seen.count));
    for (const auto& [name, seen] : other_)
      lack("statements", "have no counterpart; how many of each", seen.line,
           fmt::format("{}: {}", name, seen.count));
    return std::move(out_);
  }

 private:
  struct Seen {
    int line = 0;
    std::size_t count = 0;
  };

  void lack(std::string_view kind, std::string_view what, int line, std::string item) {
    out_.lacks.add(kind, what, line, std::move(item));
  }

  void wrong(int line, const std::string& text) {
    if (error_.empty()) error_ = fmt::format("{}:{}: {}", file_, line, text);
  }

  void wrong(const DbcToken& found, const char* expected) {
    if (scan_.unclosed() != 0) return wrong(scan_.unclosed(), "these quotes are never closed");
    wrong(found.line, found.kind == DbcToken::Kind::end
                          ? fmt::format("the file ends where {} must follow", expected)
                          : fmt::format("\"{}\": must be {}", cut(found.text, 40), expected));
  }

  static void see(std::map<std::string, Seen>& in, std::string name, int line) {
    if (in.size() >= 1000 && !in.contains(name)) name = "others";
    auto& seen = in[std::move(name)];
    if (seen.count++ == 0) seen.line = line;
  }

  /// Reads a number. Gives 0 and sets the error if the next word is not one.
  template <class Number>
  Number number(const char* what) {
    const auto token = scan_.take();
    const auto value =
        token.kind == DbcToken::Kind::word ? number_in<Number>(token.text) : std::nullopt;
    if (!value) wrong(token, what);
    return value.value_or(0);
  }

  std::string_view word(const char* what) {
    const auto token = scan_.take();
    if (token.kind != DbcToken::Kind::word) wrong(token, what);
    return token.text;
  }

  void mark(char wanted, const char* what) {
    const auto token = scan_.take();
    if (!token.is(wanted)) wrong(token, what);
  }

  void statement() {
    const auto token = scan_.take();
    // Names of the section NS_ stand alone on their lines, not always after a blank.
    if (token.first && scan_.peek().first && token.kind == DbcToken::Kind::word)
      return alone(token);
    in_names_ = token.is_word("NS_");
    if (token.is_word("BO_")) return message(token.line);
    if (token.is_word("SG_")) return signal();
    if (token.is_word("BU_")) return nodes();
    if (token.is_word("BO_TX_BU_")) return senders();
    if (token.is_word("CM_")) return comment();
    if (token.is_word("BA_DEF_")) return definition();
    if (token.is_word("BA_DEF_DEF_")) return default_value();
    if (token.is_word("BA_")) return value();
    if (token.is_word("BS_")) return bit_timing();
    if (token.is_word("VERSION")) return scan_.skip_line();
    if (token.is_word("NS_")) {
      scan_.skip_line();
      scan_.skip_indented();
      return;
    }
    if (token.is(';')) return;
    if (token.kind == DbcToken::Kind::word && token.first && !is_number(token.text)) {
      see(other_, std::string(cut(token.text, 40)), token.line);
      scan_.skip_statement();
      return;
    }
    wrong(token, "a statement such as BO_, SG_ or BA_, at the begin of a line");
  }

  void alone(const DbcToken& token) {
    if (!in_names_)
      lack("alone", "stand alone on a line: left out", token.line,
           std::string(cut(token.text, 40)));
  }

  void message(int line) {
    DbcMessage next;
    next.line = line;
    next.id = number<std::uint32_t>("the identifier of a message, 0 to 4294967295");
    next.name = word("the name of a message");
    mark(':', "':' behind the name of a message");
    next.bytes = number<std::uint32_t>("the size of a message in bytes");
    current_.reset();
    known_sender(next);
    if (!error_.empty()) return;
    is_none_ = next.name == kNoMessage || next.id == kNoMessageId;
    if (is_none_)
      return lack("no-message", "signals of no message: left out", line, std::move(next.name));
    if (!by_id_.try_emplace(next.id, out_.messages.size()).second)
      return lack("repeated", "another message has the identifier: left out", line, next.name);
    if (out_.messages.size() >= kMostMessages)
      return wrong(line, fmt::format("there are more than {} messages", kMostMessages));
    current_ = out_.messages.size();
    out_.messages.push_back(std::move(next));
  }

  /// Reads the sender if there is one, because some tools leave it out.
  void known_sender(DbcMessage& message) {
    if (scan_.peek().first || scan_.peek().kind != DbcToken::Kind::word) return;
    if (const auto node = node_called(scan_.take())) message.senders.push_back(*node);
  }

  std::optional<std::size_t> node_called(const DbcToken& token) {
    if (token.text == kNobody) return std::nullopt;
    const auto [known, is_new] =
        node_numbers_.try_emplace(std::string(token.text), out_.nodes.size());
    if (!is_new) return known->second;
    if (out_.nodes.size() >= kMostNodes) {
      wrong(token.line, fmt::format("there are more than {} nodes", kMostNodes));
      return std::nullopt;
    }
    out_.nodes.push_back(
        {.name = std::string(token.text), .comment = {}, .address = {}, .long_name = {}});
    return known->second;
  }

  /// Reads "BS_: 500 : BTR1, BTR2": the bit rate, and the registers of a controller.
  void bit_timing() {
    const auto rate = [this] { return scan_.peek().kind == DbcToken::Kind::word; };
    if (scan_.peek().is(':') && !scan_.peek().first) scan_.take();
    if (scan_.peek().first) return;
    const auto line = scan_.peek().line;
    if (rate()) bit_timing_ = scan_.take().text;
    if (!scan_.peek().first && scan_.peek().kind != DbcToken::Kind::end)
      lack("bit-timing", "has no counterpart: only the bit rate is used", line, "BS_");
    scan_.skip_line();
  }

  void nodes() {
    mark(':', "':' behind BU_");
    // The names may continue in further lines, which then begin with a blank.
    while (error_.empty() && scan_.peek().kind == DbcToken::Kind::word &&
           (!scan_.peek().first || (scan_.is_indented() && !is_keyword(scan_.peek().text)))) {
      const auto token = scan_.take();
      const auto known = out_.nodes.size();
      node_called(token);
      if (error_.empty() && token.text != kNobody && out_.nodes.size() == known)
        lack("repeated-nodes", "a node has this name already: they are one", token.line,
             std::string(cut(token.text, 60)));
    }
  }

  void signal() {
    const auto line = scan_.peek().line;
    const auto name = word("the name of a signal");
    if (!current_)
      lack("no-message", "signals of no message: left out", line, std::string(cut(name, 60)));
    bool multiplexed = false;
    while (error_.empty() && !scan_.peek().is(':')) {
      if (scan_.peek().first || scan_.peek().kind != DbcToken::Kind::word)
        return wrong(scan_.peek(), "':' behind the name of a signal");
      scan_.take();
      multiplexed = true;  // "M", "m0" or "m0M"
    }
    if (!error_.empty()) return;
    // Skips bits, factor and range, up to the unit.
    while (scan_.peek().kind != DbcToken::Kind::text) {
      if (scan_.peek().first || scan_.peek().kind == DbcToken::Kind::end)
        return wrong(line, "a signal has a unit in quotes, perhaps an empty one (\"\")");
      scan_.take();
    }
    scan_.take();
    receivers(multiplexed);
  }

  void receivers(bool multiplexed) {
    auto* message = current_ ? &out_.messages[*current_] : nullptr;
    if (message != nullptr) {
      ++message->signals;
      message->multiplexed = message->multiplexed || multiplexed;
    }
    bool goes_on = false;  // the list continues on the next line after a comma
    while (error_.empty() && (!scan_.peek().first || goes_on) &&
           scan_.peek().kind != DbcToken::Kind::end) {
      const auto token = scan_.take();
      goes_on = token.is(',');
      if (token.kind != DbcToken::Kind::word || message == nullptr) continue;
      const auto node = node_called(token);
      if (!node || !is_first_time(*node)) continue;
      if (++receivers_ > kMostReceivers)
        return wrong(token.line, fmt::format("there are more than {} receivers", kMostReceivers));
      message->receivers.push_back(*node);
    }
  }

  /// Whether this is the first signal of current_ that the node receives.
  bool is_first_time(std::size_t node) {
    if (node >= received_.size()) received_.resize(node + 1, kMostMessages);
    return std::exchange(received_[node], *current_) != *current_;
  }

  DbcMessage* message_with(std::uint32_t id) {
    const auto found = by_id_.find(id);
    return found == by_id_.end() ? nullptr : &out_.messages[found->second];
  }

  void senders() {
    const auto line = scan_.peek().line;
    const auto id = number<std::uint32_t>("the identifier of a message");
    auto* message = message_with(id);
    if (message == nullptr && error_.empty()) unknown(line, "BO_TX_BU_", fmt::format("BO_ {}", id));
    while (error_.empty() && !scan_.peek().is(';') && scan_.peek().kind != DbcToken::Kind::end) {
      const auto token = scan_.take();
      if (token.kind != DbcToken::Kind::word) continue;
      const auto node = node_called(token);
      if (node && message != nullptr && message->senders.size() < kMostSenders &&
          std::ranges::find(message->senders, *node) == message->senders.end())
        message->senders.push_back(*node);
    }
    scan_.skip_statement();
  }

  /// The object of a CM_ or BA_ statement, read from its start.
  struct About {
    DbcObject object = DbcObject::network;
    DbcMessage* message = nullptr;
    DbcNode* node = nullptr;
    std::string unknown;  ///< name of a message or node that does not exist
  };

  About about() {
    About out;
    const auto token = scan_.peek();
    if (token.kind != DbcToken::Kind::word) return out;
    if (token.text == "BU_") {
      scan_.take();
      out.object = DbcObject::node;
      const auto name = word("the name of a node");
      const auto found = node_numbers_.find(std::string(name));
      if (found != node_numbers_.end())
        out.node = &out_.nodes[found->second];
      else
        out.unknown = fmt::format("BU_ {}", cut(name, 60));
    } else if (token.text == "BO_" || token.text == "SG_") {
      scan_.take();
      out.object = token.text == "BO_" ? DbcObject::message : DbcObject::signal;
      const auto id = number<std::uint32_t>("the identifier of a message");
      out.message = message_with(id);
      // Statements about kNoMessage are skipped like its signals.
      if (out.message == nullptr && id != kNoMessageId)
        out.unknown = fmt::format("{} {}", token.text, id);
      if (out.object == DbcObject::signal) word("the name of a signal");
    } else if (token.text == "EV_") {
      scan_.take();
      out.object = DbcObject::other;
      word("the name of an environment variable");
    }
    return out;
  }

  void comment() {
    const int line = scan_.peek().line;
    const auto to = about();
    if (error_.empty() && scan_.peek().kind != DbcToken::Kind::text)
      wrong(scan_.peek(), "a comment in quotes");
    if (scan_.unclosed() != 0) return;
    if (!error_.empty()) {
      // The statement is of no use here, so it is no reason to refuse the file.
      lack("comments", "have no place, or are not understood", line, std::exchange(error_, {}));
      scan_.skip_statement();
      return;
    }
    const auto text = scan_.take();
    if (!to.unknown.empty()) unknown(text.line, "CM_", to.unknown);
    if (to.object == DbcObject::node && to.node != nullptr)
      to.node->comment = without_backslashes(text.text);
    if (to.object == DbcObject::message && to.message != nullptr)
      to.message->comment = without_backslashes(text.text);
    if (to.object != DbcObject::node && to.object != DbcObject::message && to.unknown.empty())
      lack("comments", "have no place, or are not understood", text.line,
           std::string(cut(text.text, 60)));
    scan_.skip_statement();
  }

  void unknown(int line, std::string_view what, std::string_view of) {
    lack("unknown", "are of messages and nodes that do not exist: left out", line,
         fmt::format("{}: {}", cut(what, 60), of));
  }

  DbcObject object() {
    const auto token = scan_.peek();
    if (token.kind != DbcToken::Kind::word) return DbcObject::network;
    scan_.take();
    if (token.text == "BO_") return DbcObject::message;
    if (token.text == "BU_") return DbcObject::node;
    if (token.text == "SG_") return DbcObject::signal;
    return DbcObject::other;
  }

  void definition() {
    const auto what = object();
    const auto name = scan_.take();
    if (name.kind != DbcToken::Kind::text) return wrong(name, "the name of an attribute in quotes");
    std::vector<std::string> words;
    while (!scan_.peek().is(';') && scan_.peek().kind != DbcToken::Kind::end)
      if (const auto token = scan_.take();
          token.kind == DbcToken::Kind::text && words.size() < 1000)
        words.emplace_back(token.text);
    if (!definitions_.define(what, name.text, std::move(words)))
      return wrong(name.line, "more than 4096 attributes are defined");
    scan_.skip_statement();
  }

  void default_value() {
    const auto name = scan_.take();
    if (name.kind != DbcToken::Kind::text) return wrong(name, "the name of an attribute in quotes");
    const auto value = scan_.take();
    if (value.kind == DbcToken::Kind::word || value.kind == DbcToken::Kind::text)
      if (!definitions_.set_default(name.text, without_backslashes(value.text)))
        lack("undefined", "defaults of attributes that are not defined: left out", name.line,
             std::string(cut(name.text, 60)));
    if (!value.is(';')) scan_.skip_statement();
  }

  void value() {
    const auto name = scan_.take();
    if (name.kind != DbcToken::Kind::text) return wrong(name, "the name of an attribute in quotes");
    const auto to = about();
    if (!error_.empty()) return;
    const auto value = scan_.take();
    if (value.kind != DbcToken::Kind::word && value.kind != DbcToken::Kind::text)
      return wrong(value, "the value of the attribute");
    keep(to, name, without_backslashes(value.text));
    scan_.skip_statement();
  }

  void keep(const About& to, const DbcToken& name, std::string value) {
    const auto role = role_of(to.object, name.text);
    DbcValue* place = nullptr;
    if (role == DbcRole::none) return see(unused_, std::string(cut(name.text, 60)), name.line);
    if (!to.unknown.empty()) unknown(name.line, name.text, to.unknown);
    if (to.message != nullptr && to.object == DbcObject::signal)
      return keep_of_signal(values_of_signals(*to.message, role), std::move(value));
    if (to.message != nullptr) place = place_of(*to.message, role);
    if (to.node != nullptr) place = place_of(*to.node, role);
    if (to.object == DbcObject::network) place = place_of(out_, role);
    // 0 stands for a time or rate that is not stated; of an address it is a value like others.
    const bool is_address = role == DbcRole::address;
    if (place == nullptr || (*place && !(*place)->empty() && (is_address || *place != "0"))) return;
    *place = std::move(value);
    if (is_address) to.node->address_line = name.line;
  }

  static void keep_of_signal(DbcSignalValues* values, std::string value) {
    if (values == nullptr) return;
    ++values->stated;
    values->different.insert(std::move(value));
  }

  DbcScanner scan_;
  const std::string& file_;
  DbcFile out_;
  std::string error_;
  DbcDefinitions definitions_;
  std::optional<std::size_t> current_;  ///< the message to which signals belong
  bool is_none_ = false;                ///< they belong to kNoMessage
  bool in_names_ = false;               ///< within the section NS_
  std::unordered_map<std::uint32_t, std::size_t> by_id_;
  std::unordered_map<std::string, std::size_t> node_numbers_;
  std::map<std::string, Seen> unused_;
  std::map<std::string, Seen> other_;
  std::size_t receivers_ = 0;
  DbcValue bit_timing_;                ///< bit rate of BS_
  std::vector<std::size_t> received_;  ///< by node, the latest message that it receives
};

}  // namespace

Result<DbcFile> read_dbc(std::string_view text, const std::string& file) {
  return DbcReader(text, file).read();
}

}  // namespace mlcca::tools::design
