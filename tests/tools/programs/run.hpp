// SPDX-License-Identifier: BSD-2-Clause
// Runs any program of the build tree with standard streams that fail.
#pragma once
#include <string>
#include <vector>

namespace mlcca::test {

/// What a standard stream of a program is.
enum class Stream {
  file,    ///< its content is captured
  full,    ///< /dev/full
  closed,  ///< no open file
  gone,    ///< a pipe without a reader
};

/// How a program is started.
struct Start {
  std::string program;  ///< file in the build tree
  std::vector<std::string> arguments;
  std::vector<std::string> environment;
  Stream out = Stream::file;
  Stream error = Stream::file;
  std::string input;  ///< content of standard input
};

struct End {
  int status = -1;  ///< exit status; less than 0: minus the signal that ended it
  std::string out;
  std::string error;
};

/// Runs a program until it ends.
End run(const Start& start);

/// The folder with the programs that are tested.
std::string build_folder();

}  // namespace mlcca::test
