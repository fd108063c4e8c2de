// SPDX-License-Identifier: BSD-2-Clause
// Cortex-M3 under QEMU: vectors, start-up and semihosting.
#include "../board.hpp"

#include <stddef.h>

// The linker script places these.
extern "C" {
extern uint32_t stack_top;
extern uint32_t data_load;
extern uint32_t data_begin;
extern uint32_t data_end;
extern uint32_t bss_begin;
extern uint32_t bss_end;
int main();
void reset();
}

namespace {

// "Semihosting for AArch32 and AArch64", ARM IHI 0107.
enum class Call : uint32_t { write0 = 0x04, exit = 0x18 };
constexpr uint32_t kApplicationExit = 0x20026;

void semihost(Call call, uint32_t argument) {
  register uint32_t r0 asm("r0") = static_cast<uint32_t>(call);
  register uint32_t r1 asm("r1") = argument;
  asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

[[noreturn]] void fault() {
  board::print("fault\n");
  board::finish();
}

}  // namespace

extern "C" {

struct Vectors {
  const void* stack;
  void (*handler[15])();
};
__attribute__((section(".vectors"))) extern const Vectors kVectors;
const Vectors kVectors = {&stack_top,
                          {reset, fault, fault, fault, fault, fault, fault, fault, fault, fault,
                           fault, fault, fault, fault, fault}};

void reset() {
  const uint32_t* from = &data_load;
  for (uint32_t* to = &data_begin; to != &data_end;) *to++ = *from++;
  for (uint32_t* to = &bss_begin; to != &bss_end;) *to++ = 0;
  main();
  board::finish();
}

// The compiler makes calls of these, even freestanding.
void* memcpy(void* to, const void* from, size_t size) {
  auto* out = static_cast<volatile uint8_t*>(to);
  const auto* in = static_cast<const uint8_t*>(from);
  while (size-- != 0) *out++ = *in++;
  return to;
}
void* memset(void* to, int octet, size_t size) {
  auto* out = static_cast<volatile uint8_t*>(to);
  while (size-- != 0) *out++ = static_cast<uint8_t>(octet);
  return to;
}

}  // extern "C"

namespace board {

void print(const char* text) {
  semihost(Call::write0, static_cast<uint32_t>(reinterpret_cast<uintptr_t>(text)));
}

void start_cycles() {}
uint16_t cycles() { return 0; }

void finish() {
  for (;;) semihost(Call::exit, kApplicationExit);
}

}  // namespace board
