// SPDX-License-Identifier: MIT
// The frame alone, enlarged linearly. The result equals present.frag's without a map, a second frame
// or cubic interpolation. Software OpenGL computes all branches of present.frag, which takes 4 times as long.
#version 330 core
uniform sampler2D picture;
in vec2 at;
out vec4 color;

void main() { color = vec4(texture(picture, at).rgb, 1.0); }
