// SPDX-License-Identifier: BSD-2-Clause
// Encoding, decoding and the narrow check at compile time, on every compiler that a node uses.
// C++14, freestanding: check-node compiles it once for each of them.
#include "mlcca/attribute_list.hpp"
#include "mlcca/der.hpp"
#include "mlcca/der_narrow.hpp"

namespace mlcca {
namespace {

using SwitchNeeds = AttributeList<Period<50_ms>, Omission<2>>;
using Bus = AttributeList<Period<10_ms>, Omission<2>>;
using Bridge = AttributeList<Period<10_ms>, Omission<5>>;

template <size_t N>
constexpr bool same_octets(const der::Blob<N>& blob, const uint8_t (&expected)[N]) {
  for (size_t i = 0; i < N; ++i)
    if (blob.octets[i] != expected[i]) return false;
  return true;
}

// 50 ms are 0x02faf080 ns.
constexpr uint8_t kExpected[] = {0x30, 27, 0x02, 1,    1,    0x0a, 1,    1,    0x04, 8,
                                 0,    0,  0,    0,    0,    0,    0,    0x17, 0x30, 9,
                                 0x84, 4,  0x02, 0xfa, 0xf0, 0x80, 0x87, 1,    2};
static constexpr auto kSwitch = der::encode(der::SubscriberSpec<0x17, SwitchNeeds>{});
static_assert(sizeof kSwitch == sizeof kExpected, "no octet more than the encoding");
static_assert(same_octets(kSwitch, kExpected), "");

constexpr der::Decoded decoded(const uint8_t* data, size_t size) {
  der::Decoded out;
  return der::decode(data, size, &out).ok() ? out : der::Decoded();
}
static_assert(decoded(kSwitch.data(), kSwitch.size()).attributes == SwitchNeeds::set(), "");
static_assert(decoded(kSwitch.data(), kSwitch.size()).subject == 0x17, "");
static_assert(decoded(kSwitch.data(), kSwitch.size() - 1).attributes.empty(), "cut off");

// User attributes: a specification of its own.
constexpr der::UserAttribute kUsers[] = {{"Humidity", 40}, {"Temperature", 300, true}};
struct Station {
  static constexpr der::Channel channel() {
    return der::Channel(der::Role::network, 0, AttributeSet().set(Attribute::latency, 7, true),
                        kUsers, 2);
  }
};
static constexpr auto kStation = der::encode(Station{});
static_assert(decoded(kStation.data(), kStation.size()).attributes.is_dynamic(Attribute::latency),
              "");
static_assert(!decoded(kStation.data(), kStation.size()).user.empty(), "");

// What has no encoding.
static_assert(der::encodable(der::Channel(der::Role::subscriber, 0, AttributeSet())) ==
                  der::Error::subject,
              "");
static_assert(der::encodable(der::Channel(der::Role::publisher, 1,
                                          AttributeSet().set(Attribute::latency, 1, true))) ==
                  der::Error::marks,
              "");

// Figure 5 in 16 bits, from the encoding.
constexpr NarrowCheck check(const uint8_t* data, size_t size,
                            const NarrowProvision<Units16>& given) {
  der::NarrowDecoded<Units16, Side::requirement> needs;
  NarrowCheck refused;
  refused.unfit = 0xff;
  return der::decode(data, size, &needs).ok() ? check_layer(needs.attributes, given) : refused;
}
constexpr auto kBus = narrow<Units16, Side::provision, Bus>();
constexpr auto kBridge = narrow<Units16, Side::provision, Bridge>();
static_assert(check(kSwitch.data(), kSwitch.size(), kBus).outcome() == Outcome::fit, "");
static_assert(check(kSwitch.data(), kSwitch.size(), kBridge).unfit ==
                  1 << index_of(Attribute::omission),
              "");
static_assert(check(kStation.data(), kStation.size(), kBus).unfit == 0xff, "not a requirement");
static_assert(sizeof(NarrowRequirement<Units16>) == 18, "part of the documentation");

#ifdef CASE
// Each case must be refused by the compiler.
template <Value V>
struct Temperature : UserAttribute<Temperature, V, Better::smaller, Composition::slowest> {};
struct BadUnits : Units16 {
  static constexpr uint32_t kTime = 0;
};
#if CASE == 1
constexpr auto kRefused = der::encode(der::SubscriberSpec<0, SwitchNeeds>{});
#elif CASE == 2
constexpr auto kRefused =
    der::encode(der::SubscriberSpec<1, AttributeList<Dynamic<Latency<1_ms>>>>{});
#elif CASE == 3
constexpr auto kRefused = narrow<Units16, Side::requirement, AttributeList<Period<65535_ms>>>();
#elif CASE == 4
constexpr auto kRefused =
    narrow<Units16, Side::provision, AttributeList<Bandwidth<1048560_bytes_per_s>>>();
#elif CASE == 5
constexpr NarrowRequirement<BadUnits> kRefused;
#elif CASE == 6
constexpr auto kRefused = der::encode(der::SubscriberSpec<1, AttributeList<Temperature<300>>>{});
#elif CASE == 7
constexpr auto kRefused = narrow<Units16, Side::requirement, AttributeList<Temperature<300>>>();
#endif
#endif

}  // namespace
}  // namespace mlcca
