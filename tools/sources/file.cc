// SPDX-License-Identifier: BSD-2-Clause
#include "tools/sources/file.hpp"

#include <fcntl.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "base/decimal.hpp"
#include "base/handle.hpp"
#include "base/loop_timer.hpp"
#include "base/number.hpp"
#include "base/system_error.hpp"
#include "base/throttle.hpp"
#include "base/units.hpp"
#include "core/mesh/bounds.hpp"
#include "core/model/words.hpp"
#include "tools/sources/peer.hpp"

namespace mlcca::net {
namespace {

using core::mesh::Mesh;
using core::mesh::Sample;

constexpr Value kBillion = 1'000'000'000;

/// Parses a number with at most nine decimals.
std::optional<Decimal> parse_number(std::string_view text) {
  constexpr std::size_t most_decimals = 9;
  const auto point = std::min(text.find('.'), text.size());
  if (text.size() - point > most_decimals + 1) return std::nullopt;
  return Decimal::read(text);
}

/// Parses a rate: an integral number of bit/s, at least 1.
std::optional<Value> parse_rate(std::string_view text) {
  static constexpr std::array names{"Gbit/s", "Mbit/s", "kbit/s", "bit/s"};
  const auto* const name =
      std::ranges::find_if(names, [text](std::string_view n) { return text.ends_with(n); });
  if (name == names.end()) return std::nullopt;
  text.remove_suffix(std::string_view(*name).size());
  const auto number = parse_number(text);
  if (!number) return std::nullopt;
  const auto rate = units::find(Measure::bits_per_second, *name)->of(*number, false);
  return rate && *rate >= 1 && *rate <= core::mesh::kMaxRate ? rate : std::nullopt;
}

/// Parses a share from 0 to 1, in units of 1/whole.
std::optional<Value> parse_share(std::string_view text, Value whole) {
  const auto number = parse_number(text);
  if (!number) return std::nullopt;
  const auto billionths = number->scaled(9, false);
  return billionths && *billionths <= kBillion ? number->times(whole).scaled(0, false)
                                               : std::nullopt;
}

/// The address of the described node with that name or address; nullptr if there is none.
const std::string* address_of(const Mesh& mesh, const std::string& text) {
  for (const auto& node : mesh.nodes)
    if (node.name == text || node.address == text) return &node.address;
  return nullptr;
}

std::vector<std::string> words_of(std::string_view line) {
  constexpr std::string_view blank = " \t\r";
  std::vector<std::string> words;
  line = line.substr(0, line.find('#'));
  for (auto begin = line.find_first_not_of(blank); begin != std::string_view::npos;) {
    const auto end = std::min(line.find_first_of(blank, begin), line.size());
    words.emplace_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(blank, end);
  }
  return words;
}

/// Parses "NAME=VALUE" into the sample; returns an error text if that fails.
std::optional<std::string> take_option(const std::string& word, Sample& sample) {
  const auto equals = std::min(word.find('='), word.size());
  const std::string_view name = std::string_view(word).substr(0, equals);
  const std::string_view value = std::string_view(word).substr(std::min(equals + 1, word.size()));
  const auto store = [](auto parsed, auto& field) {
    if (parsed) field = static_cast<std::remove_cvref_t<decltype(*parsed)>>(*parsed);
    return parsed.has_value();
  };
  if (name == "loss" && !store(parse_share(value, kBillion), sample.loss))
    return "loss is a share from 0 to 1 with at most nine decimals: loss=0.01";
  if (name == "busy") {
    const auto share = parse_share(value, core::mesh::kWhole);
    if (!share) return "busy is a share from 0 to 1 with at most nine decimals: busy=0.1";
    sample.busy = static_cast<std::uint32_t>(*share);
  }
  if (name == "channel" && !store(number_in<std::uint32_t>(value), sample.channel))
    return "channel is a whole number: channel=2412";
  if (name == "weight" && !store(number_in<std::uint32_t>(value), sample.weight))
    return "weight is a whole number up to 4294967295: weight=256";
  if (name == "kind" && !store(core::words::kRateKinds.find(value), sample.kind))
    return "kind is phy, effective or derived";
  static constexpr std::array names{"loss", "busy", "channel", "weight", "kind"};
  if (std::ranges::find(names, name) == names.end())
    return "\"" + word + "\" is unknown: loss=, channel=, kind=, busy=, weight= or both";
  return std::nullopt;
}

/// Adds the link of a line; returns an error text if that fails.
std::optional<std::string> take_line(const std::vector<std::string>& words, const Mesh& mesh,
                                     std::vector<Sample>& links,
                                     std::set<std::pair<std::string, std::string>>& stated) {
  if (words.size() < 3) return "a link needs FROM, TO and RATE";
  Sample sample;
  const std::string* from = address_of(mesh, words[0]);
  const std::string* to = address_of(mesh, words[1]);
  if (from == nullptr || to == nullptr)
    return "no node has the name or address \"" + words[from == nullptr ? 0 : 1] + "\"";
  sample.from = *from;
  sample.to = *to;
  if (sample.from == sample.to) return "a link leads to another node";
  const auto rate = parse_rate(words[2]);
  if (!rate)
    return "\"" + words[2] + "\" is no rate: 24Mbit/s, 5.5Mbit/s, 250kbit/s; at most 1000Gbit/s";
  sample.rate = *rate;
  bool both = false;
  for (std::size_t i = 3; i < words.size(); ++i) {
    if (words[i] == "both")
      both = true;
    else if (auto problem = take_option(words[i], sample))
      return problem;
  }
  for (int way = 0; way < (both ? 2 : 1); ++way) {
    if (links.size() >= core::mesh::kMaxFacts)
      return "the file states more than " + std::to_string(core::mesh::kMaxFacts) + " links";
    if (!stated.emplace(sample.from, sample.to).second)
      return "the link from \"" + sample.from + "\" to \"" + sample.to + "\" was stated before";
    links.push_back(sample);
    std::swap(sample.from, sample.to);
  }
  return std::nullopt;
}

/// Reads a regular file; reading another kind could block or never end.
Result<std::string> read_file(const std::string& path) {
  const Fd file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!file) return system_error(path);
  struct stat about{};
  if (::fstat(file.get(), &about) < 0) return system_error(path);
  if (!S_ISREG(about.st_mode)) return fail(path + ": is not a regular file");
  if (auto checked = check_owner(path, about.st_uid); !checked)
    return std::unexpected(checked.error());
  if ((about.st_mode & S_IWOTH) != 0) return fail(path + ": all users may write it");
  std::string text;
  std::array<char, 65536> block{};
  for (;;) {
    const ssize_t n = ::read(file.get(), block.data(), block.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return system_error(path);
    if (n == 0) return text;
    text.append(block.data(), static_cast<std::size_t>(n));
    if (text.size() > kMaxFileBytes)
      return fail(path + ": is longer than " + std::to_string(kMaxFileBytes) + " bytes");
  }
}

/// Distinguishes the versions of a file by its metadata; nullopt if there is no file.
using Version = std::optional<std::array<std::int64_t, 6>>;
Version version_of(const std::string& path) {
  struct stat s{};
  if (::stat(path.c_str(), &s) < 0) return std::nullopt;
  return std::array<std::int64_t, 6>{static_cast<std::int64_t>(s.st_dev),
                                     static_cast<std::int64_t>(s.st_ino),
                                     s.st_size,
                                     s.st_mtim.tv_sec,
                                     s.st_mtim.tv_nsec,
                                     s.st_ctim.tv_nsec};
}

class File final : public LinkSource {
 public:
  File(std::string path, Mesh mesh, sd_event* loop, Report report)
      : path_(std::move(path)), mesh_(std::move(mesh)), loop_(loop), report_(std::move(report)) {}

