// SPDX-License-Identifier: BSD-2-Clause
// Code is generated in time that grows with the description, and not with its square.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <CLI/App.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/tools/design/comparisons/compared.hpp"
#include "tools/design/verbs.hpp"

namespace mlcca::test {
namespace {

namespace fs = std::filesystem;

std::string attribute(const char* name, const char* unit, int magnitude, int value) {
  return fmt::format(
      "<Attribute><Name>{0}</Name><Dimension><SIUnit><{1}>1</{1}></SIUnit><Magnitude>{2}</"
      "Magnitude></Dimension><Value>{3}</Value></Attribute>",
      name, unit, magnitude, value);
}

/// So many buses, each with a bit rate and nothing stated, with four channels between two
/// components each.
std::string system(int buses) {
  std::string out = "<System name=\"s\">\n";
  for (int b = 0; b < buses; ++b) {
    std::string bindings;
    std::string ends[2];  // NOLINT(*-c-arrays)
    for (int c = 4 * b; c < 4 * b + 4; ++c) {
      out += fmt::format(
          "<EventChannel name=\"c{0}\"><SubjectUID>{1:#x}</SubjectUID><Attributes>{2}{3}</"
          "Attributes></EventChannel>\n",
          c, c + 1, attribute("Period", "Seconds", -3, 50), attribute("MaxPayload", "Bytes", 0, 8));
      bindings += fmt::format("<Binding channel=\"c{}\"><ETag>{:#x}</ETag></Binding>", c, 100 + c);
      ends[0] += fmt::format("<Publisher channel=\"c{}\"/>", c);
      ends[1] += fmt::format("<Subscriber channel=\"c{}\"/>", c);
    }
    out += fmt::format(
        "<Network name=\"n{0}\"><Kind>can</Kind><Profile>famouso</Profile><Bus bitrate=\"500000\"/>"
        "{1}</Network>\n<Component name=\"from{0}\" network=\"n{0}\" node=\"1\">{2}</Component>\n"
        "<Component name=\"to{0}\" network=\"n{0}\">{3}</Component>\n",
        b, bindings, ends[0], ends[1]);
  }
  return out + "</System>\n";
}

/// Comparisons that `generate` takes for a system.
std::uint64_t work_for(int buses) {
  std::string folder = (fs::temp_directory_path() / "mlcca-work-XXXXXX").string();
  EXPECT_NE(mkdtemp(folder.data()), nullptr);
  const std::string file = folder + "/system.xml";
  std::ofstream(file) << system(buses);
  tools::design::Context context;
  CLI::App app;
  tools::design::add_generate(app, context);
  ::testing::internal::CaptureStdout();
  const std::uint64_t before = compared();
  app.parse(std::vector<std::string>{folder + "/out", "--out", file, "generate"});  // from the end
  const std::uint64_t work = compared() - before;
  ::testing::internal::GetCapturedStdout();
  EXPECT_EQ(context.exit, tools::Exit::fine);
  std::size_t headers = 0;
  for (const auto& made : fs::directory_iterator(folder + "/out"))
    headers += made.path().extension() == ".hpp" || made.path().extension() == ".h" ? 1 : 0;
  EXPECT_GE(headers, 2U * static_cast<std::size_t>(buses));
  fs::remove_all(folder);
  return work;
}

TEST(GenerateWork, GrowsWithTheDescriptionAndNotWithItsSquare) {
  constexpr int few = 10;
  const double small = static_cast<double>(work_for(few));
  const double large = static_cast<double>(work_for(8 * few));
  RecordProperty("ratio", std::to_string(large / small));
  EXPECT_GT(small, 10'000) << "the objects are instrumented";
  // 8 times as much, and the logarithm of what is sorted and looked up; its square would be 64.
  EXPECT_LT(large / small, 16) << small << " comparisons for " << few << " buses, " << large;
}

}  // namespace
}  // namespace mlcca::test
