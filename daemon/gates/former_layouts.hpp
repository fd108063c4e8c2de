// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <string>

#include "base/result.hpp"

namespace mlcca::enforce {

/// After an upgrade: the gates of a daemon with another layout obey a control word that gets
/// no heart-beat any more. It is closed and unpinned here; a gate of ours takes their place where
/// it is attached, and elsewhere they stay, closed. Error: it cannot be read what is there.
Result<void> close_former_layouts(const std::string& root);
/// Closes what obeys this control word, of whatever layout.
void close_word(int map);

}  // namespace mlcca::enforce
