// SPDX-License-Identifier: MIT
//
// Cameras and settings of the caller as the renderer takes them.
#pragma once

#include "library/check/call.h"
#include "quadsplat/quadsplat.h"
#include "raster/api/renderer.h"

namespace qs::library {

/// Throws Error(usage).
Camera camera_of(const QsCamera* camera, const Where& where);

/// The members of QsCamera but its size.
QsCamera camera_struct(const Camera& camera);

/// The number of a culling mode, the default mode for null. Throws Error(usage).
CullMode mode_of(const char* name, const Where& where);

/// The usual settings for null. Throws Error(usage).
RenderSettings settings_of(const QsSettings* settings, const Where& where);

}  // namespace qs::library
