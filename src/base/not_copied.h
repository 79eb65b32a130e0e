// SPDX-License-Identifier: MIT
#pragma once

namespace qs {

/// The base of classes whose objects are neither copied nor moved.
struct NotCopied {
  NotCopied() = default;
  NotCopied(const NotCopied&) = delete;
  NotCopied& operator=(const NotCopied&) = delete;
};

}  // namespace qs
