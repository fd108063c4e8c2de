// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/interface_files.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <net/if.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include "base/ascii.hpp"
#include "base/handle.hpp"
#include "base/result.hpp"

namespace mlcca {
namespace {

constexpr std::string_view kSetting = "MLCCA_INTERFACES";
constexpr std::string_view kSuffix = ".conf";
constexpr std::string_view kBlank = " \t\r";
constexpr std::size_t kMistakes = 32;
constexpr std::size_t kShownCharacters = 40;

std::string reason_of(int error) {
  return std::strerror(error);  // NOLINT(concurrency-mt-unsafe)
}

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

/// The word without control characters and shortened, for the log.
std::string shown(std::string_view word) {
  std::string text(word.substr(0, kShownCharacters));
  std::ranges::replace_if(text, [](char c) { return c < ' ' || c > '~'; }, '?');
  return text + (word.size() > kShownCharacters ? "…" : "");
}

/// The text of a file; nullopt if it does not exist. Opening must not wait for a FIFO or a device.
Result<std::optional<std::string>> text_of(const std::string& path) {
  const Fd file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (!file) {
    if (errno == ENOENT) return std::nullopt;
    return fail(reason_of(errno));
  }
  struct stat facts{};
  if (::fstat(file.get(), &facts) < 0) return fail(reason_of(errno));
  if (!S_ISREG(facts.st_mode)) return fail("is no file");
  std::string text(kInterfaceFileBytes + 1, '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const auto got = ::read(file.get(), text.data() + size, text.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return fail(reason_of(errno));
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  if (size > kInterfaceFileBytes)
    return fail(fmt::format("has more than {} bytes", kInterfaceFileBytes));
  text.resize(size);
  return text;
}

/// Why a word cannot be the name of an interface; nullopt if it can.
std::optional<std::string> fault_of_name(std::string_view word) {
  if (word == "." || word == ".." || !std::ranges::all_of(word, is_of_interface_name))
    return "is no name of an interface (names stand between spaces)";
  if (word.size() >= IFNAMSIZ)
    return fmt::format("is no name of an interface: it has at most {} characters", IFNAMSIZ - 1);
  return std::nullopt;
}

class InterfaceFileReader {
 public:
  explicit InterfaceFileReader(InterfaceFiles& found) : found_(found) {}

  void read(const std::string& path, bool must_be_there) {
    const auto text = text_of(path);
    if (!text)
      mistake(path, text.error().text);
    else if (*text)
      read_lines(path, **text);
    else if (must_be_there)
      mistake(path, reason_of(ENOENT));
  }
  void mistake(const std::string& place, const std::string& what) {
    if (found_.mistakes.size() < kMistakes)
      found_.mistakes.push_back(place + ": " + what);
    else if (found_.mistakes.size() == kMistakes)
      found_.mistakes.push_back(place + ": there are more mistakes");
  }

 private:
  void read_lines(const std::string& path, std::string_view text) {
    for (std::size_t number = 1; !text.empty(); ++number) {
      const auto end = std::min(text.find('\n'), text.size());
      read_line(fmt::format("{}:{}", path, number), trimmed(text.substr(0, end)));
      text.remove_prefix(std::min(end + 1, text.size()));
    }
  }
  void read_line(const std::string& place, std::string_view line) {
    if (line.empty() || line.front() == '#' || line.front() == ';') return;
    const auto equals = line.find('=');
    if (equals == std::string_view::npos)
      return mistake(place, fmt::format("'{}' is no setting: {}=NAME… is", shown(line), kSetting));
    if (const auto key = trimmed(line.substr(0, equals)); key != kSetting)
      return mistake(place, fmt::format("'{}' is no setting: {} is", shown(key), kSetting));
    auto value = trimmed(line.substr(equals + 1));
    if (!value.empty() && (value.front() == '"' || value.front() == '\'')) {
      if (value.size() < 2 || value.back() != value.front())
        return mistake(place, "a quotation mark has no other one");
      value = value.substr(1, value.size() - 2);
    }
    read_names(place, value);
  }
  void read_names(const std::string& place, std::string_view list) {
    for (auto rest = trimmed(list); !rest.empty();) {
      const auto word = rest.substr(0, rest.find_first_of(kBlank));
      rest = trimmed(rest.substr(word.size()));
      if (const auto fault = fault_of_name(word))
        mistake(place, fmt::format("'{}' {}", shown(word), *fault));
      else if (!found_.names(word) && !add(place, word))
        return;
    }
  }
  bool add(const std::string& place, std::string_view name) {
    const bool has_room = found_.named.size() < kNamedInterfaces;
    if (has_room)
      found_.named.push_back({std::string(name), place});
    else
      mistake(place, fmt::format("more than {} interfaces are named", kNamedInterfaces));
    return has_room;
  }

  InterfaceFiles& found_;
};

struct CloseFolder {
  void operator()(DIR* folder) const { ::closedir(folder); }
};

Result<std::vector<std::string>> files_of(const std::string& path) {
  std::vector<std::string> names;
  const std::unique_ptr<DIR, CloseFolder> folder(::opendir(path.c_str()));
  if (!folder) {
    if (errno == ENOENT) return names;
    return fail(reason_of(errno));
  }
  errno = 0;
  while (const dirent* entry = ::readdir(folder.get())) {  // NOLINT(concurrency-mt-unsafe): ours
    const std::string_view name = &entry->d_name[0];
    if (!name.starts_with('.') && name.ends_with(kSuffix)) names.emplace_back(name);
    errno = 0;
  }
  if (errno != 0) return fail(reason_of(errno));
  std::ranges::sort(names);
  return names;
}

}  // namespace

bool InterfaceFiles::names(std::string_view interface) const {
  return std::ranges::find(named, interface, &NamedInterface::name) != named.end();
}

InterfaceFiles read_interface_files(const std::string& directory) {
  InterfaceFiles found;
  InterfaceFileReader reader(found);
  reader.read(directory + "/gate.conf", false);
  const std::string folder = directory + "/conf.d";
  auto files = files_of(folder);
  if (!files) {
    reader.mistake(folder, files.error().text);
    return found;
  }
  if (files->size() > kInterfaceFiles) {
    reader.mistake(folder, fmt::format("has more than {} files: {} and what follows is not read",
                                       kInterfaceFiles, (*files)[kInterfaceFiles]));
    files->resize(kInterfaceFiles);
  }
  for (const std::string& file : *files) reader.read(fmt::format("{}/{}", folder, file), true);
  return found;
}

}  // namespace mlcca
