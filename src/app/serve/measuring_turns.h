// SPDX-License-Identifier: MIT
//
// Whose table of modes is measured next, without threads: each visitor has at most one request, and
// the visitor who was measured least is next.
#pragma once

#include <map>
#include <optional>

#include "app/viewer/render/all_modes.h"

namespace qs {

class MeasuringTurns {
 public:
  struct Turn {
    int visitor = 0;
    std::size_t scene = 0;
    NumbersRequest request;
  };

  /// Replaces the visitor's request.
  void want(const Turn& turn);
  /// The visitor wants nothing more.
  void drop(int visitor);
  /// Forgets the visitor and the time.
  void forget(int visitor);

  std::optional<Turn> next() const;
  /// The visitor was measured for so long. `version`: NumbersRequest::version; the request is
  /// dropped if `answered` and it was not replaced meanwhile.
  void measured(int visitor, int version, double ms, bool answered);

 private:
  std::map<int, Turn> wanted_;      // by visitor
  std::map<int, double> spent_ms_;  // by visitor
};

}  // namespace qs
