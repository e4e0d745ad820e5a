#include "palpate/sim/internal/camera_shaders.h"

#include "palpate/render/room_light.h"

namespace palpate::sim {
namespace {

// Every flat thing: the pixel's ray from a table of inverted lens positions, its foot on the rectangle in
// metres.
const char* const kRay = R"(
uniform sampler2D rays;      // x/z, y/z in CameraOptical, lens undone
uniform sampler2D grain;     // smooth noise, repeating
uniform float falloff;
out vec4 colour;
vec2 ray() { return texelFetch(rays, ivec2(gl_FragCoord.xy), 0).xy; }
vec4 seen(vec3 linear, float alpha, vec2 r) {
  float v = 1.0 - falloff * dot(r, r);           // corners are a little darker
  return vec4(encode(linear) * v, alpha);
}
float noise(vec2 p) { return textureLod(grain, p, 0.0).r - 0.5; }
)";

const char* const kFlat = R"(
uniform mat3 to_plane;       // ray to (x, y, 1) / depth on the rectangle
uniform vec2 size;
uniform vec3 corner, side_x, side_y, eye;
uniform vec4 neighbour;      // plane of what stands beside it: it hides a part of the room
uniform sampler2D shadow;
uniform vec4 shadow_part;    // width 0: none
vec3 world(vec2 p) { return corner + p.x * side_x + p.y * side_y; }
float visible(vec2 p) {
  vec2 s = (p - shadow_part.xy) / max(shadow_part.zw, vec2(1e-6));
  if (any(lessThan(s, vec2(0.0))) || any(greaterThan(s, vec2(1.0))) || shadow_part.z == 0.0) return 1.0;
  return 1.0 - textureLod(shadow, s, 0.0).r;
}
float open(vec3 p) { float d = dot(neighbour, vec4(p, 1.0)); return 1.0 - 0.38 / (1.0 + 600.0 * d * d); }
vec2 footprint(vec2 p) { return max(vec2(length(vec2(dFdx(p.x), dFdy(p.x))), length(vec2(dFdx(p.y), dFdy(p.y)))), vec2(1e-7)); }
// Share of the pixel where low < x < high.
float band(float x, float low, float high, float w) {
  return clamp((x - low) / w + 0.5, 0.0, 1.0) - clamp((x - high) / w + 0.5, 0.0, 1.0);
}
float inside(vec2 p, vec2 w) { return band(p.x, 0.0, size.x, w.x) * band(p.y, 0.0, size.y, w.y); }
)";

std::string with(const char* a, const char* b, const char* c) {
  return render::kLightGlsl + render::encoding_glsl(device::Encoding::root) + a + b + c;
}

// What a pixel of a flat surface begins with: its ray r, the place p on the surface and q in the world.
constexpr const char* kPlace = R"(
void main() {
  vec2 r = ray();
  vec3 h = to_plane * vec3(r, 1.0);
  vec2 p = h.xy / h.z;
  vec2 w = footprint(p);
  float alpha = 1.0;
  if (EDGE) {
    alpha = h.z > 0.0 ? inside(p, w) : 0.0;
    if (alpha <= 0.0) discard;
  }
  vec3 q = world(p);
)";

// A flat surface's shader, of which `paint` is the rest of main(). The inside of a surface needs neither a soft edge nor,
// away from the shadow, a look at it.
std::string surface(SurfacePart part, const char* paint) {
  const bool edge = part == SurfacePart::edge, shadowed = part != SurfacePart::plain;
  const std::string switches = std::string("const bool EDGE = ") + (edge ? "true" : "false") +
                               ", SHADOWED = " + (shadowed ? "true" : "false") + ";\n";
  return switches + with(kRay, kFlat, kPlace) + paint;
}

}  // namespace

