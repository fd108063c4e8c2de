// SPDX-License-Identifier: BSD-2-Clause
// mlcca-readback, which `mlccactl gate --verify` starts: compares what is in force in the kernel
// with the pins and with the journal, and sends frames through copies of the gates. It asks no
// daemon and changes nothing.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/command_line.hpp"
#include "base/many.hpp"
#include "base/standard_streams.hpp"
#include "bpf/gate.h"
#include "daemon/gates/readback.hpp"
#include "daemon/net/filter_order.hpp"
#include "daemon/net/links.hpp"
#include "daemon/store/journal.hpp"
#include "daemon/verb_options.hpp"
#include "tools/readback/differences.hpp"
#include "tools/readback/replica.hpp"

namespace {

using namespace mlcca;  // NOLINT(google-build-using-namespace): the program itself

enum Exit : std::uint8_t { as_it_should_be = 0, differs = 1, usage = 2, world = 3 };

constexpr const char* kFooter =
    "Exit status: 0 everything is as it should be, 1 something differs, 2 usage, 3 it cannot be "
    "read.";

/// The daemon changes its gates before the journal, so a difference counts only if it is there in
/// several readings.
constexpr int kReadings = 4;
constexpr std::chrono::milliseconds kBetween{100};

/// Reads a copy of the journal, because the daemon has the journal locked.
Result<store::Contents> read_journal(const std::string& state_directory) {
  std::error_code error;
  const auto temporary = std::filesystem::temp_directory_path(error);
  if (error) return fail("no directory for a copy of the journal: " + error.message());
  std::string copy = (temporary / "mlcca-readback-XXXXXX").string();
  if (::mkdtemp(copy.data()) == nullptr) return fail("no directory for a copy of the journal");
  std::filesystem::copy_file(state_directory + "/journal", copy + "/journal", error);
  Result<store::Contents> contents = fail(state_directory + "/journal: " + error.message());
  if (!error) {
    if (const auto journal = store::Journal::open(copy))
      contents = journal->contents();
    else
      contents = std::unexpected(journal.error());
  }
  std::filesystem::remove_all(copy, error);
  return contents;
}

/// Checks that the interface of each port is the one in the journal and has a gate, and that no
/// other interface passes anything.
std::vector<std::string> compare_ports(const gates::Reading& reading,
                                       const store::Contents& journal) {
  std::vector<std::string> problems = reading.problems;
  for (const auto& [identity, port] : journal.gated) {
    const auto gate = std::ranges::find(reading.gates, port.ifindex, &gates::GateReading::ifindex);
    const std::string what = fmt::format("the journal has {} (interface {}) as {} of {}",
                                         port.interface, port.ifindex, identity, port.network);
    if (gate == reading.gates.end())
      problems.push_back(what + ": no gate is pinned for it");
    else if (gate->interface != port.interface)
      problems.push_back(what + ": that interface is " +
                         (gate->interface.empty() ? "not there" : "now " + gate->interface));
  }
  for (const auto& gate : reading.gates)
    if (std::ranges::any_of(gate.slots, &gates::SlotSpec::pass) &&
        std::ranges::none_of(
            journal.gated, [&](const auto& known) { return known.second.ifindex == gate.ifindex; }))
      problems.push_back(
          fmt::format("{} (interface {}) passes subjects, and the journal knows no port there",
                      gate.interface, gate.ifindex));
  return problems;
}

void find_filters_before(gates::GateReading& gate) {
  if (gate.interface.empty() || gate.hook != gates::Hook::clsact) return;
  for (const bool ingress : {true, false}) {
    const auto before = net::filters_before(static_cast<int>(gate.ifindex), ingress,
                                            GATE_TC_PRIORITY, GATE_TC_HANDLE);
    if (!before) gate.problems.push_back(before.error().text);
    for (const net::Filter& f : before.value_or(std::vector<net::Filter>{}))
      gate.problems.push_back(
          fmt::format("{} filter {} (preference {}, handle {:#x}) runs before ours at {}", f.kind,
                      f.name, f.priority, f.handle, ingress ? "ingress" : "egress"));
  }
}

std::vector<std::string> without_gate(const gates::Reading& reading) {
  std::vector<std::string> names;
  const auto links = net::Links::open();
  if (!links) return names;
  for (const auto& [ifindex, link] : links->table())
    if (link.is_can && std::ranges::count(reading.gates, static_cast<std::uint32_t>(ifindex),
                                          &gates::GateReading::ifindex) == 0)
      names.push_back(link.name);
  return names;
}

std::size_t passing(const gates::GateReading& gate) {
  return static_cast<std::size_t>(std::ranges::count_if(gate.slots, &gates::SlotSpec::pass));
}

/// What does not belong to a gate.
struct Rest {
  std::vector<std::string> without_gate;  ///< CAN interfaces
  std::vector<std::string> problems;
};

/// The trials by interface index, or why there are none.
using Trials = Result<std::map<std::uint32_t, readback::Trial>>;

nlohmann::ordered_json json(const gates::GateReading& gate, const Trials& trials) {
  nlohmann::ordered_json out = {{"ifindex", gate.ifindex},           {"interface", gate.interface},
                                {"hook", gates::to_text(gate.hook)}, {"slots", gate.slots.size()},
                                {"passing", passing(gate)},          {"problems", gate.problems}};
  if (!trials || !trials->contains(gate.ifindex)) {
    out["probes"] = nullptr;
    return out;
  }
  const readback::Trial& trial = trials->at(gate.ifindex);
  out["probes"] = {
      {"passed", trial.passed}, {"dropped", trial.dropped}, {"not_tried", trial.untried}};
  return out;
}

std::string json(const gates::Reading& reading, const Rest& rest, const Trials& trials) {
  nlohmann::ordered_json gates = nlohmann::ordered_json::array();
  for (const auto& gate : reading.gates) gates.push_back(json(gate, trials));
  const nlohmann::ordered_json all = {
      {"open", reading.open && !reading.lapsed},
      {"lapsed", reading.lapsed},
      {"mode", reading.audit ? "audit" : "enforce"},
      {"generation", reading.generation},
      {"gates", gates},
      {"without_gate", rest.without_gate},
      {"problems", rest.problems},
      {"no_probes",
       trials ? nlohmann::ordered_json() : nlohmann::ordered_json(trials.error().text)}};
  return all.dump() + "\n";
}

const char* state_of(const gates::Reading& reading) {
  if (reading.lapsed) return "closed by the kernel: the daemon gives no heart-beat";
  return reading.open ? "open" : "closed";
}

std::string text(const gates::Reading& reading, const Rest& rest, const Trials& trials) {
  std::string out = fmt::format("gates are {}{}, generation {}\n", state_of(reading),
                                reading.audit ? " in AUDIT MODE" : "", reading.generation);
  for (const auto& gate : reading.gates) {
    const std::string name =
        gate.interface.empty() ? fmt::format("ifindex {}", gate.ifindex) : gate.interface;
    out += fmt::format("{}: {}, {}, {} of them pass: {}\n", name, gates::to_text(gate.hook),
                       many(gate.slots.size(), "slot"), passing(gate),
                       gate.problems.empty() ? "as it should be" : "NOT as it should be");
    for (const auto& problem : gate.problems) out += "  " + problem + "\n";
    if (!trials || !trials->contains(gate.ifindex)) continue;
    const readback::Trial& trial = trials->at(gate.ifindex);
    out += fmt::format(
        "  frames through a copy of it: {} that had to pass did, {} that had to be "
        "dropped were\n",
        trial.passed, trial.dropped);
    for (const auto& why : trial.untried) out += "  not tried: " + why + "\n";
  }
  for (const auto& problem : rest.problems) out += "NOT as it should be: " + problem + "\n";
  for (const auto& name : rest.without_gate) out += name + ": a CAN interface without a gate\n";
  if (!trials)
    out += "no frames were sent through copies of the gates: " + trials.error().text + "\n";
  return out;
}

/// Sends frames through copies. Wrong results become problems of the gate.
Trials try_gates(gates::Reading& reading, const std::string& root) {
  auto tried = readback::try_gates(reading, root);
  if (!tried) return std::unexpected(tried.error());
  std::map<std::uint32_t, readback::Trial> trials;
  for (readback::Trial& trial : *tried) {
    auto& problems =
        std::ranges::find(reading.gates, trial.ifindex, &gates::GateReading::ifindex)->problems;
    problems.insert(problems.end(), trial.problems.begin(), trial.problems.end());
    trials.emplace(trial.ifindex, std::move(trial));
  }
  return trials;
}

struct Comparison {
  gates::Reading reading;
  Rest rest;

