// SPDX-License-Identifier: BSD-2-Clause
// The verb `mlccactl learn`: drafts a description from observed traffic.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <net/if.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/many.hpp"
#include "base/standard_streams.hpp"
#include "base/units.hpp"
#include "core/model/words.hpp"
#include "core/profiles/profile.hpp"
#include "daemon/net/can_routes.hpp"
#include "description/kinds.hpp"
#include "description/read.hpp"
#include "tools/design/learn_deadlines.hpp"
#include "tools/design/learn_described.hpp"
#include "tools/design/learn_merge.hpp"
#include "tools/design/learn_options.hpp"
#include "tools/design/learn_patch.hpp"
#include "tools/design/learn_silence.hpp"
#include "tools/design/learn_table.hpp"
#include "tools/design/mistakes.hpp"
#include "tools/design/new/plan.hpp"
#include "tools/design/output.hpp"
#include "tools/design/say.hpp"
#include "tools/design/verbs.hpp"
#include "tools/elements.hpp"
#include "tools/learn/draft.hpp"
#include "tools/learn/kernel_copies.hpp"
#include "tools/learn/live.hpp"
#include "tools/learn/observer.hpp"
#include "tools/learn/recording.hpp"
#include "tools/table.hpp"
#include "tools/times.hpp"
#include "tools/values.hpp"

namespace mlcca::tools::design {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kDefaultTime = "10min";
constexpr std::uint64_t kLongestTime = 366 * units::kDay * 1'000'000'000;  // ns

struct LearnArguments {
  std::vector<std::string> sources;
  std::string time;  ///< empty: kDefaultTime
  std::string output;
  std::string gateway;
  std::vector<std::string> profiles;
  std::vector<std::string> bitrates;
  std::vector<std::string> data_bitrates;
  learn::DraftOptions draft;
  bool is_named = false;  ///< by --name
  bool no_local = false;
  std::string merge;
};

volatile std::sig_atomic_t stop_asked = 0;

class Learn {
 public:
  Learn(LearnArguments& arguments, const Context& context) : a_(arguments), context_(context) {}

  Exit run() {
    if (const auto refused = prepare()) return say(*refused, context_.json);
    if (const auto refused = observe()) return say(*refused, context_.json);
    if (const auto refused = note_silence()) return say(*refused, context_.json);
    observer_.finish(interfaces_.names().size(), interfaces_.media());
    note_profiles();
    note_made_up();
    if (::isatty(STDERR_FILENO) != 0)
      to_stderr("drafting, and checking what the buses can carry\n");
    learn::Draft draft = draft_that_holds(observer_, interfaces_.names(), a_.draft);
    if (draft.channels.empty())
      notes_.emplace_back("no events were seen: what was there needs no channel of the profile");
    if (described_) return report_merged(std::move(draft));
    if (const auto refused = mistakes_in(draft.xml, "draft", description::Users::any))
      return say(*refused, context_.json);
    if (!a_.output.empty())
      if (const auto made = write_output(a_.output, draft.xml, Existing::refuse); !made)
        return say({Exit::world, made.error().text, {}}, context_.json);
    return report(draft);
  }

 private:
  [[nodiscard]] static Refusal wrong(std::string text) {
    return {Exit::usage, std::move(text), {}};
  }

  std::optional<Refusal> prepare() {
    const auto time = parse_span(a_.time.empty() ? kDefaultTime : a_.time);
    if (!time) return wrong("--for " + time.error().text);
    if (*time == 0 || *time > kLongestTime)
      return wrong(fmt::format("--for '{}': must be 1ms to 366d", a_.time));
    time_ = *time;
    if (!a_.output.empty())
      if (const auto can = can_write(a_.output, Existing::refuse); !can)
        return Refusal{Exit::world, can.error().text, {}};
    if (const auto can = can_be_user(a_.draft.user); !can) return wrong(can.error().text);
    a_.draft.local_subscribers = !a_.no_local;
    if (!a_.gateway.empty()) a_.draft.gateway = a_.gateway;
    for (const auto& [option, name] :
         {std::pair("--name", &a_.draft.system), std::pair("--gateway", &a_.draft.gateway)})
      if (auto problem = problem_of_planned_name(*name); !problem.empty())
        return wrong(fmt::format("{}: {}", option, problem));
    if (auto refused = read_described()) return refused;
    if (auto refused = read_rates()) return refused;
    return read_profiles();
  }

