// SPDX-License-Identifier: MIT
//
// The viewer's loop on the main thread: it collects actions from the window, the script and the
// threads, applies them, requests frames and draws the window. It sleeps while nothing changes.
#pragma once

#include "app/viewer/view_options.h"

namespace qs {

/// Opens the window and returns when it is closed. Throws Error.
void run_viewer(const ViewOptions& options);

}  // namespace qs
