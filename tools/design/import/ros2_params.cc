// SPDX-License-Identifier: BSD-2-Clause
// Reads parameters of ROS 2: NODE, ros__parameters, and below it names whose parts are joined by
// dots, such as qos_overrides./TOPIC.publisher.deadline.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "base/text.hpp"
#include "tools/design/import/dds.hpp"
#include "tools/design/import/text.hpp"
#include "tools/design/import/yaml.hpp"

namespace mlcca::tools::design {
namespace {

constexpr std::string_view kParameters = "ros__parameters";
constexpr std::string_view kOverrides = "qos_overrides";
constexpr std::size_t kMostPath = 1'024;  // bytes of a name

class ParamsReader {
 public:
  ParamsReader(const YamlText& yaml, const std::string& file) : yaml_(yaml), file_(file) {}

  Result<ImportedNetwork> read(const ImportOptions& options) {
    for (const auto root : yaml_.roots()) above(yaml_.at(root), {});
    for (auto& [key, end] : found_) {
      const int line = end.line;
      if (const auto why = ends_.add(std::move(end)); !why.empty()) wrong(line, why);
    }
    return ends_.take(file_, options, error_,
                      "there is no quality of service in it: parameters are such as "
                      "\"qos_overrides./TOPIC.publisher.deadline\"");
  }

 private:
  void wrong(int line, const std::string& text) {
    if (error_.empty()) error_ = fmt::format("{}:{}: {}", file_, line, text);
  }

  /// Reads maps above ros__parameters, whose keys are namespaces and names of nodes.
  void above(const YamlValue& value, const std::string& path) {
    if (value.kind != YamlValue::Kind::map)
      return wrong(value.line, "must be a node with \"ros__parameters\"");
    for (const auto& entry : value.entries) {
      const auto& key = yaml_.at(entry.key);
      const auto& below = yaml_.at(entry.value);
      if (key.text == kParameters) {
        parameters(below, node_called(path, key.line), {});
      } else if (key.text.starts_with(kOverrides)) {
        parameters(value, node_called(path, key.line), {});
        return;
      } else {
        const bool joins = !path.empty() && !path.ends_with('/') && !key.text.starts_with('/');
        above(below, bounded(path + (joins ? "/" : "") + key.text));
      }
      if (!error_.empty()) return;
    }
  }

  static std::string bounded(std::string_view path) { return std::string(cut(path, kMostPath)); }

  std::string node_called(const std::string& path, int line) {
    if (path.contains('*')) {
      ends_.lacks.add("any-node", "holds for several nodes: one stands for them", line, path);
      return "any-node";
    }
    if (path.empty()) {
      auto name = stem_of_file(file_);
      ends_.lacks.add("no-node", "no node is named: the name of the file is taken", line, name);
      return name;
    }
    return path.substr(path.starts_with('/') ? 1 : 0);
  }

  void parameters(const YamlValue& value, const std::string& node, const std::string& path) {
    if (value.kind == YamlValue::Kind::map) {
      for (const auto& entry : value.entries) {
        const auto& key = yaml_.at(entry.key);
        parameters(yaml_.at(entry.value), node,
                   bounded(path.empty() ? key.text : path + "." + key.text));
      }
      return;
    }
    if (!path.starts_with(kOverrides)) {
      ends_.lacks.add("parameters", "have no counterpart", value.line, std::string(cut(path, 80)));
      return;
    }
    policy(value, node, std::string_view(path).substr(kOverrides.size()));
  }

  /// Reads ".TOPIC.publisher.POLICY", where a name may follow "publisher".
  void policy(const YamlValue& value, const std::string& node, std::string_view path) {
    const auto dot = path.rfind('.');
    const auto before = path.substr(0, dot == std::string_view::npos ? 0 : dot);
    const auto second = before.rfind('.');
    const auto entity = second == std::string_view::npos ? "" : before.substr(second + 1);
    const bool writes = entity.starts_with("publisher");
    if (second == std::string_view::npos || second == 0 ||
        (!writes && !entity.starts_with("subscription")))
      return wrong(value.line, fmt::format("\"{}{}\": must be {}./TOPIC.publisher.POLICY, or "
                                           "subscription",
                                           kOverrides, cut(path, 80), kOverrides));
    auto& end = found_[{node, std::string(before)}];
    if (end.line == 0) {
      end.line = value.line;
      end.writes = writes;
      end.node = node;
      end.topic = before.substr(1, second - 1);
    }
    state(value, path.substr(dot + 1), end);
  }

  void state(const YamlValue& value, std::string_view name, DdsEnd& end) {
    std::optional<Value>* duration = nullptr;
    if (name == "deadline") duration = &end.deadline;
    if (name == "lifespan") duration = &end.lifespan;
    if (name == "liveliness_lease_duration") duration = &end.lease;
    if (duration == nullptr) {
      end.policies.push_back({std::string(name), value.text, value.line});
      return;
    }
    if (take_duration(whole_number(value.text), *duration) == DdsDuration::no_number)
      wrong(value.line, fmt::format("{}: must be a number of nanoseconds", name));
  }

  const YamlText& yaml_;
  const std::string& file_;
  std::string error_;
  DdsEnds ends_;
  /// by node, and by topic with entity
  std::map<std::pair<std::string, std::string>, DdsEnd> found_;
};

}  // namespace

Result<ImportedNetwork> import_ros2_params(std::string_view text, const std::string& file,
                                           const ImportOptions& options) {
  return read_as_utf8(text, [&](std::string_view readable) -> Result<ImportedNetwork> {
    const auto yaml = read_yaml(readable, file);
    if (!yaml) return std::unexpected(yaml.error());
    return ParamsReader(*yaml, file).read(options);
  });
}

}  // namespace mlcca::tools::design
