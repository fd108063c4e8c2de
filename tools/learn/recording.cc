// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/recording.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include "tools/learn/formats.hpp"
#include "tools/learn/mapped_file.hpp"

namespace mlcca::learn {
namespace {

using Reader = Result<void> (*)(Recording&);

/// By what a file begins with; text is distinguished by its first line.
Reader reader_of(Bytes bytes) {
  const std::string_view text(
      reinterpret_cast<const char*>(bytes.data()),  // NOLINT(*-reinterpret-cast)
      std::min<std::size_t>(bytes.size(), 512));
  using namespace std::string_view_literals;
  if (text.starts_with("LOGG")) return read_blf;
  if (text.starts_with("\x0a\x0d\x0d\x0a"sv)) return read_pcapng;
  for (const auto magic :
       {"\xa1\xb2\xc3\xd4"sv, "\xd4\xc3\xb2\xa1"sv, "\xa1\xb2\x3c\x4d"sv, "\x4d\x3c\xb2\xa1"sv})
    if (text.starts_with(magic)) return read_pcap;
  if (text.starts_with("date ") || text.starts_with("base ") || text.starts_with("//"))
    return read_asc;
  if (screen_of(bytes) != Screen::none) return read_candump_screen;
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && text[first] == '(') return read_candump;
  return nullptr;
}

}  // namespace

std::uint32_t Interfaces::number_of(std::string_view name, Medium medium) {
  const auto known = std::ranges::find(names_, name);
  if (known != names_.end()) {
    const auto number = static_cast<std::size_t>(known - names_.begin());
    if (media_[number] == Medium::unknown) media_[number] = medium;
    if (medium == Medium::unknown || media_[number] == medium)
      return static_cast<std::uint32_t>(number);
    return number_of(std::string(name) + (medium == Medium::can ? "-can" : "-eth"), medium);
  }
  if (names_.size() == kMost) return kMost;
  names_.emplace_back(name);
  media_.push_back(medium);
  return static_cast<std::uint32_t>(names_.size() - 1);
}

std::uint32_t Interfaces::number_of_made_up(std::string_view name, Medium medium) {
  const std::size_t before = names_.size();
  const std::uint32_t number = number_of(name, medium);
  if (names_.size() != before) made_up_.insert(names_.back());
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

Result<Left> read_recording(Bytes bytes, const std::string& stem, Interfaces& interfaces,
                            const OnFrame& on_frame) {
  const Reader read = reader_of(bytes);
  if (read == nullptr)
    return fail(
        "this is no recording that can be read: a log of candump (-l, -ta), pcap or pcapng with "
        "frames "
        "of CAN or Ethernet, or a log of a Vector tool (.asc, .blf)");
  Recording recording{bytes, interfaces, on_frame, stem};
  if (const auto done = read(recording); !done) return std::unexpected(done.error());
  return std::move(recording.left);
}

Result<Left> read_recording(const std::string& path, Interfaces& interfaces,
                            const OnFrame& on_frame) {
  const auto file = MappedFile::open(path);
  if (!file) return std::unexpected(file.error());
  auto left =
      read_recording(file->bytes(), std::filesystem::path(path).stem(), interfaces, on_frame);
  if (!left) return fail(path + ": " + left.error().text);
  return left;
}

}  // namespace mlcca::learn
