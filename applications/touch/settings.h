// What people set of touch: the mesh that is felt, where it stands on the table, and of what material it is.
// Stands in the world file's [touch], travels as the scene's payload. SI; values.
#pragma once

#include <string>
#include <vector>

#include "palpate/scene/application.h"
#include "palpate/scene/application_option.h"
#include "palpate/scene/chosen_mesh.h"
#include "palpate/scene/setting_schema.h"

namespace palpate::applications::touch {

struct SurfaceSettings : scene::ChosenMesh {  // without one: the organ that is built in
  double stiffness = 600.0;                   // N/m, along all directions
  double damping = 2.0;                       // N s/m, along the normal
  double static_friction = 0.4,
         friction = 0.3;       // tangential over normal force: until it slides, while it does
  std::string colour = "red";  // one of looks.h
};

const scene::SettingSchema& setting_schema();
SurfaceSettings surface_settings(const scene::SettingValues& values);
// Of a scene that comes from anywhere. Throws std::invalid_argument where its payload is not as the schema
// has it; scene::from_payload() says so beforehand.
SurfaceSettings surface_settings(const scene::SceneDescription& scene);
// --mesh, --unit, --turn-deg, --material and --colour.
std::vector<scene::ApplicationOption> options();
// Fills what the scene says of touch: the bare stylus, the bodies, the mesh to be read, the payload.
void describe(const scene::SettingValues& values, scene::SceneDescription& scene);

}  // namespace palpate::applications::touch
