#include "palpate/render/compositor_shaders.h"

#include "palpate/render/room_light.h"
#include "palpate/render/shadow_map.h"

namespace palpate::render {
namespace {

// As CameraModel::distort: where this pixel of the undistorted picture lies in the camera's
// image. Between pixels the bytes are interpolated as they are, as every undistortion does.
const char* const kCamera = R"(
uniform sampler2D image;
uniform vec4 k;              // fx, fy, cx, cy
uniform vec2 size;
uniform vec4 lens;           // k1 k2 p1 p2
uniform vec4 lens_more;      // k3 k4 k5 k6
uniform int fisheye;         // 1: k1 k2 k3 k4 of the angle from the axis
vec2 bent(vec2 n) {
  float r2 = dot(n, n);
  if (fisheye == 1) {
    float r = sqrt(r2);
    if (r < 1e-6) return n;
    float t = atan(r), t2 = t * t;
    return n * (t / r * (1.0 + t2 * (lens.x + t2 * (lens.y + t2 * (lens.z + t2 * lens.w)))));
  }
  float radial = (1.0 + r2 * (lens.x + r2 * (lens.y + r2 * lens_more.x))) /
                 (1.0 + r2 * (lens_more.y + r2 * (lens_more.z + r2 * lens_more.w)));
  return n * radial + vec2(2.0 * lens.z * n.x * n.y + lens.w * (r2 + 2.0 * n.x * n.x),
                           lens.z * (r2 + 2.0 * n.y * n.y) + 2.0 * lens.w * n.x * n.y);
}
vec3 camera() {
  vec2 d = bent((gl_FragCoord.xy - 0.5 - k.zw) / k.xy);
  return textureLod(image, (d * k.xy + k.zw + 0.5) / size, 0.0).rgb;
}
out vec4 colour;
)";

// Lamp past real bodies, and past virtual ones.
std::string seen_glsl(bool maps) {
  if (!maps)
    return "float seen_past_real(vec3 p, vec3 n) { return 1.0; }\n"
           "float seen_past_virtual(vec3 p, vec3 n) { return 1.0; }\n";
  return std::string(kShadowMapGlsl) + R"(
uniform sampler2DShadow map_real, map_virtual;
float seen_past_real(vec3 p, vec3 n) { return lamp_seen(map_real, p, n); }
float seen_past_virtual(vec3 p, vec3 n) { return lamp_seen(map_virtual, p, n); }
)";
}

}  // namespace

std::string background_fragment() {
  return std::string(kCamera) + R"(
void main() { colour = vec4(camera(), 1.0); }
)";
}

// A sample of the layer holds either a virtual thing (alpha 1, encoded colour), or nothing but the share of
// light that shadows take (alpha). Samples are averaged as light, and where none holds anything the camera's
// bytes stay as they are.
std::string over_fragment(const ShaderChoice& choice) {
  const bool many = choice.samples > 1;
  return std::string(kCamera) + encoding_glsl(choice.encoding) +
         "const int SAMPLES = " + std::to_string(choice.samples) + ";\nuniform " +
         (many ? "sampler2DMS" : "sampler2D") + " layer;\n" + R"(
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec3 light = vec3(0.0);
  float taken = 0.0;
  for (int i = 0; i < SAMPLES; ++i) {
    vec4 s = texelFetch(layer, at, )" +
         (many ? "i" : "0") + R"();
    light += decode(s.rgb);
    taken += s.a;
  }
  vec3 behind = camera();
  const float share = 1.0 / float(SAMPLES);
  vec3 mixed = encode(share * light + (1.0 - share * taken) * decode(behind));
  colour = vec4(taken > 0.0 ? mixed : behind, 1.0);
}
)";
}

// invariant: phantoms and what is darkened on them are drawn by two programs and must have the same depth.
const char* const kSolidVertex = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in float look;
uniform mat4 to_clip, to_world;
invariant gl_Position;
out vec3 p, n;
out float share;             // of a tint
void main() {
  share = look;
  vec4 w = to_world * vec4(position, 1.0);
  p = w.xyz;
  n = mat3(to_world) * normal;
  gl_Position = to_clip * w;
}
)";

const char* const kNothingFragment = R"(
void main() {}
)";

