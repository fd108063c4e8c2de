// SPDX-License-Identifier: BSD-2-Clause
// Fuzzes the journal with files that are torn, altered or made up. A file is read up to the end of
// one of its batches, or refused; what was read stays the same however often it is read and written
// again.
#include <fcntl.h>
#include <fuzzer/FuzzedDataProvider.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/store/format.hpp"
#include "daemon/store/journal.hpp"
#include "tests/daemon/store/fake_disk.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using namespace mlcca;
using namespace mlcca::store;
using fuzz::demand;
using Memory = store::test::MemoryDisk;

constexpr const char* kFolder = "/store";
constexpr const char* kJournal = "/store/journal";
constexpr std::uint64_t kSalt = 0x5a17;

void put_file(Memory& disk, const char* path, std::string_view bytes) {
  const OpenFile file(disk, disk.open(path, O_RDWR | O_CREAT));
  std::uint64_t at = 0;
  while (at < bytes.size())
    at += static_cast<std::uint64_t>(
        disk.pwrite(file.get(), bytes.data() + at, bytes.size() - at, at));
  disk.fdatasync(file.get());
}

std::string get_file(Memory& disk, const char* path) {
  const OpenFile file(disk, disk.open(path, O_RDONLY));
  std::string bytes(static_cast<std::size_t>(std::max<std::int64_t>(disk.size(file.get()), 0)),
                    '\0');
  if (!bytes.empty()) disk.pread(file.get(), bytes.data(), bytes.size(), 0);
  return bytes;
}

Result<Contents> contents_of(Memory& disk) {
  const auto journal = Journal::open(kFolder, disk);
  if (!journal) return std::unexpected(journal.error());
  return journal->contents();
}

/// Whatever can be read once can be read, changed and written again any number of times.
void check_life(Memory& disk) {
  auto first = contents_of(disk);
  if (!first) {
    demand(!first.error().text.empty(), "a refusal without a word");
    demand(!contents_of(disk), "refused, and then read");
    return;
  }
  Contents known = std::move(*first);
  auto journal = Journal::open(kFolder, disk);
  demand(journal && journal->contents() == known, "another content when read again");
  demand(!journal->recovered(), "cut off twice");
  demand(static_cast<bool>(journal->compact()), "cannot be written again");
  demand(journal->contents() == known, "writing again changes it");
  const Entry entry = Released{"0xf022"};
  demand(static_cast<bool>(journal->append(entry)), "takes no entry");
  known.apply(entry);
  demand(static_cast<bool>(journal->commit()), "commits nothing");
  {
    [[maybe_unused]] const auto closed = std::move(*journal);
  }
  const auto last = contents_of(disk);
  demand(last && *last == known, "what was committed is not read");
}

std::string some_octets(FuzzedDataProvider& in) {
  if (in.ConsumeBool()) return in.ConsumeRandomLengthString(40);
  static const std::vector<std::string> kTexts = {"", "0x1", "0xa4efeccc3210b497", "name can0",
                                                  "bus"};
  return kTexts[in.ConsumeIntegralInRange<std::size_t>(0, kTexts.size() - 1)];
}

/// Text as it may be in a message.
std::string some_text(FuzzedDataProvider& in) {
  std::string text = some_octets(in);
  std::ranges::replace_if(text, [](char c) { return static_cast<unsigned char>(c) > 0x7e; }, '?');
  return text;
}

