// SPDX-License-Identifier: BSD-2-Clause
#include "frame.hpp"

volatile uint8_t incoming = 1;
volatile uint8_t outgoing;

int main() {
  for (;;) run();
}
