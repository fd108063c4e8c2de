// SPDX-License-Identifier: BSD-2-Clause
#include "tests/daemon/store/worlds.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace mlcca::store::test {

Folder::Folder() {
  std::string form = ::testing::TempDir() + "mlcca-store-XXXXXX";
  if (::mkdtemp(form.data()) == nullptr) std::abort();
  path_ = form;
}

Folder::~Folder() { std::filesystem::remove_all(path_); }

std::string read_file(const std::string& path) {
  std::ostringstream bytes;
  bytes << std::ifstream(path, std::ios::binary).rdbuf();
  return bytes.str();
}

void write_file(const std::string& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

Admitted admitted(std::uint64_t id, const std::string& channel) {
  control::Admit admit;
  admit.channel = channel;
  admit.from = "place-" + std::to_string(id);
  admit.offered.push_back({"Bandwidth", 100'000 + id, "byte s^-1", false});
  admit.node = 0x20;
  return {{id, admit}};
}

namespace {

/// A second implementation of the contents, in another way: lists that are searched.
class Model {
 public:
  explicit Model(std::uint32_t seed, std::size_t largest) : random_(seed), largest_(largest) {}

  Entry step() {
    for (;;) {
      const std::uint32_t choice = pick(15);
      if (choice < 4) return admit();
      if (choice < 6 && !living_.empty()) return remove();
      if (choice == 6) return release();
      if (choice == 7 && !released_.empty()) return reinstate();
      if (choice == 10) return gate();
      if (choice == 11) return enforce();
      if (choice == 12) return contradict();
      if (choice == 13) return join();
      if (choice == 14) return introduce();
      if (choice > 7) return grant();
    }
  }

  [[nodiscard]] Contents contents() const {
    Contents out;
    for (const Admitted& a : living_) out.admissions.put(a.request, a.by, a.through);
    out.released = released_;
    std::ranges::sort(out.released);
    for (const Granted& g : granted_) out.granted[g.subject] = g.state;
    for (const Gated& g : gated_) out.gated[g.identity] = g;
    for (const Enforced& e : enforced_) out.enforced[e.subject] = e.slots;
    for (const Contradicted& c : contradicted_) out.contradicted[{c.network, c.subject}] = c;
    out.membership = membership_;
    out.introduced = introduced_;
    out.next_id = next_;
    return out;
  }

 private:
  std::uint32_t pick(std::uint32_t below) { return static_cast<std::uint32_t>(random_() % below); }
  std::string text() { return std::string(1 + pick(static_cast<std::uint32_t>(largest_)), 'x'); }

  Entry admit() {
    living_.push_back(admitted(next_ + pick(2), "c" + std::to_string(pick(1000)) + text()));
    living_.back().by = pick(3);
    if (pick(3) == 0) living_.back().through = "gateway-" + std::to_string(pick(2));
    next_ = living_.back().request.id + 1;
    return living_.back();
  }
  Entry remove() {
    const std::uint32_t which = pick(static_cast<std::uint32_t>(living_.size()));
    const Removed entry{living_[which].request.id};
    living_.erase(living_.begin() + which);
    return entry;
  }
  Entry release() {
    released_.push_back("0x" + std::to_string(++subjects_));
    return Released{released_.back()};
  }
  Entry reinstate() {
    const std::uint32_t which = pick(static_cast<std::uint32_t>(released_.size()));
    const Reinstated entry{released_[which]};
    released_.erase(released_.begin() + which);
    return entry;
  }
  Entry grant() {
    if (!granted_.empty() && pick(3) == 0) {
      const Granted entry{granted_.back().subject, ""};
      granted_.pop_back();
      return entry;
    }
    granted_.push_back({"0x" + std::to_string(++subjects_), "set=" + text()});
    return granted_.back();
  }

  Entry gate() {
    if (!gated_.empty() && pick(3) == 0) {
      const Gated entry{gated_.back().identity, "", "", 0};
      gated_.pop_back();
      return entry;
    }
    if (!gated_.empty() && pick(3) == 0) {
      ++gated_.back().ifindex;
      return gated_.back();
    }
    gated_.push_back(
        {"name can" + std::to_string(++subjects_), "net" + text(), "can" + text(), 1 + pick(1000)});
    return gated_.back();
  }

  Entry enforce() {
    if (!enforced_.empty() && pick(3) == 0) {
      const Enforced entry{enforced_.back().subject, {}};
      enforced_.pop_back();
      return entry;
    }
    enforced_.push_back({~std::uint64_t{++subjects_}, std::string(1, '\0') + text()});
    return enforced_.back();
  }

  Entry contradict() {
    if (!contradicted_.empty() && pick(3) == 0) {
      Contradicted entry = contradicted_.back();
      entry.how.clear();
      contradicted_.pop_back();
      return entry;
    }
    if (!contradicted_.empty() && pick(3) == 0) {
      contradicted_.back().how += "again";
      return contradicted_.back();
    }
    contradicted_.push_back({"net" + text(), ++subjects_, 0x3ffe, text()});
    return contradicted_.back();
  }

  /// Joins or leaves a cluster, with other values each time.
  Entry join() {
    const bool leaves = membership_.incarnation != 0 && pick(3) == 0;
    membership_ = leaves ? Membership{}
                         : Membership{.epoch = text(),
                                      .epoch_revision = pick(3),
                                      .incarnation = ++subjects_,
                                      .seen_revision = pick(1000),
                                      .voted_digest = text(),
                                      .drained = pick(2) == 0,
                                      .gone_back = pick(2) == 0,
                                      .waits = pick(2) == 0};
    return membership_;
  }

  Entry introduce() {
    introduced_ = !introduced_;
    return Introduced{introduced_};
  }

  std::mt19937 random_;
  std::size_t largest_;
  std::vector<Admitted> living_;
  std::vector<std::string> released_;
  std::vector<Granted> granted_;
  std::vector<Gated> gated_;
  std::vector<Enforced> enforced_;
  std::vector<Contradicted> contradicted_;
  Membership membership_;
  bool introduced_ = false;
  std::uint64_t next_ = 1;
  std::uint64_t subjects_ = 0;
};

}  // namespace

Story random_story(std::uint32_t seed, std::size_t batches, std::size_t largest) {
  Model model(seed, largest);
  std::mt19937 random(seed);
  Story story;
  story.states.push_back(model.contents());
  while (story.batches.size() < batches) {
    Batch batch(1 + (random() % 4));
    for (Entry& entry : batch) entry = model.step();
    story.batches.push_back(std::move(batch));
    story.states.push_back(model.contents());
  }
  return story;
}

Result<void> write(Journal& journal, const Batch& batch) {
  for (const Entry& entry : batch)
    if (auto done = journal.append(entry); !done) return done;
  return journal.commit();
}

std::string text_of(const Contents& contents) {
  std::ostringstream out;
  out << "admissions";
  for (const control::Request& r : contents.admissions) out << ' ' << r.id;
  out << ", released";
  for (const std::string& s : contents.released) out << ' ' << s;
  out << ", granted";
  for (const auto& [subject, state] : contents.granted)
    out << ' ' << subject << '=' << state.size();
  out << ", next " << contents.next_id;
  return out.str();
}

}  // namespace mlcca::store::test