std::string table_shader(SurfacePart part) {
  return surface(part, R"(
  float cloth = noise(p * 2.3) * 0.14;
  vec3 paint = vec3(0.020, 0.118, 0.300) * (1.0 + cloth);
  float border = 1.0 - band(p.x, 0.012, size.x - 0.012, w.x) * band(p.y, 0.012, size.y - 0.012, w.y);
  float middle = band(p.x, 0.5 * size.x - 0.0016, 0.5 * size.x + 0.0016, w.x);
  vec3 albedo = mix(paint, vec3(0.72, 0.73, 0.71) * (1.0 + 0.2 * cloth), max(border, middle));
  vec3 n = cross(side_x, side_y);
  float lamp_seen = (SHADOWED ? visible(p) : 1.0);
  vec3 light = lit(albedo, q, n, lamp_seen, open(q)) + 0.05 * gloss(q, n, eye, lamp_seen);
  colour = seen(light, alpha, r);
}
)");
}

std::string side_shader() {
  return surface(SurfacePart::edge, R"(
  float wood = noise(vec2(p.x * 1.3, p.y * 9.0)) * 0.6;
  vec3 albedo = mix(vec3(0.46, 0.27, 0.125), vec3(0.60, 0.39, 0.20), clamp(0.5 + 1.4 * wood, 0.0, 1.0));
  colour = seen(lit(albedo, q, cross(side_x, side_y), 1.0, 1.0), alpha, r);
}
)");
}

std::string wall_shader(SurfacePart part) {
  return surface(part, R"(
  float frame = 1.0 - band(p.x, 0.010, size.x - 0.010, w.x) * band(p.y, -1.0, size.y - 0.010, w.y);
  float plaster = noise(p * 2.1) * 0.07;
  float wood = plaster * 6.0;
  vec3 albedo = mix(vec3(0.66, 0.64, 0.60) * (1.0 + plaster), vec3(0.50, 0.31, 0.15) * (1.0 + wood), frame);
  colour = seen(lit(albedo, q, cross(side_x, side_y), (SHADOWED ? visible(p) : 1.0), open(q)), alpha, r);
}
)");
}

std::string leg_shader() {
  return surface(SurfacePart::edge, R"(
  float across = clamp(p.x / size.x * 2.0 - 1.0, -1.0, 1.0);
  vec3 n = across * side_x + sqrt(1.0 - across * across) * cross(side_x, side_y);
  vec3 light = lit(vec3(0.10, 0.105, 0.115), q, n, 0.25, 0.35 + 0.4 * (1.0 - p.y / size.y));
  colour = seen(light, alpha, r);
}
)");
}

std::string floor_shader() {
  return with(kRay, R"(
uniform vec3 room_low, room_high;
uniform vec3 table_corner, table_x, table_y;  // world; its shadow lies on the floor
uniform vec2 table_size, texels;
)",
              R"(
void main() {
  vec3 p = mix(room_low, room_high, vec3(gl_FragCoord.x / texels.x, 0.0, gl_FragCoord.y / texels.y));
  float board = floor(p.x / 0.14);                 // oak boards along z
  float across = fract(p.x / 0.14);
  float tone = noise(vec2(board * 0.37, board * 0.11)) * 0.9;
  float fibre = noise(vec2(p.x * 9.0, p.z * 0.55 + board * 0.31)) * 0.35;
  float gap = 1.0 - smoothstep(0.0, 0.05, min(across, 1.0 - across));
  vec3 albedo = vec3(0.335, 0.225, 0.130) * (1.0 + tone * 0.35 + fibre * 0.8) * (1.0 - 0.35 * gap);
  vec3 up = normalize(cross(table_x, table_y));
  vec3 l = lamp - p;
  vec3 on = p + dot(table_corner - p, up) / dot(l, up) * l - table_corner;
  vec2 q = vec2(dot(on, table_x), dot(on, table_y));
  vec2 e = min(q, table_size - q);
  float dark = smoothstep(-0.05, 0.05, e.x) * smoothstep(-0.05, 0.05, e.y);
  vec3 under = p - table_corner;
  vec2 u = vec2(dot(under, table_x), dot(under, table_y));
  vec2 f = min(u, table_size - u);
  float roof = smoothstep(-0.35, 0.35, f.x) * smoothstep(-0.35, 0.35, f.y);
  colour = vec4(encode(lit(albedo, p, vec3(0, 1, 0), 0.8 * (1.0 - dark), 0.9 - 0.65 * roof)), 1.0);
}
)");
}

