// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/store/format.hpp"

#include <utility>

#include "control/buffer.hpp"
#include "control/codec.hpp"
#include "daemon/store/checksum.hpp"

namespace mlcca::store::format {
namespace {

constexpr std::string_view kFileMark = "MLCCAJ01";
constexpr std::string_view kBatchMark = "BTCH";

enum class Kind : std::uint8_t {
  admitted = 1,
  removed = 2,
  released = 3,
  reinstated = 4,
  granted = 5,
  next_id = 6,
  gated = 7,
  enforced = 8,
  admitted_by = 9,
  contradicted = 10,
};

template <class Integer>
void put(std::string& to, Integer value) {
  for (std::size_t i = 0; i < sizeof value; ++i)
    to.push_back(static_cast<char>((value >> (8 * i)) & 0xffU));
}

/// Takes an integer off the front, which must hold it.
template <class Integer>
Integer take(std::string_view& from) {
  Integer value = 0;
  for (std::size_t i = 0; i < sizeof value; ++i)
    value |=
        static_cast<Integer>(static_cast<Integer>(static_cast<unsigned char>(from[i])) << (8 * i));
  from.remove_prefix(sizeof value);
  return value;
}

std::string octets(std::uint64_t value) {
  std::string out;
  put(out, value);
  return out;
}

/// A text that others follow.
void put_text(std::string& to, const std::string& text) {
  put(to, static_cast<std::uint32_t>(text.size()));
  to += text;
}
std::optional<std::string> take_text(std::string_view& from) {
  if (from.size() < sizeof(std::uint32_t)) return std::nullopt;
  const auto length = take<std::uint32_t>(from);
  if (length > from.size()) return std::nullopt;
  std::string text(from.substr(0, length));
  from.remove_prefix(length);
  return text;
}

std::string with_head(Kind kind, std::string_view body) {
  std::string out(1, static_cast<char>(kind));
  put(out, static_cast<std::uint32_t>(body.size()));
  return out.append(body);
}

std::uint64_t head_checksum(std::string_view head, std::uint64_t salt) {
  return crc64(head, crc64(octets(salt)));
}

struct Encode {
  std::string operator()(const Admitted& entry) const {
    const std::string request = control::encode(entry.request);
    if (entry.by == 0) return with_head(Kind::admitted, request);
    std::string body;
    put(body, entry.by);
    return with_head(Kind::admitted_by, body + request);
  }
  std::string operator()(const Removed& entry) const {
    return with_head(Kind::removed, octets(entry.id));
  }
  std::string operator()(const Released& entry) const {
    return with_head(Kind::released, entry.subject);
  }
  std::string operator()(const Reinstated& entry) const {
    return with_head(Kind::reinstated, entry.subject);
  }
  std::string operator()(const Granted& entry) const {
    std::string body;
    put_text(body, entry.subject);
    return with_head(Kind::granted, body + entry.state);
  }
  std::string operator()(const Gated& entry) const {
    std::string body;
    put(body, entry.ifindex);
    put_text(body, entry.network);
    put_text(body, entry.interface);
    return with_head(Kind::gated, body + entry.identity);
  }
  std::string operator()(const Enforced& entry) const {
    return with_head(Kind::enforced, octets(entry.subject) + entry.slots);
  }
  std::string operator()(const Contradicted& entry) const {
    std::string body = octets(entry.subject);
    put(body, entry.etag);
    put_text(body, entry.network);
    return with_head(Kind::contradicted, body + entry.how);
  }
};

std::optional<Entry> decode_admitted(std::string_view body, std::uint32_t by = 0) {
  control::Buffer buffer;
  buffer.append(body);
  auto request = control::decode_request(buffer);
  if (!request || !*request || !buffer.content().empty()) return std::nullopt;
  if (!std::holds_alternative<control::Admit>((*request)->body)) return std::nullopt;
  return Admitted{std::move(**request), by};
}

std::optional<Entry> decode_admitted_by(std::string_view body) {
  if (body.size() < sizeof(std::uint32_t)) return std::nullopt;
  const auto by = take<std::uint32_t>(body);
  return decode_admitted(body, by);
}

std::optional<Entry> decode_granted(std::string_view body) {
  auto subject = take_text(body);
  if (!subject) return std::nullopt;
  return Granted{std::move(*subject), std::string(body)};
}

std::optional<Entry> decode_enforced(std::string_view body) {
  if (body.size() < sizeof(std::uint64_t)) return std::nullopt;
  const auto subject = take<std::uint64_t>(body);
  return Enforced{subject, std::string(body)};
}

std::optional<Entry> decode_gated(std::string_view body) {
  if (body.size() < sizeof(std::uint32_t)) return std::nullopt;
  Gated entry;
  entry.ifindex = take<std::uint32_t>(body);
  auto network = take_text(body);
  auto interface = take_text(body);
  if (!network || !interface) return std::nullopt;
  entry.network = std::move(*network);
  entry.interface = std::move(*interface);
  entry.identity = body;
  return entry;
}

std::optional<Entry> decode_contradicted(std::string_view body) {
  Contradicted entry;
  if (body.size() < sizeof entry.subject + sizeof entry.etag) return std::nullopt;
  entry.subject = take<std::uint64_t>(body);
  entry.etag = take<std::uint16_t>(body);
  auto network = take_text(body);
  if (!network) return std::nullopt;
  entry.network = std::move(*network);
  entry.how = body;
  return entry;
}

std::optional<Entry> decode(std::uint8_t kind, std::string_view body) {
  switch (static_cast<Kind>(kind)) {
    case Kind::admitted:
      return decode_admitted(body);
    case Kind::removed:
      if (body.size() != sizeof(std::uint64_t)) return std::nullopt;
      return Removed{take<std::uint64_t>(body)};
    case Kind::released:
      return Released{std::string(body)};
    case Kind::reinstated:
      return Reinstated{std::string(body)};
    case Kind::granted:
      return decode_granted(body);
    case Kind::gated:
      return decode_gated(body);
    case Kind::enforced:
      return decode_enforced(body);
    case Kind::admitted_by:
      return decode_admitted_by(body);
    case Kind::contradicted:
      return decode_contradicted(body);
    case Kind::next_id:
      break;  // no entry: the reader keeps it
  }
  return std::nullopt;
}

}  // namespace

std::string file_head(std::uint64_t salt) {
  std::string head(kFileMark);
  put(head, salt);
  put(head, crc64(head));
  return head;
}

std::optional<std::uint64_t> read_file_head(std::string_view bytes) {
  if (bytes.size() < kFileHead || !bytes.starts_with(kFileMark)) return std::nullopt;
  const std::uint64_t expected = crc64(bytes.substr(0, kFileHead - sizeof(std::uint64_t)));
  bytes.remove_prefix(kFileMark.size());
  const auto salt = take<std::uint64_t>(bytes);
  if (take<std::uint64_t>(bytes) != expected) return std::nullopt;
  return salt;
}

std::string encode(const Entry& entry) { return std::visit(Encode{}, entry); }

/// Those of each admission are asked for without their octets.
std::uint64_t live_bytes(const Entry& entry) {
  if (const auto* granted = std::get_if<Granted>(&entry))
    return granted->state.empty() ? 0
                                  : kEntryHead + sizeof(std::uint32_t) + granted->subject.size() +
                                        granted->state.size();
  if (const auto* enforced = std::get_if<Enforced>(&entry))
    return enforced->slots.empty()
               ? 0
               : kEntryHead + sizeof(enforced->subject) + enforced->slots.size();
  const auto* gated = std::get_if<Gated>(&entry);
  const auto* contradicted = std::get_if<Contradicted>(&entry);
  const bool adds = std::holds_alternative<Admitted>(entry) ||
                    std::holds_alternative<Released>(entry) ||
                    (gated != nullptr && gated->ifindex != 0) ||
                    (contradicted != nullptr && !contradicted->how.empty());
  return adds ? encode(entry).size() : 0;
}

std::string batch(std::uint64_t salt, std::uint64_t sequence, std::uint32_t count,
                  std::string entries) {
  entries.resize((entries.size() + kAlign - 1) / kAlign * kAlign, '\0');
  std::string out(kBatchMark);
  put(out, count);
  put(out, sequence);
  put(out, static_cast<std::uint64_t>(entries.size()));
  put(out, crc64(entries));
  put(out, head_checksum(out, salt));
  return out.append(entries);
}

std::string snapshot(std::uint64_t salt, const Contents& contents) {
  std::string entries = with_head(Kind::next_id, octets(contents.next_id));
  std::uint32_t count = 1;
  const auto add = [&](const Entry& entry) {
    entries += encode(entry);
    ++count;
  };
  for (const control::Request& r : contents.admissions)
    add(Admitted{r, contents.admissions.user_of(r.id)});
  for (const std::string& subject : contents.released) add(Released{subject});
  for (const auto& [subject, state] : contents.granted) add(Granted{subject, state});
  for (const auto& [identity, gated] : contents.gated) add(gated);
  for (const auto& [subject, slots] : contents.enforced) add(Enforced{subject, slots});
  for (const auto& [key, contradicted] : contents.contradicted) add(contradicted);
  return batch(salt, 0, count, std::move(entries));
}

std::optional<BatchHead> read_batch_head(std::string_view bytes, std::uint64_t salt) {
  if (bytes.size() < kBatchHead || !bytes.starts_with(kBatchMark)) return std::nullopt;
  const std::uint64_t expected =
      head_checksum(bytes.substr(0, kBatchHead - sizeof(std::uint64_t)), salt);
  bytes.remove_prefix(kBatchMark.size());
  BatchHead head;
  head.count = take<std::uint32_t>(bytes);
  head.sequence = take<std::uint64_t>(bytes);
  head.length = take<std::uint64_t>(bytes);
  head.checksum = take<std::uint64_t>(bytes);
  if (take<std::uint64_t>(bytes) != expected) return std::nullopt;
  return head;
}

bool holds_batch_head(std::string_view bytes, std::uint64_t salt) {
  for (; bytes.size() >= kBatchHead; bytes.remove_prefix(kAlign))
    if (read_batch_head(bytes, salt)) return true;
  return false;
}

Result<std::optional<Entry>> Reader::next() {
  while (left_ > 0) {
    if (bytes_.size() < kEntryHead) return fail("ends within an entry");
    --left_;
    const auto kind = take<std::uint8_t>(bytes_);
    const auto length = take<std::uint32_t>(bytes_);
    if (length > bytes_.size()) return fail("ends within an entry");
    std::string_view body = bytes_.substr(0, length);
    bytes_.remove_prefix(length);
    if (static_cast<Kind>(kind) == Kind::next_id && length == sizeof(std::uint64_t)) {
      next_id_ = take<std::uint64_t>(body);
      continue;
    }
    auto entry = decode(kind, body);
    if (!entry) return fail("an entry of kind " + std::to_string(kind) + " that is not understood");
    return entry;
  }
  return std::optional<Entry>();
}

}  // namespace mlcca::store::format
