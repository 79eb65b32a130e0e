// SPDX-License-Identifier: MIT
#include "app/viewer/render/gl_frames.h"

#include <algorithm>
#include <bit>
#include <cassert>

#include <epoxy/gl.h>
// After epoxy, which declares GL's functions.
#include <GLFW/glfw3.h>

#include "base/fail.h"

namespace qs {

GlFrames::GlFrames(GLFWwindow* window) {
  glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
  context_ = glfwCreateWindow(16, 16, "quadsplat frames", nullptr, window);
  glfwWindowHint(GLFW_VISIBLE, GLFW_TRUE);
  if (context_ == nullptr)
    fail(ErrorKind::device, "view: OpenGL cannot make a second context for the render thread");
}

GlFrames::~GlFrames() { glfwDestroyWindow(context_); }

void GlFrames::bind() { glfwMakeContextCurrent(context_); }

void GlFrames::unbind() {
  for (Slot& slot : slots_) glDeleteTextures(1, &slot.texture.name);
  glfwMakeContextCurrent(nullptr);
}

GlTexture GlFrames::take(int width, int height) {
  const std::lock_guard lock(mutex_);
  const auto slot = std::ranges::find(slots_, false, &Slot::taken);
  assert(slot != slots_.end());
  if (slot->width != width || slot->height != height) {
    glDeleteTextures(1, &slot->texture.name);
    glGenTextures(1, &slot->texture.name);
    glBindTexture(GL_TEXTURE_2D, slot->texture.name);
    const auto levels =
        static_cast<int>(std::bit_width(static_cast<unsigned>(std::max(width, height))));
    glTexStorage2D(GL_TEXTURE_2D, levels, GL_RGBA8, width, height);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glBindTexture(GL_TEXTURE_2D, 0);
    glFinish();
    slot->width = width;
    slot->height = height;
    slot->texture.version = ++versions_;
  }
  slot->taken = true;
  return slot->texture;
}

void GlFrames::give_back(const GlTexture& texture) {
  const std::lock_guard lock(mutex_);
  for (Slot& slot : slots_)
    if (slot.texture.name == texture.name && texture.name != 0) slot.taken = false;
}

}  // namespace qs
