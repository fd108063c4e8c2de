// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/store/format.hpp"

#include <utility>
#include <variant>

#include "control/protobuf.hpp"
#include "daemon/store/checksum.hpp"
#include "daemon/store/fields.hpp"

namespace mlcca::store::format {
namespace {

/// The marks: the common part of all layouts of the file, this layout, and a batch.
constexpr std::string_view kAnyMark = "MLCCAJ";
constexpr std::string_view kFileMark = "MLCCAJ02";
constexpr std::string_view kBatchMark = "BTCH";

template <class Integer>
void put(std::string& to, Integer value) {
  for (std::size_t i = 0; i < sizeof value; ++i)
    to.push_back(static_cast<char>((value >> (8 * i)) & 0xffU));
}

/// Removes an integer from the front of `from`, which must have enough bytes.
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

std::uint64_t head_checksum(std::string_view head, std::uint64_t salt) {
  return crc64(head, crc64(octets(salt)));
}

/// Whether an entry adds to the state. Entries that only remove something or set the next id are
/// not written in a compaction.
struct IsAlive {
  bool operator()(const Admitted&) const { return true; }
  bool operator()(const Removed&) const { return false; }
  bool operator()(const Released&) const { return true; }
  bool operator()(const Reinstated&) const { return false; }
  bool operator()(const NextId&) const { return false; }
  bool operator()(const Granted& entry) const { return !entry.state.empty(); }
  bool operator()(const Gated& entry) const { return entry.ifindex != 0; }
  bool operator()(const Enforced& entry) const { return !entry.slots.empty(); }
  bool operator()(const Contradicted& entry) const { return !entry.how.empty(); }
  bool operator()(const Membership& entry) const { return entry != Membership{}; }
  bool operator()(const Introduced& entry) const { return entry.done; }
};

/// Whether an entry is valid: the request of an admission must be an Admit request.
bool is_sound(const Entry& entry) {
  const auto* admitted = std::get_if<Admitted>(&entry);
  return admitted == nullptr || std::holds_alternative<control::Admit>(admitted->request.body);
}

}  // namespace

std::string file_head(std::uint64_t salt) {
  std::string head(kFileMark);
  put(head, salt);
  put(head, crc64(head));
  return head;
}

Result<std::uint64_t> read_file_head(std::string_view bytes) {
  const auto none = [] { return fail("damaged at byte 0 (no head of a journal)"); };
  if (bytes.size() < kFileHead || !bytes.starts_with(kAnyMark)) return none();
  const std::uint64_t expected = crc64(bytes.substr(0, kFileHead - sizeof(std::uint64_t)));
  const std::string mark(bytes.substr(0, kFileMark.size()));
  bytes.remove_prefix(kFileMark.size());
  const auto salt = take<std::uint64_t>(bytes);
  if (take<std::uint64_t>(bytes) != expected) return none();
  if (mark != kFileMark)
    return fail("a journal of layout " + mark + ", and this version reads only " +
                std::string(kFileMark));
  return salt;
}

std::string encode(const Entry& entry) {
  std::string message;
  // Numbered as in journal.proto.
  const auto number = static_cast<std::uint32_t>(entry.index() + 1);
  std::visit([&](const auto& one) { control::ProtobufWriter(message).put_always(number, one); },
             entry);
  std::string out;
  put(out, static_cast<std::uint32_t>(message.size()));
  return out += message;
}

bool is_alive(const Entry& entry) { return std::visit(IsAlive{}, entry); }

std::uint64_t live_bytes(const Entry& entry) { return is_alive(entry) ? encode(entry).size() : 0; }

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
  std::string entries;
  std::uint32_t count = 0;
  const auto add = [&](const Entry& entry) {
    entries += encode(entry);
    ++count;
  };
  add(NextId{contents.next_id});
  for (const control::Request& r : contents.admissions)
    add(Admitted{r, contents.admissions.user_of(r.id), contents.admissions.through(r.id)});
  for (const std::string& subject : contents.released) add(Released{subject});
  for (const auto& [subject, state] : contents.granted) add(Granted{subject, state});
  for (const auto& [identity, gated] : contents.gated) add(gated);
  for (const auto& [subject, slots] : contents.enforced) add(Enforced{subject, slots});
  for (const auto& [key, contradicted] : contents.contradicted) add(contradicted);
  if (is_alive(contents.membership)) add(contents.membership);
  if (contents.introduced) add(Introduced{true});
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
  if (left_ == 0) return std::optional<Entry>();
  --left_;
  if (bytes_.size() < kEntryHead) return fail("ends within an entry");
  const auto length = take<std::uint32_t>(bytes_);
  if (length > bytes_.size()) return fail("ends within an entry");
  auto entry =
      control::parse<JournalEntry>(bytes_.substr(0, length), control::UnknownField::refuse);
  bytes_.remove_prefix(length);
  last_ = kEntryHead + length;
  if (!entry || !entry->has_body || !is_sound(entry->message.body))
    return fail("has an entry that is not understood");
  return std::move(entry->message.body);
}

}  // namespace mlcca::store::format
