// SPDX-License-Identifier: BSD-2-Clause
// An admission on a network that gateways share, over the control socket of a real mlccad until the
// verdict is in force, against its transaction alone, by libcurl in this process; in turns.
#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <variant>

#include "cluster/http.hpp"
#include "tests/bench/gateways/direct.hpp"
#include "tests/bench/gateways/parts.hpp"
#include "tests/bench/gateways/simulated.hpp"
#include "tests/bench/measure.hpp"

namespace mlcca::bench {
namespace {

constexpr int kChannels = 200;
constexpr int kTurns = 5;
constexpr int kPart = 20;
constexpr Value kLongLease = 600'000'000'000;  // ns: no beats but those of what is measured
constexpr std::size_t kCommitOctets = 1024;    // of a commit to the journal, about

std::string pair_xml(const std::string& name) {
  std::string xml = "<System name='" + name + "'>\n";
  for (int c = 0; c < kChannels; ++c)
    xml += fmt::format("<EventChannel name='c{}'><SubjectUID>{:#x}</SubjectUID></EventChannel>\n",
                       c, 0x100 + c);
  xml += ethernet("lan");
  for (const char* gateway : {"gw1", "gw2"})
    xml += fmt::format(
        "<Gateway name='{}'><Port network='lan'><Interface name='lan0'/></Port></Gateway>\n",
        gateway);
  return xml + "</System>\n";
}

/// What becomes durable with each admission, and nothing else.
class Sync {
 public:
  explicit Sync(const std::string& folder)
      : file_(
            ::open((folder + "/floor").c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600)) {
    require(file_.get() >= 0, "a file in " + folder);
  }
  double ms() {
    const std::string octets(kCommitOctets, 'j');
    const auto start = Steady::now();
    require(::write(file_.get(), octets.data(), octets.size()) > 0, "write");
    require(::fdatasync(file_.get()) == 0, "fdatasync");
    return ms_since(start);
  }

 private:
  Fd file_;
};

struct Times {
  std::vector<double> admissions, releases, transactions, syncs;
  std::vector<double> few, many;  ///< admissions beside the fewest and the most
  double daemon = 0, bridge = 0;  ///< us of a processor for an admission and its release
};

class Pair {
 public:
  explicit Pair(const std::string& state) : store_(prepare(), 1), state_(state) {
    grant(store_, "gw2", "readwrite", "/mlcca/");
    test::write_file(folder_ / "t.xml", pair_xml("t"));
    test::write_file(folder_ / "bare.xml", pair_xml("bare"));
    require(test::make_gateway_links(folder_), "links");
    described_ = std::make_unique<Described>(folder_ / "bare.xml");
    const auto settings = settings_of(folder_, "gw2");
    Direct direct(loop_, settings, store_.endpoint(0));
    core::cluster::Txn txn;
    txn.puts.push_back({.key = described_->current.key, .value = described_->current.value});
    described_->current.create = described_->current.mod = direct.run(txn);
    bare_ = std::make_unique<Simulated>(Simulated::Place{.loop = loop_.get(),
                                                         .described = *described_,
                                                         .lease = kLongLease,
                                                         .trouble = trouble_},
                                        settings, store_.endpoint(0));
    bare_->on_granted = [this] { granted_ = true; };
    bare_->begin();
    until([this] { return bare_->joined() && bare_->idle(); });
  }
  Pair(const Pair&) = delete;
  Pair& operator=(const Pair&) = delete;
  Pair(Pair&&) = delete;
  Pair& operator=(Pair&&) = delete;
  ~Pair() { test::run_script("ip netns del gw1; ip netns del gw2", folder_.path()); }

  Times run() {
    RealGateway first(folder_, store_, options("gw1", state_ + "/gw1.state"));
    {
      // Both have to agree to the description. Then the processors belong to the first one.
      RealGateway second(folder_, store_, options("gw2", folder_ / "gw2.state"));
      first.start();
      second.start();
      first.wait_until_in();
      second.stop();
    }
    auto client = first.connect();
    Sync sync(state_);
    Times times;
    const double daemon = processor_seconds(first.daemon());
    const double bridge = processor_seconds(first.bridge());
    for (int turn = 0; turn < kTurns; ++turn) {
      for (int c = 0; c < kChannels; ++c) {
        times.transactions.push_back(transaction());
        times.admissions.push_back(admit(client, "c" + std::to_string(c), "gw1", "lan"));
        if (c < kPart) times.few.push_back(times.admissions.back());
        if (c >= kChannels - kPart) times.many.push_back(times.admissions.back());
        times.syncs.push_back(sync.ms());
      }
      for (int c = 0; c < kChannels; ++c)
        times.releases.push_back(release(client, "c" + std::to_string(c)));
      wait_for("what was released stays in the store",
               [&] { return first.standing().reservations == 0; });
    }
    const auto made = static_cast<double>(times.admissions.size());
    times.daemon = 1e6 * (processor_seconds(first.daemon()) - daemon) / made;
    times.bridge = 1e6 * (processor_seconds(first.bridge()) - bridge) / made;
    first.stop();
    return times;
  }
  [[nodiscard]] const test::WorkFolder& folder() const { return folder_; }