std::string room_shader() {
  return with(kRay, R"(
uniform mat3 to_world;
uniform vec3 eye, room_low, room_high;
uniform sampler2D boards;
)",
              R"(
void main() {
  vec2 r = ray();
  vec3 d = to_world * vec3(r, 1.0);
  d += vec3(lessThan(abs(d), vec3(1e-6))) * 1e-6;
  vec3 t = max((room_low - eye) / d, (room_high - eye) / d);
  float k = min(t.x, min(t.y, t.z));
  vec3 p = eye + k * d;
  vec3 below = textureLod(boards, (p.xz - room_low.xz) / (room_high.xz - room_low.xz), 0.0).rgb;
  float above = p.y - room_low.y;
  float skirting = clamp((above - 0.1) / 0.006 + 0.5, 0.0, 1.0);
  float bright = (k == t.x ? 0.70 : 0.80) - 0.10 / (1.0 + 20.0 * above * above) + 0.02 * above;
  vec3 wall = mix(vec3(1.03, 1.02, 0.99), vec3(0.80, 0.835, 0.83), skirting) * bright;
  float v = 1.0 - falloff * dot(r, r);
  colour = vec4((k == t.y && d.y < 0.0 ? below : min(wall, 1.0)) * v, 1.0);
}
)");
}

std::string dot_shader() {
  return with(kRay, kFlat, R"(
uniform float radius;        // of the bright disc; the dark ring round it reaches three times as far
void main() {
  vec2 r = ray();
  vec2 dx = dFdx(r), dy = dFdy(r);
  float bright = 0.0, dark = 0.0;
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < 6; ++i) {
      vec2 s = r + (float(i) - 2.5) / 6.0 * dx + (float(j) - 2.5) / 6.0 * dy;
      vec3 h = to_plane * vec3(s, 1.0);
      float d = h.z > 0.0 ? length(h.xy / h.z - 0.5 * size) : 1.0;
      bright += float(d < radius);
      dark += float(d >= radius && d < 3.0 * radius);
    }
  }
  float alpha = (bright + dark) / 36.0;
  if (alpha <= 0.0) discard;
  vec3 h = to_plane * vec3(r, 1.0);
  vec2 p = h.xy / h.z;
  vec3 q = world(p);
  vec3 n = cross(side_x, side_y);
  float lamp_seen = visible(p);
  // A sensor averages light, not square roots of it: mixed after encoding the disc would look too small.
  vec3 light = lit(vec3(mix(0.022, 0.66, bright / (bright + dark))), q, n, lamp_seen, 1.0);
  colour = seen(light, alpha, r);
}
)");
}

std::string ball_shader() {
  return with(kRay, kFlat, R"(
uniform vec4 ball;           // centre, radius
void main() {
  vec2 r = ray();
  vec2 dx = dFdx(r), dy = dFdy(r);
  vec3 from = ball.xyz - eye;
  float covered = 0.0;
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < 6; ++i) {
      vec2 s = r + (float(i) - 2.5) / 6.0 * dx + (float(j) - 2.5) / 6.0 * dy;
      vec3 h = to_plane * vec3(s, 1.0);
      vec3 past = cross(normalize(world(h.xy / h.z) - eye), from);
      covered += float(h.z > 0.0 && dot(past, past) < ball.w * ball.w);
    }
  }
  if (covered <= 0.0) discard;
  vec3 h = to_plane * vec3(r, 1.0);
  vec3 d = normalize(world(h.xy / h.z) - eye);
  float along = dot(from, d);
  vec3 past = from - along * d;
  vec3 q = eye + (along - sqrt(max(ball.w * ball.w - dot(past, past), 0.0))) * d;
  vec3 n = normalize(q - ball.xyz);
  colour = seen(lit(vec3(0.86, 0.30, 0.035), q, n, 1.0, 1.0), covered / 36.0, r);
}
)");
}

