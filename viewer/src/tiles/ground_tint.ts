// SPDX-License-Identifier: Apache-2.0
/** The photo's colour around a place, without what is smaller than some metres: cars, and the shadows of trees. `green`: 0 to 1. */
export const groundTintGlsl = `
float brightness(vec3 color) { return dot(color, vec3(0.2126, 0.7152, 0.0722)); }
vec3 groundTint(sampler2D photo, vec2 place, float lod, out float green) {
  vec3 low = textureLod(photo, place, lod).rgb;
  float wide = brightness(textureLod(photo, place, lod + 2.5).rgb);
  green = smoothstep(0.0, 0.1, (2.0 * low.g - low.r - low.b) / (low.r + low.g + low.b + 1e-3));
  return low * max(1.0, 0.8 * wide / (brightness(low) + 1e-3));
}
vec3 grassTint(vec3 tint) { // beside roads the mean has road in it
  return mix(tint, brightness(tint) * vec3(0.9, 1.1, 0.4), 0.4);
}`;