 private:
  const test::WorkFolder& prepare() {
    test::make_certificates(folder_);
    return folder_;
  }
  RealGateway::Options options(const std::string& name, const std::string& state) {
    return {.name = name,
            .description = folder_ / "t.xml",
            .certificate = name,
            .lease = "60s",
            .state = state};
  }
  void until(const std::function<bool()>& holds) {
    const bool held = loop_.until([&] { return holds() || !trouble_.empty(); });
    require(held && trouble_.empty(), "the bare transactions: " + trouble_);
  }
  double transaction() {
    granted_ = false;
    bare_->reserve();
    until([this] { return granted_; });
    return bare_->latest_ms();
  }

  test::WorkFolder folder_;
  test::Store store_;
  std::string state_;
  test::Loop loop_;
  std::string trouble_;
  bool granted_ = false;
  std::unique_ptr<Described> described_;
  std::unique_ptr<Simulated> bare_;
};

void print(const std::string& where, const Times& times) {
  for (const double part : {0.5, 0.99})
    fmt::print(
        "an admission, the journal {:<9} p{:<3.0f} {:8.3f} ms   its transaction alone {:8.3f} ms   "
        "ratio {:.2f}   (a bare write and sync {:.3f} ms: ratio to both {:.2f})\n",
        where, part * 100, quantile(times.admissions, part), quantile(times.transactions, part),
        quantile(times.admissions, part) / quantile(times.transactions, part),
        quantile(times.syncs, part),
        quantile(times.admissions, part) /
            (quantile(times.transactions, part) + quantile(times.syncs, part)));
  fmt::print("of these, beside up to {} / {} to {} others: p50 {:.3f} / {:.3f} ms\n", kPart,
             kChannels - kPart, kChannels, quantile(times.few, 0.5), quantile(times.many, 0.5));
  fmt::print("its release, until the gate is closed      {}\n", quantiles(times.releases));
  fmt::print(
      "both take of a processor                   {:.0f} us in mlccad, {:.0f} us in "
      "mlcca-cluster\n",
      times.daemon, times.bridge);
}

std::uint64_t seconds_ns(std::uint64_t seconds) { return seconds * 1'000'000'000; }

}  // namespace

std::string quantiles(const std::vector<double>& values) {
  return fmt::format("p50 {:.3f} ms, p99 {:.3f} ms", quantile(values, 0.5), quantile(values, 0.99));
}

void grant(const test::Store& store, const std::string& user, const std::string& rights,
           const std::string& prefix) {
  require(
      store.control("role grant-permission " + user + " --prefix=true " + rights + ' ' + prefix),
      "rights of " + user);
}

double admit(control::Client& client, const std::string& channel, const std::string& gateway,
             const std::string& network) {
  control::Admit admit;
  admit.channel = channel;
  admit.from = gateway;
  admit.to = network;
  admit.user = "0";
  admit.key = "k" + channel;
  admit.offered = {{.name = "Period", .value = seconds_ns(10), .unit = "ns"},
                   {.name = "MaxPayload", .value = 8, .unit = "bytes"}};
  const control::Request request{.id = 0, .body = std::move(admit)};
  const auto start = Steady::now();
  const auto reply = client.call(request);
  const double took = ms_since(start);
  if (!reply) give_up("an admission: " + reply.error().text);
  const auto* const channels = std::get_if<control::Channels>(&reply->body);
  if (channels == nullptr || channels->channels.empty() || !channels->channels[0].granted) {
    const auto* const error = std::get_if<control::Error>(&reply->body);
    give_up(channel + " is not admitted: " +
            (error != nullptr ? error->message : channels->channels[0].reason));
  }
  return took;
}

double release(control::Client& client, const std::string& channel) {
  const control::Request request{.id = 0, .body = control::ReleaseRequest{.key = "k" + channel}};
  const auto start = Steady::now();
  const auto reply = client.call(request);
  const double took = ms_since(start);
  if (!reply) give_up("a release: " + reply.error().text);
  if (const auto* const error = std::get_if<control::Error>(&reply->body))
    give_up("a release: " + error->message);
  return took;
}

void measure_admission(const std::string& folder) {
  if (auto prepared = cluster::prepare_http(); !prepared) give_up(prepared.error().text);
  const test::WorkFolder memory;
  print("in memory", Pair(memory.path()).run());
  const std::string disk = folder + "/gateways_bench.state";
  std::filesystem::create_directories(disk);
  print("on disk", Pair(disk).run());
  std::filesystem::remove_all(disk);
}

}  // namespace mlcca::bench
