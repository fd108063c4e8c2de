// SPDX-License-Identifier: BSD-2-Clause
// What the tests of mlccactl analyse-bus share.
#pragma once
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/tools/design/check/program.hpp"

namespace mlcca {

using Json = nlohmann::json;

inline constexpr const char* kHeader = "name,id,extended,bytes,period_us,deadline_us,jitter_us\n";

class AnalyseBusTest : public test::CheckTest {
 protected:
  [[nodiscard]] std::string table(const std::string& lines) const {
    return file("bus.csv", kHeader + lines);
  }
  static test::RunOutcome analyse(const std::string& path, std::vector<std::string> options = {}) {
    options.insert(options.begin(), {"analyse-bus", path});
    return test::run(options);
  }
  /// At 125 kbit/s, where a frame of 7 bytes takes 1 ms.
  static test::RunOutcome slow(const std::string& path, std::vector<std::string> options = {}) {
    options.insert(options.end(), {"--bitrate", "125000"});
    return analyse(path, std::move(options));
  }
};

/// The one bus of an answer.
inline Json bus_of(const std::string& out) {
  const Json all = Json::parse(out);
  EXPECT_EQ(all.at("networks").size(), 1U) << out;
  return all["networks"][0];
}

/// The message of that name; null if there is none.
inline const Json& message_of(const Json& bus, const std::string& name) {
  for (const Json& m : bus["messages"])
    if (m["name"] == name) return m;
  static const Json none;
  return none;
}

}  // namespace mlcca
