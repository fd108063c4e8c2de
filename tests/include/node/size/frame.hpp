// SPDX-License-Identifier: BSD-2-Clause
// What every program of this folder has, so that only the part under measurement differs: some
// data, some zeroed data, and octets that come and go.
#pragma once
#include <stdint.h>

extern volatile uint8_t incoming;
extern volatile uint8_t outgoing;

/// The part that is measured.
void run();
