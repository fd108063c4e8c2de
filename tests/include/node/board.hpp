// SPDX-License-Identifier: BSD-2-Clause
// What a test program asks of the simulated board that it runs on.
#pragma once
#include <stdint.h>

namespace board {

/// Prints a text where the simulator shows it.
void print(const char* text);

/// Starts to count processor cycles, and how many have passed since; 0 on a board whose simulator
/// counts none. At most 65535.
void start_cycles();
uint16_t cycles();

/// Ends the simulation.
[[noreturn]] void finish();

}  // namespace board
