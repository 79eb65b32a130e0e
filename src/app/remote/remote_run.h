// SPDX-License-Identifier: MIT
//
// The facts of a training in another program, as plain data.
#pragma once

#include <string>

#include "app/remote/sibr_message.h"

namespace qs {

struct RemoteRun {
  std::string address;        ///< "gpu7:6009"
  bool is_answering = false;  ///< the last request was answered
  bool paused = false;        ///< by the user
  std::string problem;        ///< a sentence why there is no new picture; may be empty
  bool speaks_first = false;  ///< the dialect of 2DGS
  std::string source;         ///< folder of its data on its machine; empty: not known
  SibrMetrics metrics;
  int pictures = 0;  ///< so far

  bool operator==(const RemoteRun&) const = default;
};

}  // namespace qs
