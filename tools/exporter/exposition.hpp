// SPDX-License-Identifier: BSD-2-Clause
// Writes the text format of Prometheus, version 0.0.4.
#pragma once
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

namespace mlcca::exporter {

inline constexpr const char* kContentType = "text/plain; version=0.0.4; charset=utf-8";

/// Prometheus states times in seconds.
[[nodiscard]] inline double in_seconds(std::uint64_t ns) {
  constexpr double ns_in_a_second = 1e9;
  return static_cast<double>(ns) / ns_in_a_second;
}

/// The labels of a sample, "name=\"value\",…", with escaped values.
class Labels {
 public:
  Labels() = default;
  Labels(std::initializer_list<std::pair<std::string_view, std::string_view>> pairs) {
    for (const auto& [name, value] : pairs) add(name, value);
  }
  /// Labels from a result of text().
  static Labels made(std::string text) {
    Labels labels;
    labels.text_ = std::move(text);
    return labels;
  }
  void add(std::string_view name, std::string_view value);
  [[nodiscard]] Labels with(std::string_view name, std::string_view value) const {
    Labels more = *this;
    more.add(name, value);
    return more;
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// A metric with all its samples.
class Family {
 public:
  /// `type` is "gauge" or "counter" (then `name` ends with _total). All texts must outlive this
  /// object.
  Family(std::string_view name, std::string_view type, std::string_view help);

  void add(const Labels& labels, double value);
  void add(const Labels& labels, std::uint64_t value);
  void add(double value) { add(Labels(), value); }
  void add(std::uint64_t value) { add(Labels(), value); }
  void add(const Labels& labels, bool value) { add(labels, std::uint64_t{value ? 1U : 0U}); }
  void add(bool value) { add(Labels(), value); }

  /// The metric with its samples; empty without samples, because Prometheus then does not know it.
  [[nodiscard]] std::string text() const;
  void append_to(std::string& page) const;

 private:
  void begin(const Labels& labels);
  std::string_view name_;
  std::string_view type_;
  std::string_view help_;
  std::string samples_;
};

}  // namespace mlcca::exporter