  /// Reads the description that --merge names.
  std::optional<Refusal> read_described() {
    if (a_.merge.empty()) return std::nullopt;
    if (!a_.output.empty()) return wrong("--merge prints a difference: it goes without --output");
    if (a_.is_named) return wrong("--name goes without --merge: the described system has a name");
    auto described = description::read(a_.merge, description::Users::any);
    if (!described) {
      Refusal refused = wrong(a_.merge + ": the description cannot be used");
      refused.details.reserve(described.error().size());
      for (const auto& problem : description::shortened(described.error()))
        refused.details.push_back(description::to_string(problem));
      return refused;
    }
    described_ = std::move(*described);
    if (const auto can = LearnPatch(*described_).can_change(); !can) return wrong(can.error().text);
    const auto adopted = adopt(*described_, a_.gateway, a_.draft);
    return adopted ? std::nullopt : std::optional(wrong(adopted.error().text));
  }

  std::optional<Refusal> read_rates() {
    constexpr std::uint32_t most = 1'000'000;
    constexpr std::uint32_t most_of_data = 8'000'000;
    const auto rates = stated_rates(a_.bitrates, "--bitrate", most);
    if (!rates) return wrong(rates.error().text);
    const auto data_rates = stated_rates(a_.data_bitrates, "--data-bitrate", most_of_data);
    if (!data_rates) return wrong(data_rates.error().text);
    a_.draft.bitrates = *rates;
    a_.draft.data_bitrates = *data_rates;
    return std::nullopt;
  }

  std::optional<Refusal> read_profiles() {
    const auto profiles = stated_profiles(a_.profiles);
    if (!profiles) return wrong(profiles.error().text);
    if (described_) profiles_ = described_profiles(*described_, a_.draft.networks);
    for (const auto& [interface, profile] : *profiles) {
      const auto [known, is_new] = profiles_.try_emplace(interface, profile);
      if (!is_new && known->second != profile)
        return wrong(fmt::format("--profile {}={}: {} states {}", interface,
                                 core::words::kProfiles.of(profile), a_.merge,
                                 core::words::kProfiles.of(known->second)));
    }
    return std::nullopt;
  }

  /// States the profiles of interfaces that are new since the last call.
  void state_profiles() {
    for (; stated_ < interfaces_.names().size(); ++stated_)
      if (const auto profile = profiles_.find(interfaces_.names()[stated_]);
          profile != profiles_.end())
        observer_.state(static_cast<std::uint32_t>(stated_), profile->second);
  }

  /// Adds a note about each interface without a name. Where its name had to be distinguished from
  /// another one, it says which one it is.
  void note_made_up() {
    const auto& made_up = interfaces_.made_up();
    const auto is_distinguished = [](const auto& one) { return one.first != one.second.wanted; };
    const bool any = std::ranges::any_of(made_up, is_distinguished);
    for (const auto& [name, origin] : made_up) {
      a_.draft.made_up.insert(name);
      const std::string which =
          any ? fmt::format("is {} of {}; ", origin.wanted, origin.recording) : std::string();
      notes_.push_back(fmt::format(
          "{}: {}its recording has no names of interfaces: state the one that it is", name, which));
    }
    if (any)
      notes_.emplace_back(
          "several interfaces would have one name, and are taken for different ones: if one was "
          "recorded in parts, join the parts to one recording");
  }

