// SPDX-License-Identifier: MIT
// One triangle that covers the window; `at` is (0, 0) in the picture's top left corner.
#version 330 core
out vec2 at;

void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  at = vec2(0.5 + 0.5 * corner.x, 0.5 - 0.5 * corner.y);
  gl_Position = vec4(corner, 0.0, 1.0);
}
