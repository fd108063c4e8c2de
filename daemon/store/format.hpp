// SPDX-License-Identifier: BSD-2-Clause
// The bytes of the journal's file (docs/reference/journal.md): a head and batches of entries, which
// are messages of journal.proto. Integers of heads are little endian. The first batch is the state
// that the file began with.
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
/// Batches begin at multiples of this.
inline constexpr std::size_t kAlign = 8;

/// Of a file whose batch heads are bound to it by `salt`, a number that no other program knows:
/// bytes of another file, or of a client's text, are never taken for a batch of this one.
std::string file_head(std::uint64_t salt);
/// The salt; an error if the bytes do not begin with a whole head, or with that of another layout.
Result<std::uint64_t> read_file_head(std::string_view bytes);

/// One entry, with its head.
std::string encode(const Entry& entry);
/// Not for one that only takes something away: a file written again has nothing of that.
bool is_alive(const Entry& entry);
/// Bytes that the entry needs in a file written again.
std::uint64_t live_bytes(const Entry& entry);

/// A batch of `count` encoded entries, with its head and filled up to kAlign.
std::string batch(std::uint64_t salt, std::uint64_t sequence, std::uint32_t count,
                  std::string entries);
/// The first batch of a file: all of `contents`.
std::string snapshot(std::uint64_t salt, const Contents& contents);

struct BatchHead {
  std::uint32_t count = 0;     ///< entries
  std::uint64_t sequence = 0;  ///< 0: the snapshot; then 1, 2, …
  std::uint64_t length = 0;    ///< bytes behind the head
  std::uint64_t checksum = 0;  ///< of those
};
/// Nothing if the bytes do not begin with the whole head of a batch of this file.
std::optional<BatchHead> read_batch_head(std::string_view bytes, std::uint64_t salt);

/// True if somewhere in the bytes, at a multiple of kAlign, there is the head of a batch.
bool holds_batch_head(std::string_view bytes, std::uint64_t salt);

/// What is behind the head of a batch, entry by entry.
class Reader {
 public:
  Reader(const BatchHead& head, std::string_view bytes) : left_(head.count), bytes_(bytes) {}

  /// Nothing after the last one. An error is no damage, the checksum was right: the words of a
  /// later version.
  Result<std::optional<Entry>> next();
  /// Of the last entry, with its head.
  [[nodiscard]] std::uint64_t bytes() const { return last_; }

 private:
  std::uint32_t left_;
  std::string_view bytes_;
  std::uint64_t last_ = 0;
};

}  // namespace mlcca::store::format
