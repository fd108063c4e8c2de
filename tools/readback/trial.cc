// SPDX-License-Identifier: BSD-2-Clause
#include "tools/readback/trial.hpp"

namespace mlcca::readback {

void Trial::note(const std::string& frame, Fate fate, bool admitted, bool closed) {
  const bool pass = admitted && !closed;
  if (fate == Fate::lost)
    problems.push_back(frame + ": neither came out nor was counted as dropped");
  else if ((fate == Fate::passed) == pass)
    ++(pass ? passed : dropped);
  else if (pass)
    problems.push_back(frame + " was dropped although it is admitted");
  else
    problems.push_back(frame +
                       (closed ? " passed a closed gate" : " passed although it is not admitted"));
}

}  // namespace mlcca::readback
