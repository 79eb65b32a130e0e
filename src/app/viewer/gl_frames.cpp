// SPDX-License-Identifier: MIT
#include "app/viewer/gl_frames.h"

#include <algorithm>
#include <cassert>

#include <epoxy/gl.h>
// After epoxy, which brings GL's functions.
#include <GLFW/glfw3.h>

#include "raster/scene/fail.h"

namespace qs {

GlFrames::GlFrames(GLFWwindow* window) {
  glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
  context_ = glfwCreateWindow(16, 16, "quadsplat frames", nullptr, window);
  glfwWindowHint(GLFW_VISIBLE, GLFW_TRUE);
  if (context_ == nullptr)
    fail(ErrorKind::device, "view: OpenGL gives no second context to share frames with");
}

GlFrames::~GlFrames() { glfwDestroyWindow(context_); }

void GlFrames::bind() { glfwMakeContextCurrent(context_); }

void GlFrames::unbind() {
  for (Slot& slot : slots_) glDeleteBuffers(1, &slot.buffer.name);
  glfwMakeContextCurrent(nullptr);
}

GlBuffer GlFrames::take(int width, int height) {
  const std::lock_guard lock(mutex_);
  const auto slot =
      std::find_if(slots_.begin(), slots_.end(), [](const Slot& s) { return !s.taken; });
  assert(slot != slots_.end());
  const std::size_t bytes = 4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  if (slot->bytes < bytes) {
    glDeleteBuffers(1, &slot->buffer.name);
    glGenBuffers(1, &slot->buffer.name);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, slot->buffer.name);
    // Storage that no CPU can reach stays in the GPU's own memory.
    const auto size = static_cast<GLsizeiptr>(bytes);
    if (epoxy_gl_version() >= 44 || epoxy_has_gl_extension("GL_ARB_buffer_storage")) {
      glBufferStorage(GL_PIXEL_UNPACK_BUFFER, size, nullptr, 0);
    } else {
      glBufferData(GL_PIXEL_UNPACK_BUFFER, size, nullptr, GL_DYNAMIC_COPY);
    }
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    glFinish();
    slot->bytes = bytes;
    slot->buffer.version = ++versions_;
  }
  slot->taken = true;
  return slot->buffer;
}

void GlFrames::give_back(const GlBuffer& buffer) {
  const std::lock_guard lock(mutex_);
  for (Slot& slot : slots_) {
    if (slot.buffer.name == buffer.name && buffer.name != 0) slot.taken = false;
  }
}

}  // namespace qs
