// SPDX-License-Identifier: BSD-2-Clause
// Reader for logs of Vector tools in binary form: a header "LOGG", then objects "LOBJ". Objects in
// containers are compressed by zlib. Numbers are little-endian. An object may begin in one
// container and end in the next one.
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tools/learn/formats.hpp"

namespace mlcca::learn {
namespace {

constexpr std::uint32_t kCanMessage = 1;
constexpr std::uint32_t kContainer = 10;
constexpr std::uint32_t kCanMessage2 = 86;
constexpr std::uint32_t kFdMessage = 100;
constexpr std::uint32_t kFdMessage64 = 101;
constexpr std::uint32_t kErrorFrame = 2;
constexpr std::uint32_t kErrorFrameExt = 73;
constexpr std::uint32_t kErrorFrame64 = 104;
constexpr std::uint32_t kObject = 0x4a424f4c;  // "LOBJ"
constexpr std::uint32_t kNothing = 0;
constexpr std::uint32_t kLongestObject = 1U << 20U;      // longest object that may be a frame
constexpr std::uint32_t kLargestContainer = 64U << 20U;  // uncompressed; tools write 128 KiB
/// Longest object in the file.
constexpr std::uint32_t kLargestObject = kLargestContainer + (1U << 16U);
constexpr std::uint32_t kLargestHeader = 1U << 16U;
constexpr std::size_t kHeader = 16;            // length of the header that all objects have
constexpr std::size_t kBefore = 32;            // length of a container before its data
constexpr std::uint32_t kTenMicroseconds = 1;  // unit of times; otherwise ns

template <class Number>
Number at(Bytes bytes, std::size_t offset) {
  return number_at<Number>(bytes, offset, false);
}

class Blf {
 public:
  explicit Blf(Recording& recording) : recording_(recording) {}

  Result<void> read() {
    Input& input = recording_.input;
    if (input.from(0, 8).size() < 8) return fail("the file ends within its header");
    const auto header = at<std::uint32_t>(input.from(0, 8), 4);
    if (header < 8 || header > kLargestHeader)
      return fail("offset 4: a header of " + std::to_string(header) + " bytes does not fit");
    for (std::uint64_t offset = header;;) {
      const Bytes begun = input.from(offset, kHeader);
      if (begun.size() < kHeader) return {};
      if (at<std::uint32_t>(begun, 0) != kObject)
        return fail("offset " + std::to_string(offset) + ": no object begins here");
      const std::uint64_t size = at<std::uint32_t>(begun, 8);
      if (size < kHeader || size > kLargestObject)
        return fail("offset " + std::to_string(offset + 8) + ": an object of " +
                    std::to_string(size) + " bytes does not fit into the file");
      const Bytes all = input.from(offset, size);
      if (all.size() < size) return take_cut(all, offset, size);
      const Bytes object = all.first(size);
      if (at<std::uint32_t>(object, 12) == kContainer) {
        if (const auto done = open_container(object); !done)
          return fail("offset " + std::to_string(offset) + ": " + done.error().text);
      } else {
        take_object(object);
      }
      offset += size + size % 4;
    }
  }

 private:
  /// The file ends within this object, because its writer was killed. Uses what is complete in a
  /// container.
  Result<void> take_cut(Bytes object, std::uint64_t offset, std::uint64_t size) {
    if (at<std::uint32_t>(object, 12) == kContainer && object.size() > kBefore)
      (void)open_container(object, true);
    if (recording_.handed_over == 0)
      return fail("offset " + std::to_string(offset + 8) + ": an object of " +
                  std::to_string(size) + " bytes does not fit into the file");
    return recording_.cut("offset " + std::to_string(offset) +
                          ": the file ends within an object of " + std::to_string(size) + " bytes");
  }

  /// Decompresses a container whose end is missing, as far as possible. Returns the number of
  /// bytes.
  static std::size_t uncompress_cut(Bytes packed, std::span<std::uint8_t> to) {
    z_stream stream{};
    if (::inflateInit(&stream) != Z_OK) return 0;
    stream.next_in = const_cast<Bytef*>(packed.data());  // NOLINT(*-const-cast): zlib only reads it
    stream.avail_in = static_cast<uInt>(packed.size());
    stream.next_out = to.data();
    stream.avail_out = static_cast<uInt>(to.size());
    (void)::inflate(&stream, Z_SYNC_FLUSH);
    const std::size_t done = to.size() - stream.avail_out;
    (void)::inflateEnd(&stream);
    return done;
  }

