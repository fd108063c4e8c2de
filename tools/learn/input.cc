// SPDX-License-Identifier: BSD-2-Clause
#include "tools/learn/input.hpp"

#include <zlib.h>

#include <algorithm>
#include <limits>

namespace mlcca::learn {
namespace {

constexpr std::size_t kPiece = std::size_t{256} << 10U;  // the least that is read at once
constexpr int kOfGzip = 16 + MAX_WBITS;

}  // namespace

void Input::begin_at(std::size_t bytes) { begin_ = bytes; }

Bytes Input::from(std::uint64_t offset, std::size_t least) {
  offset += begin_;
  while (!ended_ && there_.size() < offset - forgotten_) {  // the bytes in between are not needed
    forgotten_ += there_.size();
    there_ = {};
    read(1);
  }
  const auto skipped = std::min<std::uint64_t>(offset - forgotten_, there_.size());
  forgotten_ += skipped;
  there_ = there_.subspan(static_cast<std::size_t>(skipped));
  if (there_.size() < least && !ended_) read(least);
  return offset == forgotten_ ? there_ : Bytes{};
}

/// Reads until `least` bytes are available, or the input ends.
void Input::read(std::size_t least) {
  const std::size_t kept = there_.size();
  if (kept != 0) std::copy(there_.begin(), there_.end(), buffer_.begin());
  buffer_.resize(std::max({buffer_.size(), least, kPiece}));
  std::size_t filled = kept;
  while (filled < least && !ended_) {
    const auto more = pull_(std::span(buffer_).subspan(filled));
    if (!more) error_ = more.error();
    ended_ = !more || *more == 0;
    if (!ended_) filled += *more;
  }
  there_ = Bytes(buffer_).first(filled);
}

// --- gzip ----------------------------------------------------------------------------------------

bool is_gzip(Input& input) {
  const Bytes head = input.from(0, 2);
  return head.size() >= 2 && head[0] == 0x1f && head[1] == 0x8b;
}

struct Gunzip::Stream : z_stream {};

Gunzip::Gunzip(Input& packed) : packed_(packed), stream_(std::make_unique<Stream>()) {
  ended_ = ::inflateInit2(stream_.get(), kOfGzip) != Z_OK;
}

Gunzip::~Gunzip() { static_cast<void>(::inflateEnd(stream_.get())); }

Result<std::size_t> Gunzip::pull(std::span<std::uint8_t> to) {
  constexpr std::size_t most = std::numeric_limits<uInt>::max();
  to = to.first(std::min(to.size(), most));
  stream_->next_out = to.data();
  stream_->avail_out = static_cast<uInt>(to.size());
  while (!ended_ && stream_->avail_out == to.size()) {
    const Bytes packed = packed_.from(offset_, 1);
    if (packed_.error()) return std::unexpected(*packed_.error());
    if (packed.empty()) {
      remark_ = "the file ends within what gzip has packed";
      ended_ = true;
      break;
    }
    const auto size = static_cast<uInt>(std::min(packed.size(), most));
    stream_->next_in =
        const_cast<Bytef*>(packed.data());  // NOLINT(*-const-cast): zlib only reads it
    stream_->avail_in = size;
    const int done = ::inflate(stream_.get(), Z_NO_FLUSH);
    offset_ += size - stream_->avail_in;
    if (done == Z_STREAM_END)
      ended_ = !begin_next();
    else if (done != Z_OK && done != Z_BUF_ERROR)
      damaged_ = ended_ = true;
  }
  const std::size_t unpacked = to.size() - stream_->avail_out;
  if (unpacked == 0 && damaged_)  // the bytes before the damage are returned first
    return fail("what gzip has packed is damaged at offset " + std::to_string(offset_));
  return unpacked;
}

bool Gunzip::begin_next() {
  const Bytes next = packed_.from(offset_, 2);
  if (packed_.error()) return true;  // pull() returns the error
  if (next.size() >= 2 && next[0] == 0x1f && next[1] == 0x8b)
    return ::inflateReset(stream_.get()) == Z_OK;
  // A tape may have filled its last block with zeros.
  if (std::ranges::any_of(next, [](std::uint8_t byte) { return byte != 0; }))
    remark_ = "offset " + std::to_string(offset_) + ": not packed by gzip, as what is before it";
  return false;
}

}  // namespace mlcca::learn
