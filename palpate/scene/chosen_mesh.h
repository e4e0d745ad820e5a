// A mesh that people may choose instead of an application's own, and where it stands: the settings mesh, unit, scale,
// turn_deg and shift_mm of the application's section, its options --mesh, --unit and --turn-deg, and what the scene says of it.
//
// Values; SI. Any thread. Errors: std::out_of_range for values of a schema without these settings.
#pragma once

#include <string>
#include <vector>

#include "palpate/math/so3.h"
#include "palpate/scene/application.h"
#include "palpate/scene/application_option.h"
#include "palpate/scene/setting_schema.h"

namespace palpate::scene {

struct ChosenMesh {
  std::string mesh_file;  // as the setting names it; empty: the application's own
  double metres_per_unit = 0.001;
  Vector3 turn = Vector3::Zero();   // rad, angles about x, y, z, before it is put on the table
  Vector3 shift = Vector3::Zero();  // m, on the table: to the right, up, towards the user
};

// `help`: of the file; `shift_mm`: where it stands at first; `on`: what lifts it from the table.
std::vector<SettingField> mesh_fields(const std::string& section, const std::string& help,
                                      const Vector3& shift_mm, const std::string& on);
// --mesh, --unit and --turn-deg, the first with this help.
std::vector<ApplicationOption> mesh_options(const std::string& section, const std::string& help);
ChosenMesh chosen_mesh(const SettingValues& values, const std::string& section);
// The mesh to be read, if one is named; nothing else of the scene.
void set_mesh(const ChosenMesh& chosen, SceneDescription& scene);

}  // namespace palpate::scene