  Result<void> open_container(Bytes object, bool is_cut = false) {
    if (object.size() < kBefore) return fail("a container without its header");
    const auto method = at<std::uint16_t>(object, kHeader);
    const auto size = at<std::uint32_t>(object, kHeader + 8);
    const Bytes packed = object.subspan(kBefore);
    if (size > kLargestContainer)
      return fail("a container of " + std::to_string(size) +
                  " bytes: " + std::to_string(kLargestContainer) + " are the limit");
    const std::size_t kept = rest_.size();
    if (method == 0) {
      rest_.insert(rest_.end(), packed.begin(), packed.end());
    } else if (method == 2 && is_cut) {
      rest_.resize(kept + size);
      rest_.resize(kept + uncompress_cut(packed, std::span(rest_).subspan(kept)));
    } else if (method == 2) {
      rest_.resize(kept + size);
      uLongf length = size;
      if (::uncompress(rest_.data() + kept, &length, packed.data(), packed.size()) != Z_OK ||
          length != size)
        return fail("a container that cannot be uncompressed");
    } else {
      return fail("a container with compression method " + std::to_string(method) +
                  ": 0 (none) and 2 (zlib) are known");
    }
    return take_objects();
  }

  /// Handles all complete objects, and keeps the beginning of an incomplete one.
  Result<void> take_objects() {
    const Bytes all(rest_);
    std::size_t offset = 0;
    while (all.size() - offset >= kHeader) {
      if (at<std::uint32_t>(all, offset) != kObject) {  // padding between objects
        ++offset;
        continue;
      }
      const auto size = at<std::uint32_t>(all, offset + 8);
      if (size < kHeader || size > kLongestObject)
        return fail("an object of " + std::to_string(size) + " bytes");
      if (size > all.size() - offset) break;
      take_object(all.subspan(offset, size));
      offset += size;
    }
    rest_.erase(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(offset));
    return {};
  }

  void take_object(Bytes object) {
    constexpr std::size_t shortest = 32;  // header with a time
    const auto type = at<std::uint32_t>(object, 12);
    if (type != kCanMessage && type != kCanMessage2 && type != kFdMessage && type != kFdMessage64) {
      if (type == kErrorFrame || type == kErrorFrameExt || type == kErrorFrame64)
        ++recording_.left.errors;
      else if (type != kNothing)
        recording_.pass_over("an object of type " + std::to_string(type));
      return;
    }
    const std::size_t header = at<std::uint16_t>(object, 4);
    if (object.size() < shortest || header < shortest || header > object.size()) return;
    Frame frame;
    const auto time = at<std::uint64_t>(object, 24);
    const bool coarse = at<std::uint32_t>(object, kHeader) == kTenMicroseconds;
    if (coarse && time > UINT64_MAX / 10'000) return;
    frame.ns = coarse ? time * 10'000 : time;
    const Bytes body = object.subspan(header);
    if (type == kFdMessage64)
      take_fd64(body, frame);
    else
      take_message(body, type == kFdMessage, frame);
  }

  void take_message(Bytes body, bool fd, Frame frame) {
    const std::size_t data = fd ? 20 : 8;
    if (body.size() < data) return;
    const auto flags = body[2];
    frame.local = (flags & 1U) != 0;
    frame.fd = fd && (body[13] & 1U) != 0;
    std::size_t size = fd ? body[14] : std::min<std::size_t>(body[3], 8);
    if ((flags & 0x80U) != 0) size = 0;
    hand_over(body, data, size, (flags & 0x80U) != 0, at<std::uint16_t>(body, 0), frame);
  }

  void take_fd64(Bytes body, Frame frame) {
    constexpr std::size_t data = 40;
    if (body.size() < data) return;
    const auto flags = at<std::uint32_t>(body, 12);
    frame.fd = (flags & 0x1000U) != 0;
    frame.local = body[35] == 1;
    const bool remote = (flags & 0x10U) != 0;
    hand_over(body, data, remote ? 0 : body[2], remote, body[0], frame);
  }

  void hand_over(Bytes body, std::size_t data, std::size_t size, bool remote, unsigned channel,
                 Frame& frame) {
    if (size > (frame.fd ? 64U : 8U) || size > body.size() - data) return;
    frame.id = at<std::uint32_t>(body, 4) & (kExtended | kIdentifierBits);
    if (!frame.is_extended() && frame.id > 0x7ff) return;
    if (remote) frame.id |= kRemote;
    frame.data = body.subspan(data, size);
    frame.interface = recording_.interfaces.number_of_made_up("can" + std::to_string(channel));
    recording_.take(frame);
  }

  Recording& recording_;
  std::vector<std::uint8_t> rest_;
};

}  // namespace

Result<void> read_blf(Recording& recording) { return Blf(recording).read(); }

}  // namespace mlcca::learn
