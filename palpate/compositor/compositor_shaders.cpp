#include "palpate/compositor/compositor_shaders.h"

#include "palpate/draw/room_light.h"

namespace palpate {

// Brown-Conrady, as CameraModel::distort: where this pixel of the undistorted picture lies in the camera's
// image.
const char* const kUndistortFragment = R"(
uniform sampler2D image;
uniform vec4 k;              // fx, fy, cx, cy
uniform vec2 size;
uniform vec4 lens;           // k1 k2 p1 p2
uniform float lens_k3;
out vec4 colour;
void main() {
  vec2 n = (gl_FragCoord.xy - 0.5 - k.zw) / k.xy;
  float r2 = dot(n, n);
  float radial = 1.0 + r2 * (lens.x + r2 * (lens.y + r2 * lens_k3));
  vec2 d = n * radial + vec2(2.0 * lens.z * n.x * n.y + lens.w * (r2 + 2.0 * n.x * n.x),
                             lens.z * (r2 + 2.0 * n.y * n.y) + 2.0 * lens.w * n.x * n.y);
  colour = vec4(textureLod(image, (d * k.xy + k.zw + 0.5) / size, 0.0).rgb, 1.0);
}
)";

const char* const kSolidVertex = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 to_clip, to_world;
out vec3 p, n;
void main() {
  vec4 w = to_world * vec4(position, 1.0);
  p = w.xyz;
  n = mat3(to_world) * normal;
  gl_Position = to_clip * w;
}
)";

const char* const kNothingFragment = R"(
void main() {}
)";

std::string item_fragment() {
  return std::string(draw::kLightGlsl) + R"(
uniform vec3 eye, albedo;
uniform vec3 surface;        // mirror straight, mirror at the edge, lamp's image
uniform vec4 ground;         // plane of the nearest real surface and the light it sends back
uniform vec3 ground_colour;
in vec3 p, n;
out vec4 colour;
void main() {
  vec3 m = normalize(n), v = normalize(eye - p);
  float towards = dot(m, v);
  m *= towards < 0.0 ? -1.0 : 1.0;                 // sheets have two faces
  float edge = 1.0 - abs(towards);
  edge *= edge;
  edge *= edge;
  // A surface close by takes some of the room's light and gives its own colour back.
  float height = max(dot(ground, vec4(p, 1.0)), 0.0);
  float facing = max(-dot(ground.xyz, m), 0.0);
  float near = facing / (1.0 + 60.0 * height);
  vec3 light = lit(albedo, p, m, 1.0, 1.0 - 0.75 * near) + albedo * ground_colour * (0.9 * facing / (1.0 + 12.0 * height));
  float room = ambient * clamp(0.7 + 0.6 * m.y, 0.3, 1.0);
  light += (surface.x + surface.y * edge) * room + surface.z * gloss(p, m, eye, 1.0);
  colour = vec4(encode(light), 1.0);
}
)";
}

const char* const kCatcherVertex = R"(
layout(location = 0) in vec3 position;  // 0..1 on the darkened part
uniform mat4 to_clip;
uniform vec3 corner, side_x, side_y;
uniform vec4 part;
out vec2 s;
out vec3 p;
void main() {
  s = position.xy;
  vec2 q = part.xy + s * part.zw;
  p = corner + q.x * side_x + q.y * side_y;
  gl_Position = to_clip * vec4(p, 1.0);
}
)";

std::string catcher_fragment() {
  return std::string(draw::kLightGlsl) + R"(
uniform sampler2D shadow;
uniform vec3 side_x, side_y;
in vec2 s;
in vec3 p;
out vec4 colour;
void main() {
  vec3 n = cross(side_x, side_y);
  float hidden = textureLod(shadow, s, 0.0).r;
  vec3 before = lit(vec3(1.0), p, n, 1.0, 1.0), after = lit(vec3(1.0), p, n, 1.0 - hidden, 1.0 - 0.25 * hidden);
  colour = vec4(0.0, 0.0, 0.0, 1.0 - sqrt(after.g / before.g));  // the picture is square roots of light
}
)";
}

const char* const kOverFragment = R"(
uniform sampler2D layer;
out vec4 colour;
void main() { colour = texelFetch(layer, ivec2(gl_FragCoord.xy), 0); }
)";

}  // namespace palpate