  Result<void> start() {
    if (auto started = throttle_.start(loop_, [this] { report(); }); !started) return started;
    return timer_.start(loop_, [this] { poll(); });
  }

 private:
  /// Refreshes the samples, and watches the folder as soon as it exists.
  void poll() {
    if (!watch_) {
      watch();
      changed_ = true;
    } else if (has_changed_unseen()) {
      changed_ = true;
    }
    throttle_.ask();
    timer_.set(kPollInterval);
  }

  /// Whether the file has changed without an event of the watch: behind a symbolic link, or with
  /// its folder. A file that is being written in place is not read before it is the same in two
  /// polls.
  [[nodiscard]] bool has_changed_unseen() {
    const Version now = version_of(path_);
    if (now == version_) return false;
    const auto is_other = [&] {
      return (*now)[0] != (*version_)[0] || (*now)[1] != (*version_)[1];  // device, inode
    };
    if (!now || !version_ || is_other()) return true;
    return std::exchange(seen_, now) == now;
  }

  void watch() {
    const auto folder = std::filesystem::path(path_).parent_path();
    sd_event_source* raw = nullptr;
    // IN_MODIFY is left out: a file that is being written is read when its writer closes it.
    constexpr std::uint32_t changes =
        IN_CLOSE_WRITE | IN_MOVED_TO | IN_MOVED_FROM | IN_DELETE | IN_MOVE_SELF | IN_ONLYDIR;
    if (sd_event_add_inotify(loop_, &raw, folder.c_str(), changes, on_change, this) >= 0)
      watch_.reset(raw);
  }