  /// Adds a note about each CAN profile that was stated for an Ethernet interface.
  void note_profiles() {
    for (std::size_t i = 0; i < interfaces_.names().size(); ++i) {
      const auto& of = observer_.interfaces()[i];
      if (of.is_stated && of.medium == learn::Medium::ethernet &&
          !core::has_datagrams(of.decoder->profile()))
        notes_.push_back(fmt::format(
            "{}: the profile {} is for CAN, and {} has frames of Ethernet", interfaces_.names()[i],
            core::words::kProfiles.of(of.decoder->profile()), interfaces_.names()[i]));
    }
  }

  std::optional<Refusal> observe() {
    std::vector<OfRecording> recordings;
    if (auto refused = sort_sources(recordings)) return refused;
    for (const auto& [order, path] : recordings)
      if (auto refused = read_file_of_frames(path, order.first)) return refused;
    if (live_.empty() && !a_.time.empty())
      return wrong(fmt::format(
          "--for {}: there is no interface to listen to, and recordings are read to their end",
          a_.time));
    if (auto refused = refuse_absent(live_)) return refused;
    for (const std::string& name : live_)
      if (const auto medium = learn::medium_of(name); !medium) return wrong(medium.error().text);
    for (const std::string& name : live_)
      if (described_ && !a_.draft.networks.contains(name)) return wrong(not_described(name));
    return live_.empty() ? std::nullopt : listen(live_);
  }

  /// A recording in the order in which it is read, and its path.
  using OfRecording = std::pair<std::pair<learn::Naming, std::string>, std::string>;

  /// Finds out which sources are recordings, and notes the others, which are interfaces, in
  /// `live_`. The order in which recordings without names are given makes no difference.
  std::optional<Refusal> sort_sources(std::vector<OfRecording>& recordings) {
    std::set<std::pair<::dev_t, ::ino_t>> files;
    std::set<unsigned> indices;
    for (const std::string& source : a_.sources) {
      struct stat status{};
      const bool is_standard = source == "-";
      if ((is_standard ? ::fstat(STDIN_FILENO, &status) : ::stat(source.c_str(), &status)) == 0) {
        if (!files.emplace(status.st_dev, status.st_ino).second)
          return wrong(source + " is given twice: each recording counts once");
        const learn::Naming naming = learn::naming_of(source);
        recordings.emplace_back(
            std::pair(naming, naming == learn::Naming::none ? source : std::string()), source);
        continue;
      }
      if (!learn::is_interface(source))
        return wrong(source + ": there is neither such a file nor such an interface");
      if (!indices.insert(::if_nametoindex(source.c_str())).second)
        return wrong(source + " is given twice: each interface counts once");
      live_.push_back(source);
      interfaces_.reserve(source);
    }
    std::ranges::stable_sort(recordings, {}, &OfRecording::first);
    return std::nullopt;
  }

  /// Adds notes about interfaces without traffic. Refuses if there was no traffic at all.
  std::optional<Refusal> note_silence() {
    std::vector<std::string> silent;
    for (const std::string& name : live_) {
      const auto number = interfaces_.number_of(name, learn::Medium::unknown);
      if (number >= observer_.interfaces().size() || observer_.interfaces()[number].frames == 0)
        silent.push_back(name);
    }
    if (silent.empty()) return std::nullopt;
    const auto status = status_of_daemon(context_.socket);
    for (std::string& name : silent)
      name = reason_of_silence(name, learn::is_up(name), received_.unseen_on(name), status);
    if (std::ranges::none_of(observer_.interfaces(), [](const auto& of) { return of.frames != 0; }))
      return Refusal{Exit::usage, "no frame was seen; nothing was drafted", std::move(silent)};
    std::ranges::move(silent, std::back_inserter(notes_));
    return std::nullopt;
  }

  /// Refuses options that name an interface from which nothing is read, and bit rates of what is no
  /// CAN bus.
  [[nodiscard]] std::optional<Refusal> refuse_absent(const std::vector<std::string>& live) const {
    std::map<std::string, learn::Medium> there;
    for (const std::string& name : live) there.emplace(name, learn::Medium::unknown);
    for (std::size_t i = 0; i < interfaces_.names().size(); ++i)
      if (interfaces_.media()[i] != learn::Medium::unknown)
        there.insert_or_assign(interfaces_.names()[i], interfaces_.media()[i]);
    for (const auto& [option, texts] :
         {std::pair("--profile", &a_.profiles), std::pair("--bitrate", &a_.bitrates),
          std::pair("--data-bitrate", &a_.data_bitrates)})
      if (const auto fit = fit_interfaces(*texts, option, texts != &a_.profiles, there); !fit)
        return wrong(fit.error().text);
    return std::nullopt;
  }