Entry some_entry(FuzzedDataProvider& in) {
  switch (in.ConsumeIntegralInRange(0, 9)) {
    case 0: {
      control::Admit admit;
      admit.channel = some_text(in);
      admit.from = some_text(in);
      admit.key = some_text(in);
      admit.lease_ns = in.ConsumeIntegral<std::uint64_t>();
      admit.hold = in.ConsumeBool();
      if (in.ConsumeBool())
        admit.offered.push_back({some_text(in), in.ConsumeIntegral<std::uint64_t>(), "ns", false});
      const auto by = in.ConsumeIntegralInRange<std::uint32_t>(0, 2);
      return Admitted{{in.ConsumeIntegralInRange<std::uint64_t>(0, 12), admit}, by, some_text(in)};
    }
    case 1:
      return Removed{in.ConsumeIntegralInRange<std::uint64_t>(0, 12)};
    case 2:
      return Released{some_text(in)};
    case 3:
      return Reinstated{some_text(in)};
    case 4:
      return Granted{some_text(in), some_octets(in)};
    case 5:
      return Gated{some_text(in), some_text(in), some_octets(in),
                   in.ConsumeIntegral<std::uint32_t>()};
    case 6:
      return Contradicted{some_text(in), in.ConsumeIntegralInRange<std::uint64_t>(0, 3),
                          in.ConsumeIntegral<std::uint16_t>(), some_text(in)};
    case 7: {
      Membership out{some_octets(in), in.ConsumeIntegral<std::uint64_t>(),
                     in.ConsumeIntegral<std::uint64_t>(), in.ConsumeIntegral<std::uint64_t>(),
                     some_octets(in)};
      out.drained = in.ConsumeBool();
      out.gone_back = in.ConsumeBool();
      out.waits = in.ConsumeBool();
      return out;
    }
    case 8:
      return Introduced{in.ConsumeBool()};
    default:
      return Enforced{in.ConsumeIntegralInRange<std::uint64_t>(0, 3), some_octets(in)};
  }
}

/// A file whose heads and checksums are correct, with any contents.
std::string made_up(FuzzedDataProvider& in) {
  std::string file = format::file_head(kSalt);
  for (std::uint64_t sequence = 0; sequence < 6 && in.remaining_bytes() > 0; ++sequence) {
    std::string entries;
    std::uint32_t count = in.ConsumeIntegralInRange<std::uint32_t>(0, 2);
    while (in.ConsumeBool() && in.remaining_bytes() > 0) {
      std::string entry = format::encode(some_entry(in));
      if (in.ConsumeBool() && !entry.empty())
        entry[in.ConsumeIntegralInRange<std::size_t>(0, entry.size() - 1)] =
            in.ConsumeIntegral<char>();
      entries += entry;
      ++count;
    }
    if (in.ConsumeBool()) entries += in.ConsumeRandomLengthString(64);
    if (in.ConsumeProbability<float>() < 0.05F) count = in.ConsumeIntegral<std::uint32_t>();
    file += format::batch(kSalt, sequence, count, std::move(entries));
  }
  return file;
}

/// Writes a real sequence of changes, then cuts or changes the file in one place. What is then read
/// must be the state after one of its batches.
void tear(FuzzedDataProvider& in) {
  Memory disk;
  std::vector<Contents> states{{}};
  {
    auto journal = Journal::open(kFolder, disk);
    demand(static_cast<bool>(journal), "no journal in an empty folder");
    for (int batch = 0; batch < 8 && in.remaining_bytes() > 8; ++batch) {
      do static_cast<void>(journal->append(some_entry(in)));
      while (in.ConsumeBool() && in.remaining_bytes() > 8);
      demand(static_cast<bool>(journal->commit()), "commits nothing");
      states.push_back(journal->contents());
    }
  }
  const auto whole = contents_of(disk);
  demand(whole && *whole == states.back(), "a whole file is not read as it was written");
  std::string file = get_file(disk, kJournal);
  if (in.ConsumeBool())
    file.resize(in.ConsumeIntegralInRange<std::size_t>(0, file.size()));
  else
    file[in.ConsumeIntegralInRange<std::size_t>(0, file.size() - 1)] ^=
        static_cast<char>(in.ConsumeIntegralInRange(1, 255));
  Memory torn;
  put_file(torn, kJournal, file);
  const auto read = contents_of(torn);
  demand(!read || std::ranges::find(states, *read) != states.end(), "part of a batch is read");
  check_life(torn);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  FuzzedDataProvider in(data, size);
  const int kind = in.ConsumeIntegralInRange(0, 2);
  if (kind == 0) {
    tear(in);
    return 0;
  }
  Memory disk;
  if (kind == 1) put_file(disk, kJournal, made_up(in));
  if (kind == 2) put_file(disk, kJournal, in.ConsumeRemainingBytesAsString());
  check_life(disk);
  return 0;
}