std::string item_fragment(const ShaderChoice& choice) {
  return kLightGlsl + encoding_glsl(choice.encoding) + seen_glsl(choice.maps) + R"(
uniform vec3 eye, albedo;
uniform vec3 surface;        // mirror straight, mirror at the edge, lamp's image
uniform vec4 ground;         // plane of the nearest real surface and the light it sends back
uniform vec3 ground_colour;
uniform vec2 shaded_by;      // real bodies, virtual ones: 0 or 1
uniform float tinted;        // 0 or 1
uniform vec3 above, below;   // colours that take the place of albedo
in vec3 p, n;
in float share;
out vec4 colour;
void main() {
  vec3 m = normalize(n), v = normalize(eye - p);
  float towards = dot(m, v);
  m *= towards < 0.0 ? -1.0 : 1.0;                 // sheets have two faces
  float edge = 1.0 - abs(towards);
  edge *= edge;
  edge *= edge;
  vec3 tint = share > 0.0 ? above : below;
  vec3 own = mix(albedo, tint, tinted * min(abs(share), 1.0));
  // A surface close by takes some of the room's light and gives its own colour back.
  float height = max(dot(ground, vec4(p, 1.0)), 0.0);
  float facing = max(-dot(ground.xyz, m), 0.0);
  float near = facing / (1.0 + 60.0 * height);
  float lamp_share = mix(1.0, seen_past_real(p, m), shaded_by.x) * mix(1.0, seen_past_virtual(p, m), shaded_by.y);
  vec3 light = lit(own, p, m, lamp_share, 1.0 - 0.75 * near) + own * ground_colour * (0.9 * facing / (1.0 + 12.0 * height));
  float room = ambient * clamp(0.7 + 0.6 * m.y, 0.3, 1.0);
  light += (surface.x + surface.y * edge) * room + surface.z * gloss(p, m, eye, lamp_share);
  colour = vec4(encode(light), 1.0);
}
)";
}

std::string darkened_fragment(const ShaderChoice& choice) {
  return kLightGlsl + seen_glsl(choice.maps) + R"(
in vec3 p, n;
out vec4 colour;
void main() {
  vec3 m = normalize(n);
  float real = seen_past_real(p, m);
  vec3 before = lit(vec3(1.0), p, m, real, 1.0), after = lit(vec3(1.0), p, m, real * seen_past_virtual(p, m), 1.0);
  colour = vec4(0.0, 0.0, 0.0, 1.0 - after.g / max(before.g, 1e-4));
}
)";
}

const char* const kCatcherVertex = R"(
layout(location = 0) in vec3 position;  // 0..1 on the area
uniform mat4 to_clip;
uniform vec3 corner, side_x, side_y;
uniform vec4 area;           // x, y, width, height on the rectangle, m
out vec2 q;
out vec3 p;
void main() {
  q = area.xy + position.xy * area.zw;
  p = corner + q.x * side_x + q.y * side_y;
  gl_Position = to_clip * vec4(p, 1.0);
}
)";

// The room's light that a sphere takes from a place of a surface below it: cos(angle) (r / distance)^2, the
// form factor of a sphere wholly above the place's horizon. At the contact it is 1.
std::string catcher_fragment() {
  return std::string(kLightGlsl) + R"(
uniform sampler2D shadow;
uniform vec4 part;           // where `shadow` lies; width 0: nowhere
uniform vec3 side_x, side_y;
uniform vec4 spheres[4];     // centre, radius; radius 0: none
uniform float in_image;      // 1: real shadows are in the camera's image already; 0: there is no image
in vec2 q;
in vec3 p;
out vec4 colour;
void main() {
  vec3 n = cross(side_x, side_y);
  vec2 s = (q - part.xy) / max(part.zw, vec2(1e-6));
  bool inside = part.z > 0.0 && all(greaterThanEqual(s, vec2(0.0))) && all(lessThanEqual(s, vec2(1.0)));
  vec2 hidden = inside ? textureLod(shadow, s, 0.0).rg : vec2(0.0);
  hidden.g *= in_image;
  float open = 1.0;
  for (int i = 0; i < 4; ++i) {
    vec3 to = spheres[i].xyz - p;
    float d2 = max(dot(to, to), 1e-9);
    open *= 1.0 - clamp(dot(n, to) * inversesqrt(d2) * spheres[i].w * spheres[i].w / d2, 0.0, 1.0);
  }
  open = min(open, 1.0 - 0.25 * (hidden.r - hidden.g));
  vec3 before = lit(vec3(1.0), p, n, 1.0 - hidden.g, 1.0), after = lit(vec3(1.0), p, n, 1.0 - hidden.r, open);
  colour = vec4(0.0, 0.0, 0.0, 1.0 - after.g / max(before.g, 1e-4));
}
)";
}

}  // namespace palpate::render