  std::optional<Refusal> read_file_of_frames(const std::string& path, learn::Naming naming) {
    const std::string name = path == "-" ? "standard input" : path;
    const bool may_be_pipe = naming == learn::Naming::unknown;
    if (may_be_pipe && stop_asked != 0) {
      notes_.push_back(name + ": not read, because a signal has ended it before");
      return std::nullopt;
    }
    observer_.begin(name);
    bool has_frames = false;
    std::function<bool()> stop;
    if (may_be_pipe) {
      on_end([](int) { stop_asked = 1; });
      stop = [] { return stop_asked != 0; };
    }
    const auto left = learn::read_recording(
        path, interfaces_,
        [&](const auto& frame) {
          has_frames = true;
          state_profiles();
          observer_.add(frame);
        },
        stop);
    if (!left) return wrong(left.error().text);
    if (!has_frames && left->errors != 0 && left->lines == 0)
      return wrong(fmt::format(
          "{}: {} and no other: the bus was disturbed, or nobody acknowledged what was sent", name,
          many(left->errors, "error frame")));
    if (!has_frames)
      return wrong(fmt::format("{}: no frame was recognised in it{}{}", name,
                               left->first.empty() ? "" : ": ", left->first));
    if (left->lines != 0)
      notes_.push_back(fmt::format("{}: {} passed over, the first: {}", name,
                                   many(left->lines, "entry", "entries"), left->first));
    if (left->errors != 0)
      notes_.push_back(fmt::format("{}: {} of controllers, which are no events, left out", name,
                                   many(left->errors, "error frame")));
    if (!left->cut.empty())
      notes_.push_back(fmt::format("{}: {}; what is complete before it is read", name, left->cut));
    if (left->interfaces != 0)
      notes_.push_back(fmt::format("{}: {} of further interfaces: {} are the most", name,
                                   many(left->interfaces, "frame"), learn::Interfaces::kMost));
    return std::nullopt;
  }

  std::optional<Refusal> listen(const std::vector<std::string>& live) {
    for (const std::string& name : live) {
      const learn::Rates rates = learn::rates_of(name);
      if (rates.bitrate != 0) a_.draft.bitrates.try_emplace(name, rates.bitrate);
      if (rates.data_bitrate != 0) a_.draft.data_bitrates.try_emplace(name, rates.data_bitrate);
      if (rates.queue_length != 0) a_.draft.queue_lengths.try_emplace(name, rates.queue_length);
    }
    received_.begin(live);
    const auto listener = learn::Listener::open(live, interfaces_);
    if (!listener) return Refusal{Exit::world, listener.error().text, {}};
    if (auto refused = refuse_absent(live)) return refused;  // their media are known now
    state_profiles();
    observer_.begin("what was listened to");
    const learn::KernelCopies carried = carried_by_kernel(live);
    on_end([](int) { stop_asked = 1; });
    if (::isatty(STDERR_FILENO) != 0)
      to_stderr(
          fmt::format("listening to {} for {}; Ctrl-C ends it earlier, and drafts what was seen\n",
                      fmt::join(live, ", "), print_duration(time_)));
    Listening progress(time_);
    const std::uint64_t begin = monotonic_ns();
    const auto listened = (*listener)->listen(
        time_,
        [&] {
          progress.show();
          return stop_asked != 0;
        },
        [&](const learn::Frame& frame) {
          progress.count();
          carried.copies_of(frame, observer_.add(frame),
                            [this](const learn::Frame& copy) { observer_.add(copy); });
        });
    if (!listened) return Refusal{Exit::world, listened.error().text, {}};
    a_.draft.times.listened = monotonic_ns() - begin;
    if ((*listener)->lost() != 0)
      notes_.push_back(many((*listener)->lost(), "frame came too fast and was not seen",
                            "frames came too fast and were not seen"));
    return std::nullopt;
  }

