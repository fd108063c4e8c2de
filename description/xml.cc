// SPDX-License-Identifier: BSD-2-Clause
// Opens the files of a description, follows inclusions, and enforces the limits of all files
// together.
#include "description/xml.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "description/builder.hpp"
#include "description/bundle.hpp"
#include "description/include.hpp"
#include "description/parser.hpp"
#include "description/source.hpp"

namespace mlcca::description {
namespace {

using core::FindingId;

constexpr std::uint64_t kReportedStep = std::uint64_t{1} << 20U;  // bytes between two reports of
                                                                  // progress

class Document {
 public:
  Document(Root root, Problems& problems, const Receiver& receiver, const Progress& progress,
           bool hashes = false, bool copies = false)
      : problems_(problems),
        progress_(progress),
        builder_(root, problems, receiver,
                 [this](std::string_view href, core::Origin at) { include(href, at); }),
        hashes_(hashes),
        copies_(copies) {}

  bool read_files(std::span<const std::string> paths);
  bool read_text(std::string_view xml, const std::string& base);
  bool read_supplied(std::string_view bundle);
  [[nodiscard]] Sha256::Digest digest() const { return digest_of(digests_); }
  [[nodiscard]] std::string bundle() const { return copies_ ? bundle_of(files_) : std::string(); }

 private:
  /// A file that is being read.
  struct OpenFile {
    std::string path;
    std::optional<std::string> folder;  ///< where includes are looked up; nullopt: they are refused
    std::optional<Source::Identity> identity;
  };

  void read_file(const std::string& path);
  void include(std::string_view href, core::Origin at);
  [[nodiscard]] std::optional<std::string> refusal(const Source& source,
                                                   const std::string& path) const;
  void parse(Source& source, OpenFile file);
  bool account(std::size_t bytes);

