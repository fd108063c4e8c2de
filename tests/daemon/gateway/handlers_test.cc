// SPDX-License-Identifier: BSD-2-Clause
// The handlers of requests, each called with the parts that it uses: what is answered, and what is
// refused. There is no Controller, no start and no socket.
#include "daemon/gateway/requests/handlers.hpp"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <systemd/sd-event.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/handle.hpp"
#include "daemon/gateway/admissions.hpp"
#include "daemon/gateway/audit_keeper.hpp"
#include "daemon/gateway/audit_log.hpp"
#include "daemon/gateway/carriers.hpp"
#include "daemon/gateway/channel_reports.hpp"
#include "daemon/gateway/delivery_health.hpp"
#include "daemon/gateway/drop_reports.hpp"
#include "daemon/gateway/endpoints.hpp"
#include "daemon/gateway/gate_events.hpp"
#include "daemon/gateway/gateway_presence.hpp"
#include "daemon/gateway/local_ends.hpp"
#include "daemon/gateway/meshes.hpp"
#include "daemon/gateway/modes.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/report_estimates.hpp"
#include "daemon/gateway/reported_silences.hpp"
#include "daemon/gateway/silence_reports.hpp"
#include "daemon/gateway/tag_bindings.hpp"
#include "daemon/gateway/turn.hpp"
#include "daemon/store/history.hpp"
#include "tests/daemon/gateway/bench.hpp"
#include "tests/daemon/gateway/fakes.hpp"
#include "tests/daemon/store/fake_disk.hpp"
#include "tests/daemon/store/worlds.hpp"

namespace mlcca::test {
namespace {

constexpr std::size_t kLan = 2;
constexpr uid_t kProgram = 991;  ///< may send the control traffic of the Ethernet
constexpr uid_t kCarrier = 990;  ///< carries events between networks
constexpr std::uint64_t kSecondNs = 1'000'000'000;

Asker asks(uid_t user, std::uint64_t session = 1) {
  return {.peer = {.pid = 7, .uid = user, .session = session}, .may_slice = true};
}

/// The message of a Done; empty if it is another body.
std::string done(const Response& response) {
  const auto* body = std::get_if<control::Done>(&response.body);
  return body == nullptr ? std::string() : body->message;
}
/// The message of an error of that kind; empty if it is another body.
std::string error(const Response& response, control::ErrorKind kind) {
  const auto* body = std::get_if<control::Error>(&response.body);
  return body == nullptr || body->kind != kind ? std::string() : body->message;
}
std::string invalid_as(const Response& response) {
  return error(response, control::ErrorKind::invalid);
}
std::string forbidden_as(const Response& response) {
  return error(response, control::ErrorKind::forbidden);
}
bool says(const std::string& message, const std::string& part) { return message.contains(part); }

std::unique_ptr<sd_event, FreeWith<sd_event_unref>> new_loop() {
  sd_event* made = nullptr;
  sd_event_new(&made);
  return std::unique_ptr<sd_event, FreeWith<sd_event_unref>>(made);
}

/// The small system, whose Ethernet accepts subscriptions. c0 goes from bus to bus.
core::System with_subscriptions() {
  core::System system = small_system();
  system.networks[kLan].subscriptions = {
      .accept = core::Subscribing::with_attributes, .most = 2, .origin = {}};
  for (core::Port& port : system.gateways[0].ports)
    if (port.network == kLan) port.control_uid = kProgram;
  return system;
}

/// c0 comes from the Ethernet, and a program carries it to the second bus.
core::System with_carrier() {
  core::System system = small_system();
  system.publishers[0].place = {core::Place::Kind::network, kLan};
  system.gateways[0].relay = kCarrier;
  return system;
}

/// The parts of one gateway, with fakes of everything outside.
class Handlers : public ::testing::Test {
 protected:
  Handlers() {
    log_.on_event([this](const control::Event& event) { events_.push_back(event); });
    EXPECT_TRUE(recorder_.open("/state", disk_));
    describe(small_system());
  }

