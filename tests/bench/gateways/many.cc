// SPDX-License-Identifier: BSD-2-Clause
// Bench of many gateways on one store. All but one are simulated: they use the protocol and entries
// of the product and have their own connections. Each network has ten of them, and a System up to a
// hundred networks. The last gateway is a real mlccad, which starts when the store has all of that.
#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <utility>

#include "cluster/http.hpp"
#include "tests/bench/gateways/direct.hpp"
#include "tests/bench/gateways/parts.hpp"
#include "tests/bench/gateways/simulated.hpp"
#include "tests/bench/measure.hpp"

namespace mlcca::bench {
namespace {

constexpr std::size_t kOnANetwork = 10;
constexpr std::size_t kMostOfASystem = 100'000;  // most reservations of a System
constexpr std::size_t kMostGateways = 250;  // most gateways of a System; a description can have 256
constexpr std::size_t kWatchers = 100;
constexpr std::size_t kWatched = 1000;  // reservations that are made while they watch
constexpr std::size_t kFollowed =
    1000;                              // reservations that are made while the real gateway follows
constexpr std::size_t kAdmitted = 50;  // admissions of the real gateway
/// The lease of simulated gateways in ns: long, so that gateways beat only when the bench asks for
/// it.
constexpr Value kSimulatedLease = 3'600'000'000'000;
/// The time that a part of the bench may take: ten minutes, and one second for this many
/// reservations.
constexpr std::chrono::minutes kLongest{10};
constexpr std::size_t kLeastPerSecond = 300;

std::size_t number_of(const char* variable, std::size_t otherwise) {
  const char* const text = std::getenv(variable);  // NOLINT(concurrency-mt-unsafe)
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

/// A System of gateways g0 to gN-1, ten on each of the networks n0, n1 and so on, and of a real
/// gateway on n0.
std::string many_xml(const std::string& name, std::size_t gateways) {
  std::string xml = "<System name='" + name + "'>\n";
  for (std::size_t c = 0; c < kAdmitted; ++c)
    xml += fmt::format("<EventChannel name='c{}'><SubjectUID>{:#x}</SubjectUID></EventChannel>\n",
                       c, 0x100 + c);
  for (std::size_t n = 0; n < gateways; n += kOnANetwork)
    xml += ethernet(fmt::format("n{}", n / kOnANetwork));
  const auto add = [&](const std::string& gateway, std::size_t network) {
    xml += fmt::format(
        "<Gateway name='{}'><Port network='n{}'><Interface name='lan0'/></Port></Gateway>\n",
        gateway, network);
  };
  for (std::size_t g = 0; g < gateways; ++g) add(fmt::format("g{}", g), g / kOnANetwork);
  add("real", 0);
  return xml + "</System>\n";
}

/// The gateways of one network. They reserve one after the other, or all at once.
class Medium {
 public:
  void add(std::unique_ptr<Simulated> gateway) {
    Simulated* const one = gateway.get();
    one->on_granted = [this, one] { ended(*one); };
    one->on_refused = [this, one] {
      ++refused_;
      ended(*one);
    };
    one->on_changed = [this, one](const core::cluster::Batch& batch) {
      for (const auto& other : gateways_)
        if (other.get() != one) other->observe(batch);
    };
    gateways_.push_back(std::move(gateway));
  }
  void in_turn(std::size_t count) {
    at_once_ = false;
    left_ = count;
    next();
  }
  void at_once() {
    at_once_ = true;
    left_ = gateways_.size();
    for (const auto& one : gateways_) one->reserve();
  }
  [[nodiscard]] bool done() const {
    return left_ == 0 &&
           std::ranges::all_of(gateways_, [](const auto& one) { return one->idle(); });
  }
  [[nodiscard]] std::size_t refused() const { return refused_; }
  [[nodiscard]] const std::vector<std::unique_ptr<Simulated>>& gateways() const {
    return gateways_;
  }

 private:
  void ended(Simulated& /*one*/) {
    --left_;
    if (!at_once_) next();
  }
  void next() {
    if (left_ == 0) return;
    gateways_[turn_++ % gateways_.size()]->reserve();
  }

  std::vector<std::unique_ptr<Simulated>> gateways_;
  std::size_t left_ = 0, turn_ = 0, refused_ = 0;
  bool at_once_ = false;
};

/// A client that follows all changes of a System, as mlcca-cluster does.
class Watcher {
 public:
  Watcher(const test::Loop& loop, const cluster::Settings& settings, const std::string& endpoint,
          const std::string& folder, std::int64_t revision) {
    auto channel = cluster::open_http(loop.get(), settings, endpoint);
    if (!channel) give_up(channel.error().text);
    channel_ = std::move(*channel);
    call_ = channel_->start(
        {.method = cluster::etcd::kWatch,
         .message = cluster::etcd::watch_request(folder, cluster::etcd::end_of(folder), revision),
         .stays_open = true,
         .on_answer =
             [this](const std::string& answer) {
               const auto changes = cluster::etcd::read_changes(answer);
               if (!changes) return;
               watches_ = true;
               entries_ += changes->entries.size();
               octets_ += answer.size();
             },
         .on_end = [](const cluster::End&) {}});
  }
  [[nodiscard]] bool watches() const { return watches_; }
  [[nodiscard]] std::size_t entries() const { return entries_; }
  [[nodiscard]] std::size_t octets() const { return octets_; }

 private:
  std::unique_ptr<cluster::Channel> channel_;
  std::unique_ptr<cluster::Call> call_;
  bool watches_ = false;
  std::size_t entries_ = 0, octets_ = 0;
};

/// The cost of a period of time.
struct Cost {
  double seconds = 0, store = 0, ours = 0;  ///< the latter two: seconds of processor time
  double octets = 0;                        ///< bytes on the loopback interface
};

class Many {
 public:
  Many(std::size_t gateways, std::size_t each)
      : gateways_(gateways),
        each_(each),
        store_(prepare(), 1, {"--quota-backend-bytes", "2147483648"}),
        settings_(settings_of(folder_, "gw2")) {
    grant(store_, "gw2", "readwrite", "/mlcca/");
    direct_ = std::make_unique<Direct>(loop_, settings_of(folder_, "root"), store_.endpoint(0));
    const std::size_t systems =
        std::max((gateways + kMostGateways - 1) / kMostGateways, gateways * each / kMostOfASystem);
    of_a_system_ = gateways / systems / kOnANetwork * kOnANetwork;
    const auto start = Steady::now();
    for (std::size_t s = 0; s < systems; ++s) describe(fmt::format("s{}", s));
    for (auto& described : described_) {
      for (std::size_t n = 0; n < of_a_system_ / kOnANetwork; ++n) add_medium(*described, n);
    }
    for (const auto& medium : media_)
      for (const auto& one : medium->gateways()) one->begin();
    until([this] {
      return std::ranges::all_of(media_, [](const auto& medium) {
        return medium->done() && std::ranges::all_of(medium->gateways(),
                                                     [](const auto& one) { return one->joined(); });
      });
    });
    fmt::print("{} gateways, {} on a network, in {} Systems: all have joined after {:.1f} s\n",
               count(), kOnANetwork, systems, ms_since(start) / 1000);
    empty_ = compacted_size();
  }

  void run() {
    watched();
    const std::size_t before = granted();
    const std::size_t in_turn = std::max(count() * each_, before) - before;
    const std::size_t octets = total(&Simulated::octets);
    const Cost cost = cost_of([&] { fill(media_.size(), in_turn / media_.size()); });
    const auto made = static_cast<double>(granted() - before);
    fmt::print(
        "one after the other on each network      {:8.0f} admissions/s   {:.0f} us of processors "
        "in "
        "etcd, {:.0f} us in the simulation\n",
        made / cost.seconds, 1e6 * cost.store / made, 1e6 * cost.ours / made);
    fmt::print(
        "on the wire, without watches             {:8.0f} octets each, of them {:.0f} the "
        "request\n",
        cost.octets / made, static_cast<double>(total(&Simulated::octets) - octets) / made);
    sizes();
    at_once();
    beats();
    catch_up();
  }

 private:
  const test::WorkFolder& prepare() {
    test::make_certificates(folder_);
    return folder_;
  }
  void describe(const std::string& name) {
    const std::string file = folder_ / (name + ".xml");
    test::write_file(file, many_xml(name, of_a_system_));
    auto described = std::make_unique<Described>(file);
    core::cluster::Txn txn;
    txn.puts.push_back({.key = described->current.key, .value = described->current.value});
    described->current.create = described->current.mod = direct_->run(txn);
    described_.push_back(std::move(described));
  }
  void add_medium(const Described& described, std::size_t network) {
    auto medium = std::make_unique<Medium>();
    for (std::size_t g = 0; g < kOnANetwork; ++g)
      medium->add(
          std::make_unique<Simulated>(Simulated::Place{.loop = loop_.get(),
                                                       .described = described,
                                                       .gateway = (network * kOnANetwork) + g,
                                                       .network = network,
                                                       .lease = kSimulatedLease,
                                                       .trouble = trouble_},
                                      settings_, store_.endpoint(0)));
    media_.push_back(std::move(medium));
  }

  [[nodiscard]] std::size_t count() const { return media_.size() * kOnANetwork; }
  [[nodiscard]] std::size_t total(std::size_t (Simulated::*what)() const) const {
    std::size_t sum = 0;
    for (const auto& medium : media_)
      for (const auto& one : medium->gateways()) sum += (*one.*what)();
    return sum;
  }
  [[nodiscard]] std::size_t granted() const { return total(&Simulated::granted); }
  [[nodiscard]] std::size_t granted_in_first() const {
    std::size_t sum = 0;
    for (std::size_t m = 0; m < media_of_a_system(); ++m)
      for (const auto& one : media_[m]->gateways()) sum += one->granted();
    return sum;
  }
  [[nodiscard]] std::size_t media_of_a_system() const { return of_a_system_ / kOnANetwork; }

  void until(const std::function<bool()>& holds) {
    // Each gateway must learn that time has passed: it gives up unanswered requests, and asks
    // again.
    auto next = Steady::now() + std::chrono::seconds(1);
    const auto over = [&] {
      if (Steady::now() >= next) {
        next = Steady::now() + std::chrono::seconds(1);
        for (const auto& medium : media_)
          for (const auto& one : medium->gateways()) one->pass(0);
      }
      return holds() || !trouble_.empty();
    };
    const auto longest = kLongest + std::chrono::seconds(gateways_ * each_ / kLeastPerSecond);
    const bool held = loop_.until(over, longest);
    require(trouble_.empty(), "many gateways: " + trouble_);
    require(held, fmt::format("many gateways: not done after {} s",
                              std::chrono::seconds(longest).count()));
  }
  void until_done() {
    until([this] {
      return std::ranges::all_of(media_, [](const auto& medium) { return medium->done(); });
    });
  }
  /// Makes `each` reservations on each of the first `media` networks.
  void fill(std::size_t media, std::size_t each) {
    for (std::size_t m = 0; m < media; ++m) media_[m]->in_turn(each);
    until_done();
  }
  Cost cost_of(const std::function<void()>& work) {
    const auto now = [this] {
      return Cost{.store = processor_seconds(store_.pid(0)),
                  .ours = processor_seconds(::getpid()),
                  .octets = static_cast<double>(loopback_octets())};
    };
    const auto start = Steady::now();
    const Cost before = now();
    work();
    const double seconds = ms_since(start) / 1000;
    const Cost after = now();
    return {.seconds = seconds,
            .store = after.store - before.store,
            .ours = after.ours - before.ours,
            .octets = after.octets - before.octets};
  }

  /// Measures what an admission costs each gateway that follows its System.
  void watched() {
    const std::string folder = described_[0]->keys->prefix();
    const std::int64_t revision = direct_->status().header.revision + 1;
    std::vector<std::unique_ptr<Watcher>> watchers;
    for (std::size_t w = 0; w < kWatchers; ++w)
      watchers.push_back(
          std::make_unique<Watcher>(loop_, settings_, store_.endpoint(0), folder, revision));
    until([&] {
      return std::ranges::all_of(watchers, [](const auto& one) { return one->watches(); });
    });
    const std::size_t media = media_of_a_system();
    const std::size_t each = std::max<std::size_t>(1, std::min(kWatched, count()) / media);
    const std::size_t entries = 4 * each * media;
    const Cost with = cost_of([&] {
      fill(media, each);
      until([&] {
        return std::ranges::all_of(watchers,
                                   [&](const auto& one) { return one->entries() >= entries; });
      });
    });
    const auto octets = static_cast<double>(watchers[0]->octets());
    watchers.clear();
    const Cost without = cost_of([&] { fill(media, each); });
    const auto made = static_cast<double>(each * media);
    fmt::print(
        "each gateway that follows the System     {:8.1f} us of processors in etcd for an "
        "admission "
        "of another one, {:.0f} octets on the wire, of them {:.0f} the changes\n",
        1e6 * (with.store - without.store) / made / kWatchers,
        (with.octets - without.octets) / made / kWatchers, octets / made);
  }

  std::uint64_t compacted_size() {
    const auto revision = direct_->status().header.revision;
    require(store_.control(fmt::format("compaction --physical {} >compacted", revision)),
            "compaction");
    require(store_.control("defrag --command-timeout=120s >defragmented"), "defragmentation");
    return direct_->status().db_bytes;
  }

  void sizes() {
    const auto full = static_cast<double>(direct_->status().db_bytes);
    const auto made = static_cast<double>(granted());
    const auto compacted = static_cast<double>(compacted_size());
    const EntrySizes entry = entry_sizes(*described_[0]);
    fmt::print(
        "{} reservations in the store             {:8.0f} octets each, compacted ({:.0f} MiB); "
        "{:.0f} "
        "with all that has been ({:.0f} MiB)\n",
        granted(), (compacted - static_cast<double>(empty_)) / made, compacted / 1048576,
        (full - static_cast<double>(empty_)) / made, full / 1048576);
    fmt::print(
        "entries of one                           r/ {} octets (with a message on a CAN bus {}), "
        "x/ "
        "{}, m/ {} (of the gateway)\n",
        entry.rate, entry.message, entry.asked, entry.beat);
  }

  void at_once() {
    const std::size_t before = granted();
    const std::size_t conflicts = total(&Simulated::conflicts);
    const Cost cost = cost_of([this] {
      for (const auto& medium : media_) medium->at_once();
      until_done();
    });
    std::size_t refused = 0;
    for (const auto& medium : media_) refused += medium->refused();
    const auto made = static_cast<double>(granted() - before);
    fmt::print(
        "all {} gateways of each network at once  {:8.0f} admissions/s   {:.1f} conflicts each, {} "
        "of {} refused\n",
        kOnANetwork, made / cost.seconds,
        static_cast<double>(total(&Simulated::conflicts) - conflicts) / made, refused, count());
  }

  /// Measures the beats; a gateway beats each quarter of its lease.
  void beats() {
    constexpr int rounds = 5;
    const std::size_t before = total(&Simulated::transactions);
    const Cost cost = cost_of([this] {
      for (int round = 0; round < rounds; ++round) {
        for (const auto& medium : media_)
          for (const auto& one : medium->gateways()) one->pass(kSimulatedLease / 4);
        until_done();
      }
    });
    const auto made = static_cast<double>(total(&Simulated::transactions) - before);
    fmt::print(
        "beats                                    {:8.0f} a second   {:.0f} us of processors "
        "in etcd each\n",
        made / cost.seconds, 1e6 * cost.store / made);
  }

  void catch_up() {
    require(test::run_script(R"(
ip netns add real
ip link add lan0 netns real type veth peer name far
ip -n real link set lan0 up
ip link set far up
)",
                             folder_.path()),
            "links");
    const std::string prefix = described_[0]->keys->prefix();
    grant(store_, "gw1", "read", prefix);
    for (const char* own :
         {"m/real", "d/vote/real", "x/real/", "a/real/", "f/", "v/", "r/n0/real/"})
      grant(store_, "gw1", "readwrite", prefix + own);
    const std::size_t there = granted_in_first();
    const std::size_t wanted = std::max(number_of("CAUGHT_UP", kMostOfASystem), there);
    fill(media_of_a_system(), (wanted - there) / media_of_a_system());
    const std::size_t expected = granted_in_first();
    RealGateway real(folder_, store_,
                     {.name = "real",
                      .description = folder_ / (described_[0]->name() + ".xml"),
                      .certificate = "gw1",
                      .lease = "10s",
                      .state = folder_ / "real.state"});
    std::vector<double> times;
    for (int time = 0; time < 3; ++time) {
      if (time > 0) real.kill();
      const auto start = Steady::now();
      real.start();
      wait_for("no standing: " + real.log(), [&] { return !real.standing().system.empty(); });
      real.wait_until_in();
      const auto has = real.standing().reservations;
      require(has == expected, fmt::format("it has {} of {} reservations", has, expected));
      times.push_back(ms_since(start));
    }
    fmt::print(
        "a real gateway that starts again         {:8.0f} ms (and {:.0f}, {:.0f}) until it takes "
        "part "
        "with {} reservations of others (aim: 2000); mlccad has {:.0f} MiB, mlcca-cluster {:.0f}\n",
        times[0], times[1], times[2], expected, resident_mib(real.daemon()),
        resident_mib(real.bridge()));
    follow(real);
  }

  /// Measures what admissions of others cost the real gateway, and its own ones while they are
  /// made.
  void follow(RealGateway& real) {
    const auto measure = [&](std::size_t first, std::size_t last, const char* where) {
      const double daemon = processor_seconds(real.daemon());
      const double bridge = processor_seconds(real.bridge());
      const std::size_t each = kFollowed / std::max<std::size_t>(last - first, 1);
      for (std::size_t m = first; m < last; ++m) media_[m]->in_turn(each);
      until_done();
      const auto made = static_cast<double>(each * (last - first));
      fmt::print(
          "what it makes of an admission of others  {:8.0f} us of processors in mlccad, "
          "{:.0f} us in mlcca-cluster, {}\n",
          1e6 * (processor_seconds(real.daemon()) - daemon) / made,
          1e6 * (processor_seconds(real.bridge()) - bridge) / made, where);
    };
    if (media_of_a_system() > 1) measure(1, media_of_a_system(), "on other networks");
    measure(0, 1, "on its own one");
    auto client = real.connect();
    std::vector<double> own;
    own.reserve(kAdmitted);
    for (std::size_t c = 0; c < kAdmitted; ++c)
      own.push_back(admit(client, fmt::format("c{}", c), "real", "n0"));
    std::size_t there = 0;
    for (const auto& one : media_[0]->gateways()) there += one->granted();
    fmt::print("an admission of its own beside {} of others {}\n", there, quantiles(own));
  }

  std::size_t gateways_, each_;
  std::size_t of_a_system_ = 0;
  test::WorkFolder folder_;
  test::Store store_;
  cluster::Settings settings_;
  test::Loop loop_;
  std::string trouble_;
  std::unique_ptr<Direct> direct_;
  std::vector<std::unique_ptr<Described>> described_;
  std::vector<std::unique_ptr<Medium>> media_;
  std::uint64_t empty_ = 0;
};

}  // namespace

void measure_many() {
  if (auto prepared = cluster::prepare_http(); !prepared) give_up(prepared.error().text);
  Many(number_of("GATEWAYS", 1000), number_of("RESERVATIONS", 100)).run();
}

}  // namespace mlcca::bench