  static int on_change(sd_event_source*, const inotify_event* event, void* self) noexcept {
    auto& file = *static_cast<File*>(self);
    // The folder was removed or renamed.
    if ((event->mask & (IN_IGNORED | IN_MOVE_SELF)) != 0) file.watch_.reset();
    const bool other =
        event->len > 0 && std::filesystem::path(file.path_).filename() != event->name;
    if (other) return 0;
    file.changed_ = true;
    file.throttle_.ask();
    return 0;
  }

  void read() {
    links_.clear();
    problem_.clear();
    version_ = version_of(path_);
    const auto text = read_file(path_);
    auto links = text ? parse_links(*text, path_, mesh_) : std::unexpected(text.error());
    if (links)
      links_ = std::move(*links);
    else
      problem_ = links.error().text;
  }

  void report() {
    if (std::exchange(changed_, false)) read();
    core::mesh::Snapshot snapshot{.links = links_, .next_hops = {}, .problem = problem_};
    stamp(snapshot, loop_time(loop_));
    report_(std::move(snapshot));
  }

  std::string path_;
  Mesh mesh_;
  sd_event* loop_;
  Report report_;
  std::vector<Sample> links_;
  std::string problem_;
  Version seen_;          ///< version in the latest poll, while it differs from version_
  Version version_;       ///< version that was read
  bool changed_ = false;  ///< since it was read
  EventSource watch_;
  LoopTimer timer_;
  Throttle throttle_;
};

}  // namespace

Result<std::vector<Sample>> parse_links(std::string_view text, const std::string& name,
                                        const Mesh& mesh) {
  std::vector<Sample> links;
  std::set<std::pair<std::string, std::string>> stated;
  std::size_t number = 0;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto words = words_of(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    ++number;
    if (words.empty()) continue;
    if (const auto problem = take_line(words, mesh, links, stated))
      return fail(name + ":" + std::to_string(number) + ": " + *problem);
  }
  return links;
}

Result<std::unique_ptr<LinkSource>> open_file(const core::mesh::Source& source, const Mesh& mesh,
                                              sd_event* loop, LinkSource::Report report) {
  if (!source.endpoint.starts_with('/'))
    return fail("\"" + source.endpoint + "\": a file of links is named by an absolute path");
  auto file = std::make_unique<File>(source.endpoint, mesh, loop, std::move(report));
  if (auto started = file->start(); !started) return std::unexpected(started.error());
  return file;
}

}  // namespace mlcca::net
