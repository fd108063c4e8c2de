// SPDX-License-Identifier: BSD-2-Clause
// The emergency switch of the paper on a small node. A subscriber's requirements come as an
// encoding; the node reads it, holds it against what its own network provides, and prints what
// follows. Then the cycles of the two steps.
#include "board.hpp"
#include "mlcca/attribute_list.hpp"
#include "mlcca/der.hpp"
#include "mlcca/der_narrow.hpp"
#include "mlcca/narrow.hpp"

namespace {

using namespace mlcca;

using SwitchNeeds = AttributeList<Period<50_ms>, Omission<2>>;
using OwnBus = AttributeList<Period<10_ms>, Omission<2>>;
using Bridge = AttributeList<Period<10_ms>, Omission<5>>;
using LossyMesh = AttributeList<Dynamic<Latency<60_ms>>, Period<20_ms>, Dynamic<Omission<1>>>;
using BestCase = AttributeList<Dynamic<Latency<5_ms>>, Period<20_ms>, Omission<1>>;

using SixNeeds = AttributeList<Latency<20_ms>, Jitter<5_ms>, Period<50_ms>,
                               Bandwidth<400_bytes_per_s>, PacketLoss<1000_ppm>, Omission<2>>;
using SixGiven = AttributeList<Latency<8_ms>, Jitter<2_ms>, Period<10_ms>, Bandwidth<50_kB_per_s>,
                               PacketLoss<100_ppm>, Omission<1>>;

constexpr auto kSwitch = der::encode(der::SubscriberSpec<0x17, SwitchNeeds>{});
constexpr auto kSix = der::encode(der::PublisherSpec<0x18, SixNeeds>{});

/// What came over the network: the compiler must not know.
uint8_t received[der::kMaxPlainSize];
uint8_t received_size;

template <size_t N>
void receive(const der::Blob<N>& blob, uint8_t cut_off = 0) {
  received_size = static_cast<uint8_t>(N - cut_off);
  for (uint8_t i = 0; i < received_size; ++i) received[i] = blob.octets[i];
}

template <class T>
void hide(T& object) {
  asm volatile("" : : "r"(&object) : "memory");
}

template <class Units>
__attribute__((noinline)) NarrowCheck check(const NarrowRequirement<Units>& needs,
                                            const NarrowProvision<Units>& given) {
  return check_layer(needs, given);
}

template <class Units>
__attribute__((noinline)) bool decode(der::NarrowDecoded<Units, Side::requirement>* out) {
  return der::decode(received, received_size, out).ok();
}

const char* word(Outcome outcome) {
  if (outcome == Outcome::fit) return "fit";
  return outcome == Outcome::unfit ? "unfit" : "run_time";
}

template <class Units, class Provision>
void judge(const char* network) {
  constexpr auto provision = narrow<Units, Side::provision, Provision>();
  auto given = provision;
  hide(given);
  der::NarrowDecoded<Units, Side::requirement> needs;
  board::print(network);
  if (!decode(&needs)) {
    board::print(" malformed\n");
    return;
  }
  const NarrowCheck answer = check(needs.attributes, given);
  board::print(" ");
  board::print(word(answer.outcome()));
  for (uint8_t i = 0; i < kAttributes; ++i)
    if (answer.outcome(attribute_at(i)) != Outcome::fit) {
      board::print(" ");
      board::print(kAttributeTable[i].name);
    }
  board::print("\n");
}

void print_number(const char* what, uint16_t number) {
  char digits[6] = {};
  uint8_t at = 5;
  do {
    digits[--at] = static_cast<char>('0' + number % 10);
    number = static_cast<uint16_t>(number / 10);
  } while (number != 0);
  board::print(what);
  board::print(digits + at);
  board::print("\n");
}

template <class Units>
void measure(const char* decode_text, const char* check_text) {
  constexpr auto provision = narrow<Units, Side::provision, SixGiven>();
  auto given = provision;
  hide(given);
  der::NarrowDecoded<Units, Side::requirement> needs;
  board::start_cycles();
  const uint16_t idle = board::cycles();
  board::start_cycles();
  const bool ok = decode(&needs);
  const auto decoding = static_cast<uint16_t>(board::cycles() - idle);
  board::start_cycles();
  const NarrowCheck answer = check(needs.attributes, given);
  const auto checking = static_cast<uint16_t>(board::cycles() - idle);
  hide(answer);
  if (!ok || answer.outcome() != Outcome::fit) board::print("six attributes do not fit\n");
  print_number(decode_text, decoding);
  print_number(check_text, checking);
}

}  // namespace

int main() {
  receive(kSwitch);
  judge<Units16, OwnBus>("own-bus");
  judge<Units16, Bridge>("bridge");
  judge<Units16, LossyMesh>("lossy-mesh");
  judge<Units16, BestCase>("best-case");
  judge<Units32, OwnBus>("own-bus-32");
  judge<Units32, Bridge>("bridge-32");
  receive(kSwitch, 1);
  judge<Units16, OwnBus>("cut-off");
  receive(kSix);
  measure<Units16>("cycles16-decode ", "cycles16-check ");
  measure<Units32>("cycles32-decode ", "cycles32-check ");
  board::finish();
}