  /// Reads the rules of can-gw at the beginning of learning.
  learn::KernelCopies carried_by_kernel(const std::vector<std::string>& live) {
    const auto rules = net::KernelCanRules().read();
    if (!rules) {
      notes_.push_back(rules.error().text + ": what the kernel carries is not known");
      return {};
    }
    learn::KernelCopies out(*rules, live, interfaces_, [](int index) {
      std::array<char, IF_NAMESIZE> name{};
      return std::string(::if_indextoname(static_cast<unsigned>(index), name.data()) == nullptr
                             ? ""
                             : name.data());
    });
    std::ranges::copy(out.notes(), std::back_inserter(notes_));
    return out;
  }

  [[nodiscard]] Exit report_merged(learn::Draft draft) {
    std::ranges::move(
        leave_out_others(*described_, observer_, interfaces_.names(), a_.draft.networks, draft),
        std::back_inserter(notes_));
    const auto merged = merge(*described_, draft, a_.draft);
    if (!merged) return say({Exit::usage, merged.error().text, {}}, context_.json);
    // A check of the patched description counts, not one of the draft.
    std::ranges::remove_copy_if(draft.left_out, std::back_inserter(notes_), is_of_check);
    std::ranges::copy(merged->notes, std::back_inserter(notes_));
    std::ranges::move(refused_when_patched(*described_, merged->files), std::back_inserter(notes_));
    std::string text;
    for (const auto& [path, changed] : merged->files) {
      const auto diff = diff_of(path, changed);
      if (!diff) return say({Exit::world, diff.error().text, {}}, context_.json);
      text += *diff;
    }
    if (!context_.json) {
      for (const std::string& line : merged->differs)
        to_stderr(fmt::format("differs: {}\n", printable(line)));
      print_notes(notes_);
    }
    const bool same = text.empty() && merged->differs.empty();
    if (context_.json) {
      const Json out = {{"diff", text}, {"differs", merged->differs}, {"notes", notes_}};
      text = out.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
    }
    const Exit said = say(text);
    return said == Exit::fine && !same ? Exit::refused : said;
  }