  Problems& problems_;
  const Progress& progress_;
  Builder builder_;
  bool hashes_, copies_;
  std::vector<Sha256::Digest> digests_;  ///< of the files in the order in which they are opened
  std::vector<BundledFile> files_;       ///< in the same order
  std::vector<FileInBundle> supplied_;   ///< files of a bundle, used instead of files on disk
  std::size_t next_ = 0;                 ///< index of the next one
  std::vector<OpenFile> open_;
  std::size_t opened_ = 0;   ///< number of files so far
  std::uint64_t total_ = 0;  ///< bytes in all files so far
  std::uint64_t read_ = 0;   ///< bytes
  std::uint64_t reported_ = 0;
};

std::string too_many_bytes() {
  return fmt::format("the files of the description have more than {} bytes; that is the limit",
                     kMaxBytes);
}

/// Counts bytes and reports progress. Returns false if the limit of bytes is exceeded.
bool Document::account(std::size_t bytes) {
  read_ += bytes;
  total_ = std::max(total_, read_);
  if (read_ > kMaxBytes) {
    builder_.stop({.file = problems_.add_file(open_.back().path), .line = 0}, "", too_many_bytes(),
                  FindingId::not_xml);
    return false;
  }
  copies_ = copies_ && read_ <= kMaxBundle;
  if (progress_ && read_ - reported_ >= kReportedStep) {
    reported_ = read_;
    progress_(read_, total_);
  }
  return true;
}

/// Why a file that can be opened must not be read now; nullopt if it may.
std::optional<std::string> Document::refusal(const Source& source, const std::string& path) const {
  if (total_ + source.size() > kMaxBytes) return too_many_bytes();
  if (opened_ >= kMaxFiles)
    return fmt::format("more than {} files are included; that is the limit", kMaxFiles);
  if (open_.size() > kMaxIncludes)
    return fmt::format("files are included in each other deeper than {}; that is the limit",
                       kMaxIncludes);
  const auto known = std::ranges::find(open_, source.identity(), &OpenFile::identity);
  if (!source.identity() || known == open_.end()) return std::nullopt;
  std::string chain;
  for (auto file = known; file != open_.end(); ++file) chain += file->path + " includes ";
  return fmt::format("a file cannot include itself: {}{}", chain, path);
}

void Document::parse(Source& source, OpenFile file) {
  total_ += source.size();
  ++opened_;
  const auto number = problems_.add_file(file.path);
  open_.push_back(std::move(file));
  builder_.begin_file(number);
  const std::size_t at = digests_.size();
  Sha256 hash;
  if (hashes_) {
    digests_.emplace_back();
    if (copies_) files_.push_back({.name = open_.back().path, .content = {}});
    source.on_read([&](std::string_view bytes) {
      hash.add(bytes);
      if (copies_) files_[at].content += bytes;
    });
  }
  const bool whole = source.size() <= source.start().size();
  if (const auto wrong = wrong_start(source.start(), whole))
    builder_.fail({.file = number, .line = 1}, "", *wrong, FindingId::not_xml);
  else
    parse_document(source, number, builder_, [this](std::size_t bytes) { return account(bytes); });
  source.on_read(nullptr);
  if (hashes_) digests_[at] = hash.digest();
  builder_.end_file();
  open_.pop_back();
}

void Document::read_file(const std::string& path) {
  const core::Origin whole{.file = problems_.add_file(path), .line = 0};
  auto source = Source::open(path);
  if (!source) {
    builder_.fail(whole, "", source.error().text, FindingId::unreadable);
    return;
  }
  if (const auto why = refusal(*source, path)) {
    builder_.fail(whole, "", *why, FindingId::not_xml);
    return;
  }
  parse(*source, {path, std::string(folder_of(path)), source->identity()});
}

void Document::include(std::string_view href, core::Origin at) {
  const auto refuse = [&](std::string_view text, FindingId id) {
    builder_.fail(at, "include", text, id);
  };
  const auto& folder = open_.back().folder;
  if (!folder) {
    refuse("a text that is no file includes none: there is nothing that href is relative to",
           FindingId::not_in_schema);
    return;
  }
  const auto path = included_path(href, *folder);
  if (!path) {
    refuse(path.error(), FindingId::not_in_schema);
    return;
  }
  if (!supplied_.empty()) {
    if (next_ >= supplied_.size()) {
      refuse("the text has no further file", FindingId::not_in_schema);
      return;
    }
    const FileInBundle& file = supplied_[next_++];
    Source given(file.content);
    const std::string name(file.name);
    if (const auto why = refusal(given, name))
      refuse(*why, FindingId::not_xml);
    else
      parse(given, {name, std::string(folder_of(name)), std::nullopt});
    return;
  }
  auto source = Source::open(*path);
  if (!source) {
    problems_.add_file(*path);  // so that a watcher of the files notices when it appears
    refuse(fmt::format("{}: {}", *path, source.error().text), FindingId::unreadable);
    return;
  }
  if (const auto why = refusal(*source, *path)) {
    refuse(*why, FindingId::not_xml);
    return;
  }
  parse(*source, {*path, std::string(folder_of(*path)), source->identity()});
}

bool Document::read_files(std::span<const std::string> paths) {
  read_file(paths.front());
  for (const auto& path : paths.subspan(1)) {
    if (builder_.stopped()) break;
    builder_.begin_parts();
    read_file(path);
    builder_.end_parts();
  }
  if (progress_) progress_(read_, total_);
  return builder_.valid();
}

bool Document::read_text(std::string_view xml, const std::string& base) {
  Source source(xml);
  const auto& name = problems_.files().front();
  if (const auto why = refusal(source, name)) {
    builder_.fail({.file = 0, .line = 0}, "", *why, FindingId::not_xml);
    return false;
  }
  std::optional<std::string> folder;
  if (!base.empty()) folder = base.ends_with('/') ? base : base + "/";
  parse(source, {name, std::move(folder), std::nullopt});
  return builder_.valid();
}

bool Document::read_supplied(std::string_view bundle) {
  const core::Origin text{.file = 0, .line = 0};
  auto files = files_in(bundle);
  if (!files) {
    builder_.fail(text, "", files.error(), FindingId::not_xml);
    return false;
  }
  supplied_ = std::move(*files);
  const FileInBundle& first = supplied_[next_++];
  Source source(first.content);
  const std::string name(first.name);
  parse(source, {name, std::string(folder_of(name)), std::nullopt});
  if (builder_.valid() && next_ != supplied_.size())
    builder_.fail(text, "", "the text has files that nothing includes", FindingId::not_xml);
  return builder_.valid();
}

}  // namespace

bool parse_files(std::span<const std::string> paths, Root root, Problems& problems,
                 const Receiver& receiver, const Progress& progress, Sha256::Digest* digest,
                 std::string* bundle) {
  Document document(root, problems, receiver, progress, digest != nullptr, bundle != nullptr);
  const bool right = document.read_files(paths);
  if (digest != nullptr) *digest = document.digest();
  if (bundle != nullptr) *bundle = document.bundle();
  return right;
}

bool parse_bundle(std::string_view bundle, Problems& problems, const Receiver& receiver,
                  Sha256::Digest& digest) {
  Document document(Root::system, problems, receiver, {}, true);
  const bool right = document.read_supplied(bundle);
  digest = document.digest();
  return right;
}

bool parse_text(std::string_view xml, const std::string& base, Problems& problems,
                const Receiver& receiver) {
  return Document(Root::system, problems, receiver, {}).read_text(xml, base);
}

}  // namespace mlcca::description
