// SPDX-License-Identifier: BSD-2-Clause
// ATmega under simavr: the first UART is shown, Timer 1 counts cycles.
#include "../board.hpp"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

namespace board {

void print(const char* text) {
  UCSR0B = 1 << TXEN0;
  for (; *text != '\0'; ++text) {
    while ((UCSR0A & 1 << UDRE0) == 0) {
    }
    UDR0 = static_cast<uint8_t>(*text);
  }
}

void start_cycles() {
  TCCR1A = 0;
  TCCR1B = 1 << CS10;
  TCNT1 = 0;
}

uint16_t cycles() { return TCNT1; }

void finish() {
  // simavr ends at a sleep that nothing can interrupt.
  cli();
  for (;;) sleep_mode();
}

}  // namespace board
