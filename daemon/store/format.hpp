// SPDX-License-Identifier: BSD-2-Clause
// The format of the journal's file (docs/reference/journal.md): a head and batches of entries,
// which are messages of journal.proto. Integers in heads are little-endian. The first batch is the
// state with which the file began.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "daemon/store/contents.hpp"

namespace mlcca::store::format {

inline constexpr std::size_t kFileHead = 24;
inline constexpr std::size_t kBatchHead = 40;
inline constexpr std::size_t kEntryHead = 4;
/// Batches begin at multiples of this; bytes.
inline constexpr std::size_t kAlign = 8;

/// The head of a file. Its batch heads contain `salt`, a number that no other program knows, so
/// that bytes of another file, or of a client's text, are never taken for a batch of this one.
std::string file_head(std::uint64_t salt);
/// The salt. An error if the bytes do not begin with a complete head, or the head has another
/// layout.
Result<std::uint64_t> read_file_head(std::string_view bytes);

/// One entry with its head.
std::string encode(const Entry& entry);
/// Whether the entry adds something. False if it only removes something: a rewritten file does not
/// contain such entries.
bool is_alive(const Entry& entry);
/// The bytes that the entry needs in a rewritten file.
std::uint64_t live_bytes(const Entry& entry);

/// A batch of `count` encoded entries, with its head and padded to kAlign.
std::string batch(std::uint64_t salt, std::uint64_t sequence, std::uint32_t count,
                  std::string entries);
/// The first batch of a file: the complete `contents`.
std::string snapshot(std::uint64_t salt, const Contents& contents);

/// The head of a batch.
struct BatchHead {
  std::uint32_t count = 0;     ///< entries
  std::uint64_t sequence = 0;  ///< 0: the snapshot; then 1, 2, …
  std::uint64_t length = 0;    ///< bytes after the head
  std::uint64_t checksum = 0;  ///< of these bytes
};
/// nullopt if the bytes do not begin with the complete head of a batch of this file.
std::optional<BatchHead> read_batch_head(std::string_view bytes, std::uint64_t salt);

/// Whether there is the head of a batch anywhere in the bytes, at a multiple of kAlign.
bool holds_batch_head(std::string_view bytes, std::uint64_t salt);

/// Reads the entries of a batch, whose bytes follow its head.
class Reader {
 public:
  Reader(const BatchHead& head, std::string_view bytes) : left_(head.count), bytes_(bytes) {}

  /// The next entry; nullopt after the last one. An error is not damage, because the checksum was
  /// right: it means an entry of a later version.
  Result<std::optional<Entry>> next();
  /// The bytes of the last entry, with its head.
  [[nodiscard]] std::uint64_t bytes() const { return last_; }

 private:
  std::uint32_t left_;
  std::string_view bytes_;
  std::uint64_t last_ = 0;
};

}  // namespace mlcca::store::format