  [[nodiscard]] Exit report(const learn::Draft& draft) {
    std::ranges::copy(draft.left_out, std::back_inserter(notes_));
    if (context_.json)
      return say(json_of(draft).dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
    std::string text = a_.output.empty() ? draft.xml : text_of(draft);
    print_notes(notes_);
    std::error_code error;
    if (!a_.output.empty() && std::filesystem::is_regular_file(a_.output, error))
      text +=
          fmt::format("\n{}: created; read it, then 'mlccactl check {}'\n", a_.output, a_.output);
    return say(text);
  }

  /// The load of an interface in percent; nullopt unless it is a CAN bus with a known bit rate.
  [[nodiscard]] std::optional<double> load_of(std::size_t interface) const {
    const auto rate = [&](const std::map<std::string, std::uint32_t>& rates) {
      const auto known = rates.find(interfaces_.names()[interface]);
      return known == rates.end() ? 0 : known->second;
    };
    const auto& of = observer_.interfaces()[interface];
    if (of.medium != learn::Medium::can) return std::nullopt;
    return of.load_percent(rate(a_.draft.bitrates), rate(a_.draft.data_bitrates));
  }

  [[nodiscard]] std::string text_of(const learn::Draft& draft) const {
    std::string out;
    for (std::size_t i = 0; i < interfaces_.names().size(); ++i) {
      const auto& of = observer_.interfaces()[i];
      const auto load = load_of(i);
      out += fmt::format(
          "{}: {} {}{}, profile {} ({} % sure: {})\n", printable(interfaces_.names()[i]), of.frames,
          learn::word_for(of.frames, of.medium), load ? fmt::format(", load {:.1f} %", *load) : "",
          core::words::kProfiles.of(of.recognised->profile), of.recognised->percent,
          of.recognised->why);
    }
    return out + "\n" + table_of(draft, color_of(STDOUT_FILENO, context_.no_color));
  }

  [[nodiscard]] Json json_of(const learn::Draft& draft) const {
    Json interfaces = Json::array();
    for (std::size_t i = 0; i < interfaces_.names().size(); ++i) {
      const auto& of = observer_.interfaces()[i];
      interfaces.push_back({{"name", interfaces_.names()[i]},
                            {"medium", of.medium == learn::Medium::ethernet ? "ethernet" : "can"},
                            {"frames", of.frames},
                            {"profile", core::words::kProfiles.of(of.recognised->profile)},
                            {"percent", of.recognised->percent},
                            {"why", of.recognised->why}});
      if (const auto load = load_of(i)) interfaces.back()["load_percent"] = *load;
    }
    Json out = {
        {"interfaces", std::move(interfaces)}, {"channels", channels_of(draft)}, {"notes", notes_}};
    if (a_.output.empty()) out["description"] = draft.xml;
    return out;
  }

  LearnArguments& a_;
  const Context& context_;
  std::optional<core::System> described_;
  std::uint64_t time_ = 0;  ///< ns
  learn::Interfaces interfaces_;
  learn::Observer observer_;
  std::map<std::string, core::Profile> profiles_;  ///< stated or described, by interface
  std::size_t stated_ = 0;  ///< of so many interfaces the profiles are stated
  std::vector<std::string> notes_;
  Received received_;
  std::vector<std::string> live_;  ///< interfaces on which traffic is observed
};

}  // namespace

void add_learn(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("learn", "draft a description from the traffic that is there");
  auto a = std::make_shared<LearnArguments>();
  verb->add_option("source", a->sources,
                   "interfaces of CAN or Ethernet to listen to, or recordings: candump -l or -ta, "
                   "pcap, pcapng, .asc, .blf, also packed by gzip; - is standard input")
      ->required()
      ->type_name("INTERFACE|FILE|-");
  verb->add_option("--for", a->time, "how long to listen")
      ->type_name("TIME")
      ->default_str(kDefaultTime);
  verb->add_option("--output", a->output,
                   "write the draft to this new file, and print a table; - is standard output")
      ->type_name("FILE.xml");
  verb->add_option("--profile", a->profiles,
                   "the profile of an interface, instead of the one that is recognised; repeatable")
      ->type_name(
          fmt::format("INTERFACE={}", fmt::join(std::span(core::words::kProfiles).subspan(1), "|")))
      ->allow_extra_args(false);
  verb->add_option("--bitrate", a->bitrates,
                   "the bit rate of an interface, such as can0=500k; repeatable")
      ->type_name("INTERFACE=RATE")
      ->allow_extra_args(false);
  verb->add_option("--data-bitrate", a->data_bitrates, "the same of its FD data phase; repeatable")
      ->type_name("INTERFACE=RATE")
      ->allow_extra_args(false);
  auto* name =
      verb->add_option("--name", a->draft.system, "name of the system")->capture_default_str();
  verb->add_option("--gateway", a->gateway,
                   "name of this gateway; default: gateway, or with --merge the "
                   "only one that is described");
  auto* merge = verb->add_option(
      "--merge", a->merge,
      "print what would have to change in this description, as a patch, and what differs");
  refuse_standard_input(merge->type_name("SYSTEM.xml"));
  verb->add_option("--user", a->draft.user, "user of programs here that send")
      ->capture_default_str();
  verb->add_flag("--no-local", a->no_local, "no program on this gateway receives anything");
  verb->footer(
      "Exit status: 0 drafted, 1 with --merge: there are differences, 2 usage, unreadable input or "
      "no frame,\n3 the outside world failed, or the output exists.");
  verb->callback([a, name, &context] {
    a->output = path_of_output(a->output);
    a->is_named = name->count() != 0;
    context.exit = Learn(*a, context).run();
  });
}

}  // namespace mlcca::tools::design