  [[nodiscard]] bool good() const {
    return rest.problems.empty() && std::ranges::all_of(reading.gates, [](const auto& gate) {
             return gate.problems.empty();
           });
  }
  /// Removes problems that were not in a former comparison, too.
  void keep_what_was_wrong_in(const Comparison& former) {
    const auto keep = [](std::vector<std::string>& now, const std::vector<std::string>& before) {
      std::erase_if(now,
                    [&](const auto& p) { return std::ranges::find(before, p) == before.end(); });
    };
    keep(rest.problems, former.rest.problems);
    for (auto& gate : reading.gates) {
      const auto same =
          std::ranges::find(former.reading.gates, gate.ifindex, &gates::GateReading::ifindex);
      keep(gate.problems,
           same == former.reading.gates.end() ? std::vector<std::string>{} : same->problems);
    }
  }
};

Result<Comparison> compare(const std::string& root, const std::string& state) {
  auto reading = gates::read_back(root);
  if (!reading) return std::unexpected(reading.error());
  const auto journal = read_journal(state);
  if (!journal) return std::unexpected(journal.error());
  for (auto& gate : reading->gates) find_filters_before(gate);
  readback::compare_slots(*reading, *journal);
  Rest rest{without_gate(*reading), compare_ports(*reading, *journal)};
  return Comparison{std::move(*reading), std::move(rest)};
}

Result<Comparison> compare_until_good(const std::string& root, const std::string& state) {
  auto last = compare(root, state);
  for (int i = 1; i < kReadings && last && !last->good(); ++i) {
    std::this_thread::sleep_for(kBetween);
    auto next = compare(root, state);
    if (next) next->keep_what_was_wrong_in(*last);
    last = std::move(next);
  }
  return last;
}

int verify(const std::string& root, const std::string& state, bool as_json, bool probes) {
  auto found = compare_until_good(root, state);
  if (!found) {
    const std::string& why = found.error().text;
    if (!as_json)
      to_stderr("mlccactl: " + why + '\n');
    else
      static_cast<void>(
          printed("mlccactl", nlohmann::ordered_json{{"error", {{"message", why}}}}.dump() + '\n'));
    return world;
  }
  // This must be last, because the process cannot leave the namespaces.
  const Trials trials = probes ? try_gates(found->reading, root) : Trials(fail("--no-probes"));
  if (!printed("mlccactl", as_json ? json(found->reading, found->rest, trials)
                                   : text(found->reading, found->rest, trials)))
    return world;
  return found->good() ? as_it_should_be : differs;
}

int parse_and_verify(int argc, char** argv) {
  std::string root = "/run/mlcca/bpf";
  std::string state = "/var/lib/mlcca";
  VerbOptions options;
  bool is_verify = false;
  bool no_probes = false;
  CLI::App app("Reads back what is in force, without the daemon.", "mlccactl");
  auto* gate = app.add_subcommand("gate", "compare the gates with what is pinned and granted");
  options.add_to(app, *gate);
  gate->add_flag("--verify", is_verify, "of what is in force, without the daemon")->required();
  gate->add_flag("--no-probes", no_probes, "compare only: send no frames through copies of gates");
  gate->add_option("--bpf-root", root, "where the gates are pinned")
      ->type_name("PATH")
      ->capture_default_str();
  gate->add_option("--state-directory", state, "where the journal is")
      ->type_name("PATH")
      ->capture_default_str();
  gate->footer(kFooter);
  app.failure_message([](const CLI::App*, const CLI::Error& error) {
    return fmt::format("mlccactl: {}\nmlccactl gate --verify --help says more.\n", error.what());
  });
  refuse_empty_values(*gate);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return end_of_parsing(app, error, usage, world);
  }
  return verify(root, state, options.as_json, !no_probes);
}

}  // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): without memory there is nothing left to do
int main(int argc, char** argv) {
  keep_standard_streams();
  return end_program("mlccactl", parse_and_verify(argc, argv), world);
}
