// SPDX-License-Identifier: BSD-2-Clause
// SARIF 2.1.0 (OASIS): one run with a rule for each kind of finding and a result for each finding.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>
#include <unordered_map>

#include "base/hash.hpp"
#include "control/version.hpp"
#include "tools/design/check/uri.hpp"
#include "tools/design/check/write.hpp"

namespace mlcca::tools::design {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSchema =
    "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json";
constexpr const char* kRoot = "%SRCROOT%";
// The name states how the fingerprint is made: another way of making it needs another version.
constexpr const char* kFingerprint = "mlccaFinding/v1";

Json message(const std::string& text) { return {{"text", text}}; }

/// "no-publisher" becomes "NoPublisher".
std::string pascal_case(std::string_view name) {
  std::string out;
  bool up = true;
  for (const char c : name) {
    if (c != '-') out += up && c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    up = c == '-';
  }
  return out;
}

/// Makes a sentence: "No way leads from a publisher to a subscriber."
std::string sentence(std::string text) {
  if (text.front() >= 'a' && text.front() <= 'z')
    text.front() = static_cast<char>(text.front() - 'a' + 'A');
  return text + ".";
}

Json rules() {
  Json out = Json::array();
  for (const auto& info : core::finding_table()) {
    const std::string advice = info.advice;
    out.push_back({{"id", core::code_of(info.id)},
                   {"name", pascal_case(info.name)},
                   {"shortDescription", message(sentence(info.title))},
                   {"fullDescription", message(sentence(info.title) + " " + advice)},
                   {"help", message(advice)},
                   {"defaultConfiguration", {{"level", to_text(info.severity)}}}});
  }
  return out;
}

/// Identifies a finding independently of line numbers: who and what is concerned. Line numbers in
/// the text are left out, too.
std::string identity_of(const ReportedFinding& f) {
  std::string out =
      fmt::format("{}\n{}\n{}\n{}\n{}\n{}\n{}\n{}\n", core::code_of(f.id), f.file, f.element,
                  f.channel, f.publisher, f.subscriber, f.place, f.attribute);
  if (!f.channel.empty() || !f.place.empty()) return out;
  constexpr std::string_view before_number = "line ";
  for (std::size_t i = 0; i < f.text.size(); ++i) {
    out += f.text[i];
    if (!out.ends_with(before_number)) continue;
    while (i + 1 < f.text.size() && f.text[i + 1] >= '0' && f.text[i + 1] <= '9') ++i;
  }
  return out;
}

class Run {
 public:
  explicit Run(const Report& report) : report_(report) {
    for (const auto& file : report.files()) add_artifact(file);
  }

  Json json() {
    for_each_finding(report_, [&](const ReportedFinding& f) { results_.push_back(result(f)); });
    const auto status = static_cast<int>(status_of(report_));
    const bool readable = report_.readable();
    const char* what_happened = "a file cannot be read";
    if (readable) what_happened = status == 0 ? "clean" : "findings";
    return {{"tool",
             {{"driver",
               {{"name", "mlccactl check"},
                {"version", kVersion},
                {"semanticVersion", kVersion},
                {"rules", rules()}}}}},
            {"invocations", Json::array({Json{{"executionSuccessful", readable},
                                              {"exitCode", status},
                                              {"exitCodeDescription", what_happened}}})},
            {"originalUriBaseIds",
             {{kRoot, {{"description", message("The folder in which the check was run.")}}}}},
            {"artifacts", std::move(artifacts_)},
            {"columnKind", "unicodeCodePoints"},
            {"results", std::move(results_)}};
  }

 private:
  static Json location_of(const std::string& file) {
    const auto uri = file_uri(file);
    Json out{{"uri", uri.text}};
    if (uri.relative) out["uriBaseId"] = kRoot;
    return out;
  }

  std::size_t add_artifact(const std::string& file) {
    const auto [known, fresh] = numbers_.try_emplace(file, artifacts_.size());
    if (fresh)
      artifacts_.push_back({{"location", location_of(file)},
                            {"roles", Json::array({"analysisTarget"})},
                            {"mimeType", "application/xml"},
                            {"sourceLanguage", "xml"}});
    return known->second;
  }

  Json physical_location(const ReportedFinding& f) {
    const auto number = add_artifact(f.file);
    auto artifact = artifacts_[number]["location"];
    artifact["index"] = number;
    Json out{{"artifactLocation", std::move(artifact)}};
    if (f.line > 0) out["region"] = {{"startLine", f.line}};
    return out;
  }

  static Json logical_locations(const ReportedFinding& f) {
    Json out = Json::array();
    const auto add = [&](const char* kind, const std::string& name) {
      if (!name.empty())
        out.push_back({{"name", name},
                       {"fullyQualifiedName", fmt::format("{}/{}", kind, name)},
                       {"kind", kind}});
    };
    add("channel", f.channel);
    add("publisher", f.publisher);
    add("subscriber", f.subscriber);
    add("place", f.place);
    return out;
  }

  Json result(const ReportedFinding& f) {
    const auto& info = core::info(f.id);
    auto text = f.element.empty() ? f.text : fmt::format("<{}>: {}", f.element, f.text);
    if (!f.hint.empty()) text += ". Hint: " + f.hint;
    Json location{{"physicalLocation", physical_location(f)}};
    if (auto logical = logical_locations(f); !logical.empty())
      location["logicalLocations"] = std::move(logical);
    const auto identity = identity_of(f);
    // Identical findings are distinguished by their order.
    const auto print = fmt::format("{:016x}:{}", hash_of(identity), ++prints_[identity]);
    Json out{{"ruleId", core::code_of(f.id)},
             {"ruleIndex", &info - core::finding_table().data()},
             {"level", to_text(info.severity)},
             {"message", message(text)},
             {"locations", Json::array({std::move(location)})},
             {"partialFingerprints", {{kFingerprint, print}}}};
    if (!f.attribute.empty())
      out["properties"] = {
          {"attribute", f.attribute}, {"required", f.required}, {"provided", f.provided}};
    return out;
  }

  const Report& report_;
  Json artifacts_ = Json::array();
  Json results_ = Json::array();
  std::unordered_map<std::string, std::size_t> numbers_;  ///< index of each artifact
  std::unordered_map<std::string, unsigned> prints_;
};

}  // namespace

std::string write_sarif(const Report& report) {
  const Json log{
      {"$schema", kSchema}, {"version", "2.1.0"}, {"runs", Json::array({Run(report).json()})}};
  return log.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace mlcca::tools::design