std::string board_shader() {
  return with(kRay, kFlat, R"(
uniform float square;
void main() {
  vec2 r = ray();
  vec3 h = to_plane * vec3(r, 1.0);
  vec2 p = h.xy / h.z;
  vec2 w = footprint(p);
  float alpha = h.z > 0.0 ? inside(p, w) : 0.0;
  if (alpha <= 0.0) discard;
  vec2 c = p / square - 1.0;                       // squares from the outer corner of the pattern
  vec2 f = w / square;
  // Triangle waves, steep at the lines between squares, flat at the pattern's rim.
  vec2 s = clamp(c, 0.5 * f, vec2(10.0, 7.0) - 0.5 * f);
  vec2 edge = abs(fract(s * 0.5 - 0.25) - 0.5) * 2.0 - 0.5;
  vec2 wave = clamp(edge * 2.0 / f, -1.0, 1.0);
  float pattern = 0.5 + 0.5 * wave.x * wave.y;
  float part = band(c.x, 0.0, 10.0, f.x) * band(c.y, 0.0, 7.0, f.y);
  vec3 q = world(p);
  vec3 n = cross(side_x, side_y);
  n *= sign(dot(eye - q, n));
  vec3 light = lit(vec3(mix(0.80, mix(0.03, 0.80, pattern), part)), q, n, 1.0, 1.0);
  colour = seen(light, alpha, r);
}
)");
}

std::string layer_shader() {
  return with(kRay, R"(
uniform sampler2D layer;
uniform vec4 to_layer;       // texture place = ray * zw + xy
uniform vec4 used;           // low and high corner of what was drawn; the rest is of earlier pictures
)",
              R"(
void main() {
  vec2 r = ray();
  vec2 at = r * to_layer.zw + to_layer.xy;
  if (any(lessThan(at, used.xy)) || any(greaterThan(at, used.zw))) discard;
  vec4 c = textureLod(layer, at, 0.0);
  if (c.a <= 0.0) discard;
  colour = c * vec4(vec3(1.0 - falloff * dot(r, r)), 1.0);
}
)");
}

const char* const kTileVertex = R"(
layout(location = 0) in vec3 position;
void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }
)";

const char* const kArmVertex = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in float look;
uniform mat4 to_clip;
out vec3 p, n;
flat out int which;
void main() {
  p = position;
  n = normal;
  which = int(look + 0.5);
  gl_Position = to_clip * vec4(position, 1.0);
}
)";

// Follows render::kLightGlsl.
const char* const kArmFragment = R"(
uniform vec3 eye;
uniform vec3 looks[18];  // of each ArmLook: colour; mirror straight, mirror at the edge, lamp's image; light of its own
in vec3 p, n;
flat in int which;
out vec4 colour;
void main() {
  vec3 m = normalize(n), v = normalize(eye - p);
  float edge = 1.0 - max(dot(m, v), 0.0);
  edge *= edge;
  edge *= edge;
  float up = 2.0 * dot(m, v) * m.y - v.y;          // of the mirrored view
  float room = ambient * clamp(0.6 + 0.75 * up, 0.3, 1.0);
  vec3 shine = gloss(p, m, eye, 1.0);
  vec3 albedo = looks[3 * which], mirrored = looks[3 * which + 1], own = looks[3 * which + 2];
  vec3 light = lit(albedo, p, m, 1.0, 1.0) + (mirrored.x + mirrored.y * edge) * room + mirrored.z * shine + own * (1.0 - 0.6 * edge);
  colour = vec4(encode(light), 1.0);
}
)";

}  // namespace palpate::sim
