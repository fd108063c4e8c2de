// SPDX-License-Identifier: BSD-2-Clause
// Something else has a name that is ours in the bpffs: it is replaced, or, where that would destroy
// of what belongs to another program, a message says what is there and what is to be done.
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>

#include "daemon/gates/early.hpp"
#include "daemon/gates/pins.hpp"
#include "daemon/gates/starting.hpp"
#include "tests/daemon/gates/attach_fixture.hpp"

namespace mlcca::gates {
namespace {

struct Wrong {
  std::string what;  ///< as it is called
  std::function<void(const std::string&)> put;
};

std::vector<Wrong> wrong_objects() {
  const auto pin_map = [](bpf_map_type type, std::uint32_t value, std::uint32_t entries) {
    return [=](const std::string& path) {
      const Fd map(bpf_map_create(type, "foreign", 4, value, entries, nullptr));
      ASSERT_TRUE(pin(map.get(), path).value()) << path;
    };
  };
  return {{"a map of type 1 (foreign, 3 entries of 8 bytes)", pin_map(BPF_MAP_TYPE_HASH, 8, 3)},
          {"a map of type 2 (foreign, 1 entry of 80 bytes)", pin_map(BPF_MAP_TYPE_ARRAY, 80, 1)},
          {"a program",
           [](const std::string& path) {
             const Fd program = test::load_foreign(0);
             ASSERT_TRUE(pin(program.get(), path).value()) << path;
           }},
          {"a directory", [](const std::string& path) { std::filesystem::create_directory(path); }},
          {"a symbolic link",
           [](const std::string& path) { std::filesystem::create_symlink("/nowhere", path); }}};
}

class WrongPins : public AttachTo {
 protected:
  WrongPins() : AttachTo(best_hook()) {
    EXPECT_TRUE(control_.arm());
    EXPECT_TRUE(Starting::begin(control_, 0, 0));
    EXPECT_TRUE(note_early(root_, 0));
  }
  /// As a daemon that starts. Gives what is wrong.
  std::string start() {
    auto control = Control::create(root_);
    if (!control) return control.error().text;
    control_ = std::move(*control);
    if (auto set = control_.set_grace(kForEver); !set) return set.error().text;
    if (auto begun = Starting::begin(control_, 0, 0); !begun) return begun.error().text;
    if (auto beaten = control_.beat(1); !beaten) return beaten.error().text;
    if (auto armed = control_.arm(); !armed) return armed.error().text;
    if (auto noted = note_early(root_, 0); !noted) return noted.error().text;
    control_.open();
    return {};
  }
  [[nodiscard]] std::vector<std::string> shared() const {
    const std::string own = control_.directory();
    return {own + "/control", own + "/events",   own + "/deadman",
            own + "/grace",   own + "/starting", root_ + "/early_programs"};
  }
};

TEST_F(WrongPins, OfAllGatesAreReplaced) {
  for (const std::string& path : shared())
    for (const Wrong& wrong : wrong_objects()) {
      const std::string right = what_is_at(path);
      ASSERT_NE(right, "") << path;
      ASSERT_TRUE(std::filesystem::remove(path));
      wrong.put(path);
      ASSERT_EQ(what_is_at(path), wrong.what);
      EXPECT_EQ(start(), "") << wrong.what << " at " << path;
      EXPECT_EQ(what_is_at(path), right) << wrong.what;
      EXPECT_FALSE(control_.keep_pinned().value()) << wrong.what << " at " << path;
    }
}

TEST_F(WrongPins, ThatWereReplacedAreReported) {
  const std::string path = control_.directory() + "/control";
  std::filesystem::remove(path);
  std::filesystem::create_directory(path);
  ASSERT_EQ(start(), "");
  EXPECT_EQ(control_.take_replaced(),
            std::vector{path + " was a directory, and is what mlccad pins there again"});
}

TEST_F(WrongPins, AWordOfSomethingElseIsClosedAndReplaced) {
  const Bus bus("bus0");
  auto gate = attach(bus);
  admit(gate, {out(0x123, 0)});
  const Program program(bus);
  EXPECT_TRUE(program.send(frame(0x123)));
  Mapped<gate_control>(control_.map_fd(), 1)[0].layout_version = GATE_LAYOUT_VERSION + 1;
  ASSERT_EQ(start(), "");
  EXPECT_FALSE(program.send(frame(0x123))) << "its word is not beaten any more";
  gate = attach(bus);
  EXPECT_TRUE(program.send(frame(0x123)));
}

TEST_F(WrongPins, ADirectoryThatIsNotEmptyIsNamedWithWhatIsToBeDone) {
  for (const std::string& path : shared()) {
    std::filesystem::remove(path);
    std::filesystem::create_directories(path + "/of/somebody");
    EXPECT_EQ(start(), path +
                           " is a directory that is not empty, where mlccad pins an object of its "
                           "own: remove it (rm -r " +
                           path + ") and start mlccad again");
    std::filesystem::remove_all(path);
    EXPECT_EQ(start(), "");
  }
}

TEST_F(WrongPins, OfAGateAreReplaced) {
  const Bus bus("bus0");
  attach(bus);
  std::vector<std::string> names = names_in(pins(bus)).value();
  ASSERT_EQ(names.size(), 5U);
  for (const char* name : {"table_next", "silence_timers_next", "egress_next"})
    names.emplace_back(name);
  std::size_t kind = 0;
  for (const std::string& name : names)
    for (int i = 0; i < 2; ++i) {
      const Wrong wrong = wrong_objects().at(kind++ % 5);
      const std::string path = pins(bus) + "/" + name;
      std::filesystem::remove(path);
      wrong.put(path);
      auto gate = attach(bus);
      EXPECT_TRUE(gate.attached().value()) << wrong.what << " at " << path;
      EXPECT_EQ(gate.keep_pinned().value(), std::vector<std::string>{}) << wrong.what << path;
      EXPECT_EQ(names_in(pins(bus)).value().size(), 5U) << wrong.what << " at " << path;
    }
}

TEST_F(WrongPins, InThePlaceOfDirectoriesAreReplaced) {
  const Bus bus("bus0");
  attach(bus);
  for (const std::string& path : {pins(bus), control_.directory()})
    for (const Wrong& wrong : wrong_objects()) {
      std::filesystem::remove_all(path);
      wrong.put(path);
      ASSERT_EQ(start(), "") << wrong.what << " at " << path;
      auto gate = attach(bus);
      EXPECT_TRUE(gate.attached().value()) << wrong.what << " at " << path;
      EXPECT_TRUE(gate.keep_pinned().value().empty()) << wrong.what << " at " << path;
    }
}

}  // namespace
}  // namespace mlcca::gates
