#include "palpate/draw/room_light.h"

namespace palpate::draw {

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
vec3 encode(vec3 linear) { return sqrt(clamp(linear, 0.0, 1.0)); }
)";

void set_light(Program& program, const RoomLight& light) {
  program.set("lamp", Vector3f(light.lamp.cast<float>()))
      .set("key", static_cast<float>(light.key))
      .set("ambient", static_cast<float>(light.ambient));
}

}  // namespace palpate::draw
