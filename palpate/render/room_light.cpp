#include "palpate/render/room_light.h"

namespace palpate::render {

const char* const kLightGlsl = R"(
uniform vec3 lamp;
uniform float key;
uniform float ambient;
float sky(vec3 n) { return ambient * (0.75 + 0.25 * n.y); }
vec3 lit(vec3 albedo, vec3 p, vec3 n, float visible, float open) {
  float facing = max(dot(n, normalize(lamp - p)), 0.0);
  return albedo * (sky(n) * open + key * visible * facing);
}
vec3 gloss(vec3 p, vec3 n, vec3 eye, float visible) {
  vec3 h = normalize(normalize(lamp - p) + normalize(eye - p));
  float c = max(dot(n, h), 0.0);
  c *= c;
  c *= c;
  c *= c;
  c *= c;
  return vec3(key * visible * c * c);              // power 32
}
)";

std::string encoding_glsl(device::Encoding encoding) {
  switch (encoding) {
    case device::Encoding::srgb:  // IEC 61966-2-1
      return R"(
vec3 encode(vec3 linear) {
  vec3 x = clamp(linear, 0.0, 1.0);
  return mix(1.055 * pow(max(x, vec3(1e-6)), vec3(1.0 / 2.4)) - 0.055, 12.92 * x, vec3(lessThan(x, vec3(0.0031308))));
}
vec3 decode(vec3 encoded) {
  return mix(pow((encoded + 0.055) / 1.055, vec3(2.4)), encoded / 12.92, vec3(lessThan(encoded, vec3(0.04045))));
}
)";
    case device::Encoding::linear:
      return R"(
vec3 encode(vec3 linear) { return clamp(linear, 0.0, 1.0); }
vec3 decode(vec3 encoded) { return encoded; }
)";
    case device::Encoding::root:
      break;
  }
  return R"(
vec3 encode(vec3 linear) { return sqrt(clamp(linear, 0.0, 1.0)); }
vec3 decode(vec3 encoded) { return encoded * encoded; }
)";
}

void set_light(Program& program, const device::RoomLight& light) {
  program.set("lamp", Vector3f(light.lamp.cast<float>()))
      .set("key", static_cast<float>(light.key))
      .set("ambient", static_cast<float>(light.ambient));
}

}  // namespace palpate::render
