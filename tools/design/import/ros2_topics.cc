// SPDX-License-Identifier: BSD-2-Clause
// Reads the output of `ros2 topic info --verbose`. It does not contain the name of the topic, which
// is in a line before it or is the name of the file.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "base/number.hpp"
#include "base/text.hpp"
#include "tools/design/import/dds.hpp"
#include "tools/design/import/text.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::size_t kMostTopicLine = 4'096;
/// Keys whose values are not needed.
constexpr auto kSilentKeys = std::to_array<std::string_view>(
    {"Publisher count", "Subscription count", "Topic type hash", "GID", "QoS profile"});
/// Keys of policies that have no counterpart.
constexpr auto kListedKeys =
    std::to_array<std::string_view>({"Reliability", "History (Depth)", "Durability", "Liveliness"});

class TopicsReader {
 public:
  TopicsReader(std::string_view text, const std::string& file) : rest_(text), file_(file) {}

  Result<ImportedNetwork> read(const ImportOptions& options) {
    while (!rest_.empty() && error_.empty()) {
      ++line_;
      const auto size = std::min(rest_.find('\n'), rest_.size());
      take(without_blanks(rest_.substr(0, size)));
      rest_.remove_prefix(std::min(size + 1, rest_.size()));
    }
    end_of_topic();
    return ends_.take(file_, options, error_,
                      "there is no publisher or subscription in it: print it with \"ros2 topic "
                      "info --verbose\"");
  }

 private:
  void wrong(std::string_view text) {
    if (error_.empty()) error_ = fmt::format("{}:{}: {}", file_, line_, text);
  }

  void take(std::string_view line) {
    if (line.empty()) return;
    if (line.size() > kMostTopicLine)
      return wrong(fmt::format("a line has at most {} bytes", kMostTopicLine));
    if (names_topic(line)) return;
    const auto colon = line.find(": ");
    const auto key = line.substr(
        0, colon == std::string_view::npos && line.ends_with(':') ? line.size() - 1 : colon);
    const auto value = colon == std::string_view::npos ? std::string_view()
                                                       : without_blanks(line.substr(colon + 2));
    if (key == "Type") return begin_topic(value);
    if (key == "Node name") return begin_endpoint(value);
    if (std::ranges::find(kSilentKeys, key) != kSilentKeys.end()) return;
    if (!open_ || !of_endpoint(key, value))
      ends_.lacks.add("lines", "are not understood", line_, std::string(cut(line, 80)));
  }

  /// Whether the line names a topic: "/chatter", "Topic: /chatter" or "$ ros2 topic info -v
  /// /chatter".
  bool names_topic(std::string_view line) {
    const bool is_command = line.contains("ros2 topic info");
    if (!is_command && line.starts_with("Topic: /")) line.remove_prefix(7);
    const auto at = is_command ? line.find(" /") + 1 : 0;
    if (at >= line.size() || line[at] != '/') return is_command;
    const auto name = line.substr(at, line.find(' ', at) - at);
    if (!is_command && name.size() != line.size()) return false;
    if (name == next_topic_) return true;
    end_of_topic();
    next_topic_ = name;
    named_at_ = line_;
    return true;
  }

  /// Lists a topic without a publisher and a subscription.
  void end_of_topic() {
    end_of_endpoint();
    if (next_topic_.empty() && !is_empty_) return;
    ends_.lacks.add("no-ends", "has no publisher and no subscription: left out", named_at_,
                    next_topic_.empty() ? topic_ : next_topic_);
    next_topic_.clear();
    is_empty_ = false;
  }

  void begin_topic(std::string_view type) {
    if (next_topic_.empty()) end_of_topic();
    if (next_topic_.empty() && topics_ > 0)
      return wrong("which topic is this? Put its name on a line in front of \"Type:\"");
    topic_ = std::exchange(next_topic_, {});
    if (topic_.empty()) {
      topic_ = "/" + stem_of_file(file_);
      named_at_ = line_;
      ends_.lacks.add("no-topic", "its name is not stated: that of the file is taken", line_,
                      topic_);
    }
    type_ = type;
    is_empty_ = true;
    ++topics_;
  }

  void begin_endpoint(std::string_view name) {
    end_of_endpoint();
    if (topics_ == 0) begin_topic({});
    is_empty_ = false;
    open_ = DdsEnd{};
    open_->line = line_;
    open_->topic = topic_;
    open_->type = type_;
    name_ = name;
  }

  bool of_endpoint(std::string_view key, std::string_view value) {
    if (key == "Node namespace") {
      space_ = value;
    } else if (key == "Topic type") {
      open_->type = value;
    } else if (key == "Endpoint type") {
      is_stated_ = value == "PUBLISHER" || value == "SUBSCRIPTION";
      if (!is_stated_) wrong("an endpoint is PUBLISHER or SUBSCRIPTION");
      open_->writes = value == "PUBLISHER";
    } else if (key == "Lifespan") {
      duration(key, value, open_->lifespan);
    } else if (key == "Deadline") {
      duration(key, value, open_->deadline);
    } else if (key == "Liveliness lease duration") {
      duration(key, value, open_->lease);
    } else if (std::ranges::find(kListedKeys, key) != kListedKeys.end()) {
      open_->policies.push_back({std::string(key), std::string(value), line_});
    } else {
      return false;
    }
    return true;
  }

  /// Parses "Infinite" or "100000000 nanoseconds".
  void duration(std::string_view key, std::string_view value, std::optional<Value>& to) {
    if (value == "Infinite") return;
    auto rest = value;
    const auto number = take_number<std::uint64_t>(rest);
    const bool is_time = rest.empty() || rest == " nanoseconds";
    if (take_duration(is_time ? number : std::nullopt, to) == DdsDuration::no_number)
      wrong(fmt::format("{}: must be Infinite or a number of nanoseconds", key));
  }

  void end_of_endpoint() {
    if (!open_) return;
    auto end = *std::exchange(open_, std::nullopt);
    if (!std::exchange(is_stated_, false)) return wrong("the endpoint before has no Endpoint type");
    // The namespace is "/" or has the form "/robot".
    end.node = fmt::format("{}/{}", space_ == "/" ? "" : space_, name_).substr(1);
    if (end.node.empty()) end.node = "unnamed-node";
    space_.clear();
    if (const auto why = ends_.add(std::move(end)); !why.empty()) wrong(why);
  }

  std::string_view rest_;
  const std::string& file_;
  int line_ = 0;
  std::string error_;
  DdsEnds ends_;
  std::size_t topics_ = 0;
  std::string next_topic_;
  int named_at_ = 0;       ///< line of the latest topic
  bool is_empty_ = false;  ///< topic_ has no endpoint yet
  std::string topic_;
  std::string type_;
  std::optional<DdsEnd> open_;
  std::string name_;   ///< name of the node of open_
  std::string space_;  ///< namespace of that node
  bool is_stated_ = false;
};

}  // namespace

Result<ImportedNetwork> import_ros2_topics(std::string_view text, const std::string& file,
                                           const ImportOptions& options) {
  return read_as_utf8(
      text, [&](std::string_view readable) { return TopicsReader(readable, file).read(options); });
}

}  // namespace mlcca::tools::design