  void describe(core::System system) {
    for (const core::Network& network : system.networks) kernel_.plug(network.name);
    EXPECT_TRUE(links_.refresh());
    scene_.state = std::make_unique<core::State>(std::move(system));
    scene_.self = 0;
    ++scene_.description;
    gates_.describe(scene_.state->system(), 0);
    gates_.follow();
    control_.open();
    turn_.observe();
    EXPECT_TRUE(turn_.settle());
    EXPECT_TRUE(turn_.enforce());
    events_.clear();
  }
  [[nodiscard]] bool is_granted(std::size_t channel) const {
    const auto& verdicts = scene_.state->decisions()[channel].verdicts;
    return !verdicts.empty() && std::ranges::all_of(verdicts, &core::Verdict::granted);
  }
  /// Whether the gates let anything of the channel pass.
  [[nodiscard]] bool passes(core::Subject subject) const {
    return std::ranges::any_of(kernel_.gates, [&](const auto& gate) {
      return std::ranges::any_of(gate.second.rules, [&](const auto& rule) {
        return rule.first.subject == subject && rule.second.pass;
      });
    });
  }

  std::vector<control::Event> events_;
  store::test::Folder folder_;
  store::test::MemoryDisk memory_;
  store::test::TroubledDisk disk_{memory_, &memory_};
  FakeKernel kernel_;
  FakeClock clock_;
  FakeLinks links_{kernel_};
  FakeControl control_{kernel_};
  FakeGates gates_{kernel_, links_};
  FakeCan can_;
  EventLog log_{SystemLog::to_journald("/nowhere/at/all")};
  Scene scene_;
  std::function<void()> pulse_ = [] {};
  Patience patience_{pulse_, 0};
  std::unique_ptr<sd_event, FreeWith<sd_event_unref>> loop_ = new_loop();
  Aside aside_{loop_.get()};
  Replies replies_{aside_, scene_};
  DeliveryEvents deliveries_{scene_, log_, pulse_, [](core::AdmissionId) { return false; }};
  Recorder recorder_{scene_, gates_, log_, patience_, pulse_};
  CanForwarding forwarding_{scene_, gates_, links_, log_, std::make_unique<FakeCanRules>(kernel_),
                            pulse_};
  Turn turn_{{scene_, gates_, control_, log_, deliveries_, recorder_, forwarding_, pulse_}};
  TagBindings tags_{scene_, gates_, log_, turn_, recorder_, can_, clock_};
  AuditLog audit_{scene_, gates_, clock_};
  DropReports drops_{scene_, gates_, log_, deliveries_, audit_, clock_, pulse_};
  Modes modes_{control_, log_, drops_, audit_, recorder_};
  AuditKeeper audit_keeper_{audit_, modes_, log_, patience_, clock_};
  Carriers carriers_;
  GatewayPresence presence_{{scene_, control_, carriers_, log_, clock_}};
  ReportedSilences silences_{scene_};
  DeliveryHealth delivery_health_{scene_,    gates_, drops_,   forwarding_,
                                  carriers_, clock_, silences_};
  Admissions admissions_{scene_, recorder_, log_, turn_, tags_, clock_};
  LocalEnds local_ends_{log_, clock_};
  Endpoints endpoints_{scene_, gates_, local_ends_};
  ChannelReports channels_{scene_, gates_, delivery_health_, deliveries_};
  SilenceReports silence_reports_{loop_.get(), scene_,           clock_,   gates_,
                                  deliveries_, delivery_health_, silences_};
  GateEvents gate_events_{
      {scene_, gates_, links_, log_, silence_reports_, delivery_health_, tags_}};
  Meshes meshes_{loop_.get(), [](std::size_t) {},
                 [](const std::string&, const std::string&, bool) {}};
  ReportEstimates estimates_{scene_, gates_, forwarding_, meshes_};
  store::History history_ = store::History::open(folder_.path());
  requests::AdmitParts admit_{scene_, recorder_,   admissions_, gates_,       turn_,
                              tags_,  forwarding_, deliveries_, gate_events_, delivery_health_,
                              log_,   nullptr,     channels_,   estimates_,   replies_};
};

// --- reports -------------------------------------------------------------------------------------

TEST_F(Handlers, PingAndMonitorNeedNothing) {
  EXPECT_TRUE(std::holds_alternative<control::Done>(requests::ping({}, asks(1000), {}).body));
  EXPECT_EQ(done(requests::monitor({}, asks(1000), {})), "events follow");
}

TEST_F(Handlers, NetworksAreListedAtOnceIfTheyAreFew) {
  const Response few = requests::networks({scene_, estimates_, replies_}, asks(1000), {});
  const auto& networks = std::get<control::Networks>(few.body).networks;
  ASSERT_EQ(networks.size(), 3U);
  EXPECT_EQ(networks[kLan].name, "eth0");
  EXPECT_FALSE(few.slices);
}

TEST_F(Handlers, AReportOnManyChannelsIsMadeByAChild) {
  core::System system = small_system();
  const core::EventChannel one = system.channels[0];
  for (std::size_t n = 0; n < 2'000; ++n) {
    system.channels.push_back(one);
    system.channels.back().name = fmt::format("more{}", n);
    system.channels.back().subject = 1'000 + n;
  }
  describe(std::move(system));
  EXPECT_TRUE(requests::networks({scene_, estimates_, replies_}, asks(1000), {}).slices);
  EXPECT_TRUE(requests::gate({scene_, gates_, estimates_, replies_}, asks(1000), {}).slices);
}

TEST_F(Handlers, AGateIsNamedByItsPlace) {
  const requests::GateParts parts{scene_, gates_, estimates_, replies_};
  EXPECT_TRUE(std::holds_alternative<control::Gates>(requests::gate(parts, asks(1000), {}).body));
  const std::string why = invalid_as(requests::gate(parts, asks(1000), {.place = "nowhere"}));
  EXPECT_TRUE(says(why, "'nowhere'")) << why;
}

TEST_F(Handlers, ReservationsAreOfAPlaceThatIsThere) {
  const requests::ReservationsParts parts{scene_, admissions_, estimates_, replies_};
  const Response all = requests::reservations(parts, asks(1000), {});
  const Response one = requests::reservations(parts, asks(1000), {.place = "can1"});
  const auto& of_all = std::get<control::Reservations>(all.body).resources;
  const auto& of_one = std::get<control::Reservations>(one.body).resources;
  EXPECT_GT(of_all.size(), of_one.size());
  ASSERT_FALSE(of_one.empty());
  for (const control::Resource& resource : of_one)
    EXPECT_TRUE(says(resource.name, "can1")) << resource.name;
  EXPECT_EQ(invalid_as(requests::reservations(parts, asks(1000), {.place = "can9"})),
            "there is no network or gateway 'can9'");
}

TEST_F(Handlers, WhatIfIsAlwaysDecidedByAChild) {
  const Response response = requests::what_if({scene_, replies_}, asks(1000), {});
  EXPECT_TRUE(response.slices);
}

TEST_F(Handlers, HistoryAnswersWithRowsOfThatKindAlone) {
  const requests::HistoryParts parts{scene_, history_, patience_};
  history_.append({clock_.wall, "granted", 1, "c0", "", "", "", "yes"});
  history_.append({clock_.wall + 1, "refused", 1, "c0", "", "", "", "no"});
  control::HistoryRequest request;
  request.kind = "refused";
  const Response response = requests::history(parts, asks(1000), request);
  const auto& entries = std::get<control::History>(response.body).entries;
  ASSERT_EQ(entries.size(), 1U);
  EXPECT_EQ(entries[0].message, "no");
}

TEST_F(Handlers, HistoryRefusesKindsAndChannelsThatNobodyKnows) {
  const requests::HistoryParts parts{scene_, history_, patience_};
  control::HistoryRequest request;
  request.kind = "rumour";
  EXPECT_TRUE(says(invalid_as(requests::history(parts, asks(1000), request)), "'rumour'"));
  request = {};
  request.channel = "c9";
  EXPECT_TRUE(says(invalid_as(requests::history(parts, asks(1000), request)), "'c9'"));
  request.channel = "c0";
  const Response known = requests::history(parts, asks(1000), request);
  EXPECT_TRUE(std::get<control::History>(known.body).entries.empty()) << "it is described";
}

TEST_F(Handlers, ALongHistoryComesInPages) {
  const requests::HistoryParts parts{scene_, history_, patience_};
  constexpr std::uint32_t rows = 300;
  for (std::uint32_t n = 0; n < rows; ++n)
    history_.append({clock_.wall + n, "granted", 1, "c0", "", "", "", std::to_string(n)});
  control::HistoryRequest request;
  request.limit = rows;
  const Response response = requests::history(parts, asks(1000), request);
  ASSERT_TRUE(response.slices);
  std::size_t seen = 0;
  for (bool more = true; more;) {
    const auto slice = response.slices();
    ASSERT_TRUE(slice);
    seen += std::get<control::History>(slice->body).entries.size();
    more = slice->more;
  }
  EXPECT_EQ(seen, rows);
}

TEST_F(Handlers, ExplainIsOfAChannelThatIsThere) {
  const requests::ChannelsParts parts{scene_, channels_, admissions_, estimates_, replies_};
  const Response response = requests::explain(parts, asks(1000), {.channel = "c0"});
  const auto& channels = std::get<control::Channels>(response.body).channels;
  ASSERT_EQ(channels.size(), 1U);
  EXPECT_TRUE(channels[0].granted);
  EXPECT_TRUE(says(invalid_as(requests::explain(parts, asks(1000), {.channel = "c9"})), "c9"));
}

// --- programs of this gateway --------------------------------------------------------------------

TEST_F(Handlers, TransfersOfItsOwnUserMakeAProgramACarrier) {
  describe(with_carrier());
  const requests::TransfersParts parts{scene_, carriers_, endpoints_, estimates_, replies_};
  const Response of_c0 = requests::transfers(parts, asks(1000), {.channel = "c0", .user = {}});
  ASSERT_EQ(std::get<control::Transfers>(of_c0.body).transfers.size(), 1U);
  EXPECT_FALSE(carriers_.has(1000)) << "it only asks what others carry";
  const control::TransfersRequest own{.channel = {}, .user = kCarrier};
  EXPECT_TRUE(requests::transfers(parts, asks(1000), own).slices);
  EXPECT_FALSE(carriers_.has(kCarrier)) << "another user has asked";
  EXPECT_TRUE(requests::transfers(parts, asks(kCarrier), own).slices);
  EXPECT_TRUE(carriers_.has(kCarrier));
  EXPECT_NE(invalid_as(requests::transfers(parts, asks(1000), {.channel = "c9", .user = {}})), "");
}

TEST_F(Handlers, ACarrierInAnotherNetworkNamespaceIsRefused) {
  describe(with_carrier());
  const requests::TransfersParts parts{scene_, carriers_, endpoints_, estimates_, replies_};
  Asker elsewhere = asks(kCarrier);
  elsewhere.peer.is_in_other_network = true;
  EXPECT_TRUE(
      says(forbidden_as(requests::transfers(parts, elsewhere, {.channel = {}, .user = kCarrier})),
           "network namespace"));
  EXPECT_FALSE(carriers_.has(kCarrier));
}

TEST_F(Handlers, SlicesEndWithAnErrorWhenTheDescriptionIsReplaced) {
  describe(with_carrier());
  const requests::TransfersParts parts{scene_, carriers_, endpoints_, estimates_, replies_};
  const Response response = requests::transfers(parts, asks(1000), {});
  ++scene_.description;
  const auto slice = response.slices();
  ASSERT_TRUE(slice);
  EXPECT_TRUE(std::holds_alternative<control::Error>(slice->body));
  EXPECT_FALSE(slice->more);
}

TEST_F(Handlers, DelaysAreTakenFromCarriersOfWhatIsGranted) {
  core::System system = with_carrier();
  system.gateways[0].provision.set(Attribute::latency, 2 * kMs);
  describe(std::move(system));
  ASSERT_TRUE(is_granted(0));
  const requests::DelayParts parts{scene_, carriers_, endpoints_, delivery_health_, log_, clock_};
  control::DelayRequest late{.subject = 1,
                             .publisher = "p0",
                             .from = "eth0",
                             .to = "can1",
                             .late = 4,
                             .longest_ns = 9'800'000};
  EXPECT_NE(forbidden_as(requests::delay(parts, asks(kCarrier), late)), "") << "no carrier yet";
  carriers_.add(1, kCarrier);
  EXPECT_NE(forbidden_as(requests::delay(parts, asks(kCarrier, 2), late)), "") << "other session";
  EXPECT_TRUE(says(done(requests::delay(parts, asks(kCarrier), late)), "4 events from eth0"));
  ASSERT_EQ(events_.size(), 1U);
  EXPECT_EQ(events_[0].kind, "late");
  EXPECT_EQ(done(requests::delay(parts, asks(kCarrier), late)), "too soon after the last report");
  late.late = 0;
  EXPECT_EQ(done(requests::delay(parts, asks(kCarrier), late)), "nothing that is granted is late");
  late.subject = 99;
  EXPECT_NE(invalid_as(requests::delay(parts, asks(kCarrier), late)), "");
  EXPECT_EQ(events_.size(), 1U);
}

TEST_F(Handlers, AProgramTakesUpOnlyAnEndThatIsMeantForIt) {
  core::System system = small_system();
  system.publishers[0].place = {core::Place::Kind::gateway, 0};
  system.publishers[0].uid = 1000;
  describe(std::move(system));
  const requests::AnnounceParts parts{scene_,  channels_, endpoints_, local_ends_,
                                      nullptr, control_,  estimates_, replies_};
  control::AnnounceRequest request;
  request.channel = "c0";
  EXPECT_NE(invalid_as(requests::announce(parts, asks(1000), request)), "") << "it states no role";
  request.role = control::Role::publisher;
  const Response own = requests::announce(parts, asks(1000), request);
  EXPECT_EQ(std::get<control::Channels>(own.body).endpoints.size(), 1U);
  EXPECT_EQ(own.follows, scene_.state->system().channels[0].subject);
  EXPECT_TRUE(says(forbidden_as(requests::announce(parts, asks(1001), request)), "user 1000"));
  request.name = "other";
  EXPECT_TRUE(says(forbidden_as(requests::announce(parts, asks(1000), request)), "'other'"));
  Asker elsewhere = asks(1000);
  elsewhere.peer.is_in_other_network = true;
  EXPECT_TRUE(says(forbidden_as(requests::announce(parts, elsewhere, request)), "namespace"));
  request.channel = "c9";
  EXPECT_NE(invalid_as(requests::announce(parts, asks(1000), request)), "");
}

TEST_F(Handlers, OnlyTheControlUserOfAPortAnnouncesTheGateway) {
  const requests::PresenceParts parts{scene_, presence_};
  EXPECT_TRUE(says(forbidden_as(requests::presence(parts, asks(kProgram), {})), "not announced"))
      << "no network has Subscriptions";
  describe(with_subscriptions());
  EXPECT_TRUE(says(forbidden_as(requests::presence(parts, asks(1000), {})), "user 991"));
  const Response own = requests::presence(parts, asks(kProgram), {});
  EXPECT_EQ(std::get<control::Presence>(own.body).gateway, "g");
}

TEST_F(Handlers, AnnouncementsOfUnknownGatewaysAreRefused) {
  describe(with_subscriptions());
  const requests::PresenceParts parts{scene_, presence_};
  control::PresenceRequest received;
  received.gateway = "unknown";
  received.network = "eth0";
  received.lasts_ns = kSecondNs;
  EXPECT_NE(forbidden_as(requests::presence(parts, asks(1000), received)), "");
  EXPECT_NE(invalid_as(requests::presence(parts, asks(kProgram), received)), "");
  received.network = "can0";
  EXPECT_TRUE(says(forbidden_as(requests::presence(parts, asks(kProgram), received)), "can0"));
  received.network = "nowhere";
  EXPECT_TRUE(says(forbidden_as(requests::presence(parts, asks(kProgram), received)), "nowhere"));
}

TEST_F(Handlers, ARefusalIsReportedOnlyOfWhatIsSubscribed) {
  describe(with_subscriptions());
  const requests::RefusalParts parts{scene_, log_};
  control::RefusalRequest request;
  request.subject = 1;
  request.network = "eth0";
  request.source = "192.0.2.7";
  request.reason = "too late";
  EXPECT_NE(forbidden_as(requests::refusal(parts, asks(1000), request)), "");
  EXPECT_EQ(done(requests::refusal(parts, asks(kProgram), request)),
            "nothing of that is subscribed on the network now");
  request.subject = 99;
  EXPECT_NE(invalid_as(requests::refusal(parts, asks(kProgram), request)), "");
  EXPECT_TRUE(events_.empty());
}

// --- run-time admissions -------------------------------------------------------------------------

control::Query question_of(const control::Admit& request) {
  control::Query out;
  static_cast<control::ChannelRequest&>(out) = request;
  return out;
}

TEST_F(Handlers, AQueryChangesNothing) {
  const requests::QueryParts parts{scene_, recorder_, delivery_health_, channels_,
                                   turn_,  nullptr,   estimates_,       replies_};
  const Response response = requests::query(parts, asks(1000), question_of(newcomer()));
  const auto& channels = std::get<control::Channels>(response.body).channels;
  ASSERT_FALSE(channels.empty());
  EXPECT_TRUE(channels[0].granted);
  EXPECT_EQ(channels[0].admission, 0U) << "nothing can be released";
  EXPECT_TRUE(scene_.state->admissions().empty());
  EXPECT_FALSE(passes(2));
  control::Admit elsewhere = newcomer();
  elsewhere.to = "can9";
  EXPECT_NE(invalid_as(requests::query(parts, asks(1000), question_of(elsewhere))), "");
}

TEST_F(Handlers, AnAdmissionIsInTheGatesAndAnsweredWhenItIsOnDisk) {
  const Response response = requests::admit(admit_, asks(1000), newcomer());
  EXPECT_TRUE(response.held) << "not before the commit";
  EXPECT_TRUE(passes(2));
  EXPECT_EQ(scene_.state->admissions().size(), 1U);
  EXPECT_TRUE(recorder_.dirty());
  turn_.commit();
  EXPECT_FALSE(recorder_.dirty());
}

TEST_F(Handlers, WhatTheGatesRefuseIsNotAdmitted) {
  kernel_.calls.refuse(1, 1'000);
  const Response response = requests::admit(admit_, asks(1000), newcomer());
  EXPECT_TRUE(says(error(response, control::ErrorKind::world), "nothing was changed"));
  EXPECT_FALSE(response.held);
  EXPECT_TRUE(scene_.state->admissions().empty());
  EXPECT_FALSE(passes(2));
}

TEST_F(Handlers, AKeyIsOfOneAdmission) {
  control::Admit request = newcomer();
  request.key = "mine";
  EXPECT_TRUE(requests::admit(admit_, asks(1000), request).held);
  turn_.commit();
  const Response again = requests::admit(admit_, asks(1000), request);
  EXPECT_TRUE(std::holds_alternative<control::Channels>(again.body)) << "the present decision";
  EXPECT_EQ(scene_.state->admissions().size(), 1U);
  request.publisher = "another";
  EXPECT_TRUE(says(invalid_as(requests::admit(admit_, asks(1000), request)), "the key 'mine'"));
  request.key = "with\nline";
  EXPECT_NE(invalid_as(requests::admit(admit_, asks(1000), request)), "");
  EXPECT_EQ(scene_.state->admissions().size(), 1U);
}

TEST_F(Handlers, OnlyTheControlUserBringsSubscriptions) {
  describe(with_subscriptions());
  control::SubscribeRequest request;
  request.subject = 1;
  request.network = "eth0";
  request.source = "192.0.2.7";
  EXPECT_NE(forbidden_as(requests::subscribe(admit_, asks(1000), request)), "");
  EXPECT_TRUE(says(forbidden_as(requests::subscribe(admit_, asks(kProgram), request)),
                   "without attributes"));
  request.source = "two words";
  EXPECT_TRUE(says(invalid_as(requests::subscribe(admit_, asks(kProgram), request)), "source"));
  request.source = "192.0.2.7";
  request.end = true;
  EXPECT_EQ(done(requests::subscribe(admit_, asks(kProgram), request)),
            "there is no such subscription");
}

TEST_F(Handlers, NothingIsReleasedThatWasNotAdmitted) {
  const requests::ReleaseParts parts{scene_, admissions_, nullptr};
  control::ReleaseRequest request;
  request.key = "nobody's";
  EXPECT_TRUE(says(invalid_as(requests::release(parts, asks(1000), request)), "nobody's"));
  request = {};
  request.admission = 77;
  EXPECT_TRUE(says(invalid_as(requests::release(parts, asks(1000), request)), "77"));
  request = {};
  request.channel = "c0";
  EXPECT_TRUE(says(invalid_as(requests::release(parts, asks(1000), request)),
                   "c0 has no run-time admission"));
  request.channel = "c9";
  EXPECT_NE(invalid_as(requests::release(parts, asks(1000), request)), "");
  EXPECT_TRUE(is_granted(0)) << "what is described stays";
}

TEST_F(Handlers, RenewNamesTheAdmissionThatItDoesNotKnow) {
  control::RenewRequest request;
  request.key = "mine";
  EXPECT_TRUE(says(invalid_as(requests::renew({admissions_}, asks(1000), request)), "mine"));
}

// --- an operator ---------------------------------------------------------------------------------

TEST_F(Handlers, AWithdrawnChannelIsClosedUntilItIsReinstated) {
  const requests::WithdrawParts parts{scene_, turn_, recorder_, log_};
  ASSERT_TRUE(is_granted(0) && passes(1));
  EXPECT_TRUE(says(done(requests::withdraw(parts, asks(0), {"c0"})), "withdrawn: everything"));
  EXPECT_FALSE(is_granted(0) || passes(1));
  EXPECT_EQ(recorder_.contents().released.size(), 1U);
  EXPECT_EQ(done(requests::withdraw(parts, asks(0), {"c0"})), "c0 is withdrawn already");
  EXPECT_EQ(done(requests::reinstate(parts, asks(0), {"c0"})),
            "reinstated: 1 of 1 delivery of c0 is granted");
  EXPECT_TRUE(is_granted(0) && passes(1));
  EXPECT_TRUE(recorder_.contents().released.empty());
  EXPECT_EQ(done(requests::reinstate(parts, asks(0), {"c0"})),
            "c0 is not withdrawn: nothing was changed");
  EXPECT_NE(invalid_as(requests::withdraw(parts, asks(0), {"c9"})), "");
  EXPECT_NE(invalid_as(requests::reinstate(parts, asks(0), {"c9"})), "");
}

TEST_F(Handlers, WhatCannotBeWrittenDownIsNotWithdrawn) {
  const requests::WithdrawParts parts{scene_, turn_, recorder_, log_};
  turn_.commit();
  disk_.trouble(store::test::Trouble::fail, 1, EIO, 1'000);
  EXPECT_NE(error(requests::withdraw(parts, asks(0), {"c0"}), control::ErrorKind::world), "");
  EXPECT_TRUE(is_granted(0) && passes(1));
}

TEST_F(Handlers, TheModeIsAuditOrEnforce) {
  const requests::ModeParts parts{modes_, audit_keeper_, history_};
  EXPECT_TRUE(says(invalid_as(requests::mode(parts, asks(0), {.mode = "lenient"})), "'lenient'"));
  EXPECT_NE(invalid_as(requests::mode(parts, asks(0), {.mode = ""})), "");
  EXPECT_EQ(control_.mode(), gates::Mode::enforce);
  EXPECT_NE(done(requests::mode(parts, asks(0), {.mode = "audit"})), "");
  EXPECT_EQ(control_.mode(), gates::Mode::audit);
  EXPECT_NE(done(requests::mode(parts, asks(0), {.mode = "enforce"})), "");
  EXPECT_EQ(control_.mode(), gates::Mode::enforce);
}

TEST_F(Handlers, EnforceWhenCleanIsForASecondToAYearOfAuditMode) {
  const requests::ModeParts parts{modes_, audit_keeper_, history_};
  control::ModeRequest request{.mode = "enforce", .when_clean_ns = 60 * kSecondNs};
  EXPECT_NE(invalid_as(requests::mode(parts, asks(0), request)), "") << "they enforce already";
  EXPECT_NE(done(requests::mode(parts, asks(0), {.mode = "audit"})), "");
  for (const std::uint64_t time : {kSecondNs - 1, 366 * 86'400 * kSecondNs})
    EXPECT_EQ(
        invalid_as(requests::mode(parts, asks(0), {.mode = "enforce", .when_clean_ns = time})),
        "the time without drops must be 1 second to 365 days");
  EXPECT_NE(
      invalid_as(requests::mode(parts, asks(0), {.mode = "audit", .when_clean_ns = kSecondNs})),
      "");
  EXPECT_NE(done(requests::mode(parts, asks(0), request)), "");
  EXPECT_EQ(control_.mode(), gates::Mode::audit) << "not yet";
  EXPECT_EQ(audit_keeper_.kept_when_clean(), 60 * kSecondNs) << "also for the next daemon";
}

TEST_F(Handlers, AuditSaysTheMode) {
  control_.set_mode(gates::Mode::audit);
  const Response response =
      requests::audit({audit_, modes_, delivery_health_, replies_}, asks(1000), {});
  EXPECT_EQ(std::get<control::Audit>(response.body).mode, "audit");
  EXPECT_FALSE(response.slices);
}

// --- a gateway in no cluster ---------------------------------------------------------------------

TEST_F(Handlers, WithoutAClusterItsReportIsEmptyAndNamesTheGateway) {
  const requests::ClusterParts parts{scene_, nullptr, estimates_, replies_};
  control::ClusterRequest request;
  const Response response = requests::cluster(parts, asks(1000), request);
  EXPECT_EQ(std::get<control::Cluster>(response.body).gateway, "g");
  request.part = "members";
  const Response members = requests::cluster(parts, asks(1000), request);
  EXPECT_TRUE(std::get<control::ClusterMembers>(members.body).members.empty());
  request.network = "can0";
  EXPECT_NE(invalid_as(requests::cluster(parts, asks(1000), request)), "") << "members are of none";
  request = {};
  request.part = "weather";
  EXPECT_TRUE(says(invalid_as(requests::cluster(parts, asks(1000), request)), "'weather'"));
}

TEST_F(Handlers, WithoutAClusterNothingIsDrainedJoinedOrRolledOut) {
  const requests::DrainParts parts{scene_, log_, nullptr};
  EXPECT_TRUE(says(invalid_as(requests::drain(parts, asks(0), {})), "no cluster"));
  EXPECT_TRUE(says(invalid_as(requests::join(parts, asks(0), {})), "no cluster"));
  EXPECT_TRUE(says(invalid_as(requests::rollout({nullptr}, asks(0), {})), "reload"));
  EXPECT_TRUE(says(invalid_as(requests::rollout_state({nullptr}, asks(0), {})), "reload"));
  EXPECT_TRUE(events_.empty());
}

}  // namespace
}  // namespace mlcca::test
