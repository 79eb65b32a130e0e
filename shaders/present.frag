// SPDX-License-Identifier: MIT
// The frame, or with a heat map: the map's colours with the frame's detail, as pictures of
// `quadsplat render --heatmap` have it.
#version 330 core
uniform sampler2D picture;  // with mipmaps while a heat map is shown
uniform sampler2D heat;     // counts, one texel a cell
uniform sampler1D colors;   // colour map
uniform float heat_maximum; // of the scale; 0: no heat map
uniform vec2 heat_cells;    // cells across the picture, parts of a cell counted
in vec2 at;
out vec4 color;

const float kDetail = 0.5;      // share of the frame's own contrast
const float kTileLevel = 4.0;   // mipmap level whose texels are 16 x 16 pixels

float gray(vec3 rgb) { return dot(rgb, vec3(0.299, 0.587, 0.114)); }

void main() {
  vec3 rgb = texture(picture, at).rgb;
  if (heat_maximum > 0.0) {
    float value = texelFetch(heat, ivec2(at * heat_cells), 0).r;
    float detail = gray(rgb) - gray(textureLod(picture, at, kTileLevel).rgb);
    rgb = texture(colors, clamp(value / heat_maximum, 0.0, 1.0)).rgb + kDetail * detail;
  }
  color = vec4(rgb, 1.0);
}
