// SPDX-License-Identifier: MIT
//
// A new folder among the system's temporary files. The destructor deletes it.
#pragma once

#include "base/temporaries.h"

namespace qs {

class WorkFolder : public UnfinishedFolder {
 public:
  /// Throws Error(input) if the folder cannot be created.
  WorkFolder();
};

}  // namespace qs
