// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/recording.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include "tools/learn/formats.hpp"
#include "tools/learn/input.hpp"
#include "tools/learn/recording_file.hpp"

namespace mlcca::learn {
namespace {

using namespace std::string_view_literals;

using Reader = Result<void> (*)(Recording&);

std::string_view text_of(Bytes head) {
  return {reinterpret_cast<const char*>(head.data()), head.size()};  // NOLINT(*-reinterpret-cast)
}

/// The reader for a file, by its first bytes; text formats are distinguished by their first line.
/// nullptr if none fits.
Reader reader_of(Bytes head) {
  std::string_view text = text_of(head);
  if (text.starts_with("LOGG")) return read_blf;
  if (text.starts_with("\x0a\x0d\x0d\x0a"sv)) return read_pcapng;
  for (const auto magic :
       {"\xa1\xb2\xc3\xd4"sv, "\xd4\xc3\xb2\xa1"sv, "\xa1\xb2\x3c\x4d"sv, "\x4d\x3c\xb2\xa1"sv})
    if (text.starts_with(magic)) return read_pcap;
  const auto first = text.find_first_not_of(" \t\r\n");
  text.remove_prefix(std::min(first, text.size()));
  if (text.starts_with("date ") || text.starts_with("base ") || text.starts_with("//"))
    return read_asc;
  if (screen_of(head) != Screen::none) return read_candump_screen;
  return text.starts_with('(') ? read_candump : nullptr;
}

/// Known formats that cannot be read, with advice for the user.
struct Other {
  std::string_view begins;
  std::string_view is;
};
constexpr auto kOthers = std::to_array<Other>({
    {"\xfd"
     "7zXZ\0"sv,
     "it is packed by xz: xzcat FILE | mlccactl learn -"},
    {"\x28\xb5\x2f\xfd"sv, "it is packed by zstd: zstdcat FILE | mlccactl learn -"},
    {"BZh"sv, "it is packed by bzip2: bzcat FILE | mlccactl learn -"},
    {"PK\3\4"sv, "it is a ZIP archive: unzip -p FILE | mlccactl learn -"},
    {"\x1f\x8b"sv, "it is packed by gzip twice: zcat FILE | mlccactl learn -"},
    {"\xff\xfe"sv, "it is a text in UTF-16: iconv -f UTF-16 -t UTF-8 FILE | mlccactl learn -"},
    {"\xfe\xff"sv, "it is a text in UTF-16: iconv -f UTF-16 -t UTF-8 FILE | mlccactl learn -"},
});

Result<Reader> known_reader_of(Bytes head) {
  for (const Other& other : kOthers)
    if (text_of(head).starts_with(other.begins)) return fail(std::string(other.is));
  if (const Reader reader = reader_of(head); reader != nullptr) return reader;
  return fail(
      "this is no recording that can be read: a log of candump (-l, -ta), pcap or pcapng with "
      "frames of CAN or Ethernet, or a log of a Vector tool (.asc, .blf), also packed by gzip");
}

/// Reads input that is not compressed.
Result<Left> read_plain(Input& input, const std::string& stem, Interfaces& interfaces,
                        const OnFrame& on_frame, const std::string& remark) {
  // The byte order mark of UTF-8 texts on Windows.
  constexpr std::string_view mark = "\xef\xbb\xbf";
  if (text_of(input.from(0, mark.size())).starts_with(mark)) input.begin_at(mark.size());
  Bytes head = input.from(0, Lines::kLongest);
  head = head.first(std::min(head.size(), Lines::kLongest));
  if (input.error()) return std::unexpected(*input.error());
  if (head.empty()) return fail(remark.empty() ? "the file is empty" : remark);
  const auto read = known_reader_of(head);
  if (!read) return std::unexpected(read.error());
  Recording recording{input, interfaces, on_frame, stem};
  const auto done = (*read)(recording);
  if (input.error()) return std::unexpected(*input.error());
  if (!done) return std::unexpected(done.error());
  if (!remark.empty())
    if (const auto cut = recording.cut(remark); !cut) return std::unexpected(cut.error());
  return std::move(recording.left);
}

/// The name of a file without extensions: "bus-a" of "logs/bus-a.pcap.gz".
std::string stem_of(const std::filesystem::path& path) {
  const auto stem = path.stem();
  return path.extension() == ".gz" ? stem.stem() : stem;
}

}  // namespace

void Interfaces::begin_recording(std::string recording) {
  recording_ = std::move(recording);
  unnamed_.clear();
}

std::uint32_t Interfaces::add(std::string name, Medium medium) {
  if (names_.size() == kMost) return kMost;
  names_.push_back(std::move(name));
  media_.push_back(medium);
  return static_cast<std::uint32_t>(names_.size() - 1);
}

bool Interfaces::is_taken(const std::string& name) const {
  return reserved_.contains(name) || std::ranges::find(names_, name) != names_.end();
}

/// "can1-2" of "can1": the first such name that is free, and no longer than that of an interface.
std::string Interfaces::distinguished(const std::string& name) const {
  constexpr std::size_t longest = 15;
  for (std::size_t i = 2;; ++i) {
    const std::string end = "-" + std::to_string(i);
    if (std::string out = name.substr(0, longest - end.size()) + end; !is_taken(out)) return out;
  }
}

/// The name of this interface was made up, and is that of another one.
void Interfaces::rename(std::uint32_t number) {
  auto origin = made_up_.extract(names_[number]);
  names_[number] = distinguished(names_[number]);
  origin.key() = names_[number];
  made_up_.insert(std::move(origin));
}

std::uint32_t Interfaces::number_of(std::string_view name, Medium medium) {
  const auto known = std::ranges::find(names_, name);
  if (known != names_.end()) {
    const auto number = static_cast<std::size_t>(known - names_.begin());
    if (made_up_.contains(*known)) {
      rename(static_cast<std::uint32_t>(number));
      return add(std::string(name), medium);
    }
    if (media_[number] == Medium::unknown) media_[number] = medium;
    if (medium == Medium::unknown || media_[number] == medium)
      return static_cast<std::uint32_t>(number);
    return number_of(std::string(name) + (medium == Medium::can ? "-can" : "-eth"), medium);
  }
  return add(std::string(name), medium);
}

std::uint32_t Interfaces::number_of_made_up(std::string_view name, Medium medium) {
  const std::pair key{std::string(name), medium};
  if (const auto known = unnamed_.find(key); known != unnamed_.end()) return known->second;
  std::string own = key.first;
  for (const Medium other : {Medium::can, Medium::ethernet})
    if (other != medium && unnamed_.contains({own, other}))
      own += medium == Medium::can ? "-can" : "-eth";
  if (is_taken(own)) own = distinguished(own);
  const std::uint32_t number = add(own, medium);
  if (number == kMost) return kMost;
  unnamed_.emplace(key, number);
  made_up_.emplace(std::move(own), Origin{recording_, key.first});
  return number;
}

std::string_view next_word(std::string_view& line) {
  const auto begin = line.find_first_not_of(" \t");
  if (begin == std::string_view::npos) {
    line = {};
    return {};
  }
  line.remove_prefix(begin);
  const auto word = line.substr(0, line.find_first_of(" \t"));
  line.remove_prefix(word.size());
  return word;
}

namespace {

Result<Left> read_input(Input& input, const std::string& stem, Interfaces& interfaces,
                        const OnFrame& on_frame) {
  if (!is_gzip(input)) return read_plain(input, stem, interfaces, on_frame, {});
  Gunzip gunzip(input);
  Input unpacked([&](std::span<std::uint8_t> to) { return gunzip.pull(to); });
  return read_plain(unpacked, stem, interfaces, on_frame, gunzip.remark());
}

Naming naming_in(Input& input) {
  constexpr std::string_view mark = "\xef\xbb\xbf";
  if (text_of(input.from(0, mark.size())).starts_with(mark)) input.begin_at(mark.size());
  const Bytes head = input.from(0, Lines::kLongest);
  const Reader reader = reader_of(head.first(std::min(head.size(), Lines::kLongest)));
  return reader == read_asc || reader == read_blf || reader == read_pcap ? Naming::none
                                                                         : Naming::names;
}

}  // namespace

Naming naming_of(const std::string& path) {
  struct stat status{};
  const bool is_standard = path == "-";
  // To open a named pipe would wait for its writer.
  if ((is_standard ? ::fstat(STDIN_FILENO, &status) : ::stat(path.c_str(), &status)) != 0 ||
      !S_ISREG(status.st_mode))
    return Naming::unknown;
  const auto file = RecordingFile::open(path);
  if (!file || !file->bytes()) return Naming::unknown;
  Input input(*file->bytes());
  if (!is_gzip(input)) return naming_in(input);
  Gunzip gunzip(input);
  Input unpacked([&](std::span<std::uint8_t> to) { return gunzip.pull(to); });
  return naming_in(unpacked);
}

Result<Left> read_recording(Input& input, const std::string& stem, Interfaces& interfaces,
                            const OnFrame& on_frame) {
  interfaces.begin_recording(stem);
  return read_input(input, stem, interfaces, on_frame);
}

Result<Left> read_recording(Bytes bytes, const std::string& stem, Interfaces& interfaces,
                            const OnFrame& on_frame) {
  Input input(bytes);
  return read_recording(input, stem, interfaces, on_frame);
}

Result<Left> read_recording(const std::string& path, Interfaces& interfaces,
                            const OnFrame& on_frame, const std::function<bool()>& stop) {
  const bool is_standard = path == "-";
  const std::string name = is_standard ? "standard input" : path;
  const auto named = [&](Result<Left> left) -> Result<Left> {
    if (!left) return fail(name + ": " + left.error().text);
    return left;
  };
  const auto file = RecordingFile::open(path);
  if (!file) return fail(name + ": " + file.error().text);
  interfaces.begin_recording(name);
  const std::string stem = stem_of(is_standard ? "stdin" : path);
  if (const auto bytes = file->bytes(); bytes) {
    Input input(*bytes);
    return named(read_input(input, stem, interfaces, on_frame));
  }
  Input input([&](std::span<std::uint8_t> to) { return file->read(to, stop); });
  return named(read_input(input, stem, interfaces, on_frame));
}

}  // namespace mlcca::learn
