// SPDX-License-Identifier: BSD-2-Clause
// The SARIF output against the rules of the SARIF 2.1.0 specification (OASIS), and against what
// editors and code hosts need of it.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "control/version.hpp"
#include "core/design/findings.hpp"
#include "tests/tools/design/check/program.hpp"
#include "tools/design/check/uri.hpp"

namespace mlcca {
namespace {

using Json = nlohmann::json;
using Keys = std::set<std::string>;

/// An object has these properties, and may have those; the standard allows no others.
void expect_keys(const Json& object, const Keys& needed, const Keys& allowed = {}) {
  ASSERT_TRUE(object.is_object()) << object;
  for (const auto& key : needed) EXPECT_TRUE(object.contains(key)) << key << ": " << object;
  for (const auto& [key, value] : object.items())
    EXPECT_TRUE(needed.contains(key) || allowed.contains(key)) << key << ": " << object;
}

/// 3.11: a message has a text.
void expect_message(const Json& message) {
  expect_keys(message, {"text"});
  EXPECT_FALSE(message.at("text").get<std::string>().empty());
}

/// RFC 3986: no character that must be encoded, and no dot segment.
void expect_uri(const std::string& uri) {
  EXPECT_EQ(uri.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789"
                                  "-._~:/?#[]@!$&'()*+,;=%"),
            std::string::npos)
      << uri;
  EXPECT_FALSE(("/" + uri + "/").contains("/../")) << uri;
}

/// 3.4 artifactLocation. `index` where it refers to run.artifacts.
void expect_artifact_location(const Json& location, const Json& run) {
  expect_keys(location, {"uri"}, {"uriBaseId", "index"});
  const auto uri = location.at("uri").get<std::string>();
  expect_uri(uri);
  // 3.4.4: a base is for relative ones, and is one of originalUriBaseIds.
  EXPECT_EQ(location.contains("uriBaseId"), !uri.starts_with("file:///")) << uri;
  const auto base = location.value("uriBaseId", "");
  EXPECT_TRUE(base.empty() || run.at("originalUriBaseIds").contains(base)) << base;
}

/// 3.49 reportingDescriptor.
void expect_rule(const Json& rule) {
  expect_keys(rule, {"id"},
              {"name", "shortDescription", "fullDescription", "help", "defaultConfiguration"});
  for (const auto* text : {"shortDescription", "fullDescription", "help"})
    expect_message(rule.at(text));
  // 3.49.7: a name is in one piece for people, as in NoPublisher.
  const auto name = rule.at("name").get<std::string>();
  EXPECT_EQ(name.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"),
            std::string::npos)
      << name;
  EXPECT_TRUE(name[0] >= 'A' && name[0] <= 'Z') << name;
  expect_keys(rule.at("defaultConfiguration"), {"level"});
}

/// 3.28 location.
void expect_location(const Json& location, const Json& run) {
  expect_keys(location, {"physicalLocation"}, {"logicalLocations"});
  const auto& physical = location.at("physicalLocation");
  expect_keys(physical, {"artifactLocation"}, {"region"});
  const auto& artifact = physical.at("artifactLocation");
  expect_artifact_location(artifact, run);
  // 3.4.5: the artifact of that number has the same URI.
  EXPECT_EQ(run.at("artifacts").at(artifact.at("index").get<std::size_t>())["location"]["uri"],
            artifact.at("uri"));
  if (physical.contains("region")) {
    expect_keys(physical["region"], {"startLine"});
    EXPECT_GE(physical["region"]["startLine"].get<int>(), 1);
  }
  if (!location.contains("logicalLocations")) return;
  EXPECT_FALSE(location["logicalLocations"].empty());
  for (const auto& logical : location["logicalLocations"])
    expect_keys(logical, {"name", "fullyQualifiedName", "kind"});
}

/// 3.27 result.
void expect_result(const Json& result, const Json& run) {
  expect_keys(result,
              {"ruleId", "ruleIndex", "level", "message", "locations", "partialFingerprints"},
              {"properties"});
  const auto& rules = run.at("tool").at("driver").at("rules");
  const auto& rule = rules.at(result.at("ruleIndex").get<std::size_t>());
  EXPECT_EQ(rule.at("id"), result.at("ruleId"));
  EXPECT_EQ(rule.at("defaultConfiguration").at("level"), result.at("level"));
  expect_message(result.at("message"));
  ASSERT_EQ(result.at("locations").size(), 1U);
  expect_location(result["locations"][0], run);
  for (const auto& [name, print] : result["partialFingerprints"].items())
    EXPECT_TRUE(print.is_string()) << name;
}

/// All of it; gives the run.
Json expect_sarif(const std::string& text) {
  const auto log = Json::parse(text);
  expect_keys(log, {"$schema", "version", "runs"});
  EXPECT_EQ(log.at("version"), "2.1.0");
  EXPECT_TRUE(log.at("$schema").get<std::string>().ends_with("/sarif-schema-2.1.0.json"));
  EXPECT_EQ(log.at("runs").size(), 1U);
  const auto run = log["runs"][0];
  expect_keys(run, {"tool", "results"},
              {"invocations", "originalUriBaseIds", "artifacts", "columnKind"});
  expect_keys(run.at("tool"), {"driver"});
  const auto& driver = run["tool"]["driver"];
  expect_keys(driver, {"name", "version", "semanticVersion", "rules"});
  for (const auto& rule : driver["rules"]) expect_rule(rule);
  EXPECT_EQ(run.at("invocations").size(), 1U);
  expect_keys(run["invocations"][0], {"executionSuccessful"}, {"exitCode", "exitCodeDescription"});
  EXPECT_TRUE(run["invocations"][0]["executionSuccessful"].is_boolean());
  EXPECT_EQ(run.at("columnKind"), "unicodeCodePoints");
  for (const auto& artifact : run.at("artifacts")) {
    expect_keys(artifact, {"location"}, {"roles", "mimeType", "sourceLanguage"});
    expect_artifact_location(artifact["location"], run);
    EXPECT_EQ(artifact["roles"], Json::array({"analysisTarget"}));
  }
  for (const auto& result : run.at("results")) expect_result(result, run);
  return run;
}

class SarifTest : public test::CheckTest {
 protected:
  /// Of a check that runs in the folder of the test.
  Json sarif(std::vector<std::string> files, int status) {
    files.insert(files.begin(), {"check", "--format", "sarif"});
    test::Surroundings how;
    how.folder = folder();
    const auto outcome = test::run(files, how);
    EXPECT_EQ(outcome.status, status) << outcome.error;
    auto run = expect_sarif(outcome.out);
    EXPECT_EQ(run["invocations"][0]["exitCode"], status);
    return run;
  }
  static Json artifact_of(const Json& result) {
    return result["locations"][0]["physicalLocation"]["artifactLocation"];
  }
};

TEST_F(SarifTest, DescribesEveryKindOfFindingAsARule) {
  file("s.xml", test::system_of(""));
  const auto driver = sarif({"s.xml"}, 0)["tool"]["driver"];
  EXPECT_EQ(driver["name"], "mlccactl check");
  EXPECT_EQ(driver["semanticVersion"], kVersion);
  ASSERT_EQ(driver["rules"].size(), core::finding_table().size());
  for (const auto& info : core::finding_table()) {
    const auto& rule = driver["rules"][static_cast<std::size_t>(info.id) - 1];
    EXPECT_EQ(rule["id"], core::code_of(info.id));
    const auto level = info.severity == core::Severity::error     ? "error"
                       : info.severity == core::Severity::warning ? "warning"
                                                                  : "note";
    EXPECT_EQ(rule["defaultConfiguration"]["level"], level);
  }
  EXPECT_EQ(driver["rules"][9]["name"], "NoPublisher");
  EXPECT_EQ(driver["rules"][9]["shortDescription"]["text"], "A subscription has no publisher.");
}

TEST_F(SarifTest, SaysWhatIsWrongWhere) {
  file("s.xml", test::system_of(test::delivery(2, 3)));
  const auto run = sarif({"s.xml"}, 1);
  EXPECT_EQ(run["invocations"][0]["executionSuccessful"], true);
  ASSERT_EQ(run["results"].size(), 1U);
  const auto& result = run["results"][0];
  EXPECT_EQ(result["ruleId"], "MLCCA021");
  EXPECT_EQ(result["level"], "error");
  const auto text = result["message"]["text"].get<std::string>();
  EXPECT_TRUE(text.contains("air provides 3")) << text;
  EXPECT_TRUE(text.contains(". Hint: ")) << text;
  EXPECT_EQ(artifact_of(result),
            Json({{"uri", "s.xml"}, {"uriBaseId", "%SRCROOT%"}, {"index", 0}}));
  EXPECT_EQ(result["locations"][0]["physicalLocation"]["region"]["startLine"], 5);
  Keys logical;
  for (const auto& l : result["locations"][0]["logicalLocations"])
    logical.insert(l["fullyQualifiedName"].get<std::string>());
  EXPECT_EQ(logical,
            (Keys{"channel/speed", "publisher/speed@air", "subscriber/speed@air", "place/air"}));
  EXPECT_EQ(result["properties"],
            Json({{"attribute", "Omission"}, {"required", "2"}, {"provided", "3"}}));
}

TEST_F(SarifTest, AFileAsAWholeHasNoLine) {
  const auto run = sarif({"none.xml"}, 2);
  EXPECT_EQ(run["invocations"][0]["executionSuccessful"], false);
  ASSERT_EQ(run["results"].size(), 1U);
  EXPECT_EQ(run["results"][0]["ruleId"], "MLCCA001");
  EXPECT_FALSE(run["results"][0]["locations"][0]["physicalLocation"].contains("region"));
}

TEST_F(SarifTest, FingerprintsStayWhenLinesMoveAndDifferOtherwise) {
  const auto prints = [&](const std::string& parts) {
    file("s.xml", test::system_of(parts));
    std::vector<std::string> out;
    const auto run = sarif({"s.xml"}, 1);
    for (const auto& r : run["results"])
      out.push_back(r["partialFingerprints"]["mlccaFinding/v1"].get<std::string>());
    return out;
  };
  const std::string twice =
      "<UserAttribute name=\"A\"><Better>smaller</Better><Composition>sum</Composition>"
      "</UserAttribute>\n";
  const auto parts = test::delivery(2, 3) + twice + twice + twice;
  const auto before = prints(parts);
  ASSERT_EQ(before.size(), 3U) << "one delivery, and two that repeat a name";
  EXPECT_EQ(std::set(before.begin(), before.end()).size(), 3U);
  EXPECT_EQ(prints("\n\n\n" + parts), before);
  EXPECT_NE(prints(test::delivery(2, 3)),
            prints(test::delivery(2, 3) + "<Subscriber channel=\"speed\" network=\"air\"/>\n"));
}

TEST_F(SarifTest, ReferencesAreRelativeBelowTheFolderAndAbsoluteElsewhere) {
  file("a b#%ä/x:y.xml", test::system_of("<Nothing/>"));
  const auto below = sarif({"./a b#%ä/../a b#%ä/x:y.xml"}, 2);
  EXPECT_EQ(artifact_of(below["results"][0])["uri"], "a%20b%23%25%C3%A4/x%3Ay.xml");
  const auto absolute = sarif({path("a b#%ä/x:y.xml")}, 2);
  EXPECT_EQ(artifact_of(absolute["results"][0])["uri"],
            "file://" + folder() + "/a%20b%23%25%C3%A4/x%3Ay.xml");
  EXPECT_EQ(tools::design::file_uri("../up.xml", "/srv/now").text, "file:///srv/up.xml");
  EXPECT_FALSE(tools::design::file_uri("../up.xml", "/srv/now").relative);
  EXPECT_EQ(tools::design::file_uri("c:/x.xml", "/srv").text, "c%3A/x.xml");
}

TEST_F(SarifTest, ListsEveryFileThatWasRead) {
  file("s.xml", test::system_of("<xi:include href=\"parts/n.xml\"/>\n"));
  file("parts/n.xml", "<Network name=\"air\"><Kind>mesh</Kind></Network>");
  Keys files;
  const auto run = sarif({"s.xml"}, 0);
  for (const auto& artifact : run["artifacts"])
    files.insert(artifact["location"]["uri"].get<std::string>());
  EXPECT_EQ(files, (Keys{"s.xml", "parts/n.xml"}));
}

TEST_F(SarifTest, HoldsForEveryCaseOfTheCorpus) {
  std::vector<std::string> all{"check", "--format", "sarif"};
  for (const auto& entry : std::filesystem::directory_iterator("tests/tools/design/check/cases"))
    if (entry.path().extension() == ".xml") all.push_back(entry.path().string());
  const auto run = expect_sarif(test::run(all).out);
  Keys rules;
  for (const auto& result : run["results"]) rules.insert(result["ruleId"].get<std::string>());
  // All but the one of the stylesheet.
  EXPECT_EQ(rules.size(), core::finding_table().size() - 1);
}

}  // namespace
}  // namespace mlcca
