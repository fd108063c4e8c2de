// SPDX-License-Identifier: BSD-2-Clause
// What the tests of mlccactl import share.
#pragma once
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/tools/design/describe/program.hpp"

namespace mlcca {

using Json = nlohmann::json;

class ImportTest : public ::testing::Test {
 protected:
  /// What is printed of a file with that text. The draft is left in draft_.
  test::Ran import(const std::string& name, const std::string& text,
                   std::vector<std::string> options = {}) {
    options.insert(options.begin(), {"import", folder_.write(name, text)});
    auto done = test::run(options);
    draft_ = done.out;
    return done;
  }

  /// The same as JSON, where it succeeds.
  Json json(const std::string& name, const std::string& text,
            std::vector<std::string> options = {}) {
    options.emplace_back("--json");
    const auto done = import(name, text, std::move(options));
    EXPECT_EQ(done.status, 0) << done.out << done.error;
    auto out = Json::parse(done.out);
    draft_ = out["text"];
    return out;
  }

  /// What `check` says of the draft, as JSON.
  [[nodiscard]] Json checked() const {
    return Json::parse(test::run({"check", "--json", folder_.write("draft.xml", draft_)}).out);
  }

  [[nodiscard]] bool has(const std::string& text) const {
    return draft_.find(text) != std::string::npos;
  }

  /// What stands in the draft from `begin` to the next `end`; empty: it is not there.
  [[nodiscard]] std::string part(const std::string& begin, const std::string& end) const {
    const auto at = draft_.find(begin);
    return at == std::string::npos ? "" : draft_.substr(at, draft_.find(end, at) - at);
  }

  /// How many of that kind have no counterpart.
  static std::size_t lacking(const Json& out, const std::string& kind) {
    for (const auto& lack : out["networks"][0]["no_counterpart"])
      if (lack["kind"] == kind) return lack["count"];
    return 0;
  }

  test::Folder folder_;
  std::string draft_;
};

}  // namespace mlcca
