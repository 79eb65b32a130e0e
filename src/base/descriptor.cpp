// SPDX-License-Identifier: MIT
#include "base/descriptor.h"

#include <unistd.h>

namespace qs {

void Descriptor::reset() {
  if (number_ >= 0) close(number_);
  number_ = -1;
}

}  // namespace qs
