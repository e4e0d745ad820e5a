// What people set of palpation: the organ, its matter, the tip, the nodules that are drawn, the rules of a trial, and the
// scripted trainee. Stands in the world file's [palpation], travels as the scene's payload. SI; values.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "palpate/scene/application.h"
#include "palpate/scene/application_option.h"
#include "palpate/scene/chosen_mesh.h"
#include "palpate/scene/setting_schema.h"

namespace palpate::applications::palpation {

inline constexpr int kHardestLevel = 10;  // of the staircase; the easiest is 0

// What sets how large and how deep a trial's nodules are: a draw between the ends of NoduleRanges, or a staircase, which
// follows what the trainee finds, between them (difficulty.h).
enum class Difficulty { drawn, staircase };

// From which a trial's nodules are drawn, evenly between both ends.
struct NoduleRanges {
  int fewest = 1, most = 2;
  std::array<double, 2> diameter{0.014, 0.018};  // m
  std::array<double, 2> depth{0.004, 0.006};     // m, of its top below the surface
  std::array<double, 2> ratio{8.0, 12.0};        // of its Young's modulus to the organ's
};

struct TrialRules {
  double seconds = 90.0;  // at most, from the first touch
  double dwell_s = 1.0;   // held still so long, a place is marked
  double hard_n = 1.5;    // pressing harder is too hard
  double within = 0.010;  // m: a mark so near to a nodule's place on the surface has found it
  double pause_s = 0.0;   // shown so long, the next trial begins by itself; 0: when a person asks for it
};

struct TraineeSettings {
  bool senses = true;            // false: it feels nothing and marks by lot
  double weber_fraction = 0.14;  // of the force that it tells from another three times in four
  double spacing = 0.015;        // m, of the places it presses
  double press = 0.005;          // m, how deep
};

struct PalpationSettings : scene::ChosenMesh {  // without one: the liver that is built in
  double young_pa = 6000.0, poisson = 0.45, friction = 0.15;
  double tip_radius = 0.006;                // m
  double deepest = 0.008, element = 0.010;  // m: how deep it is tabulated, edge of the elements inside
  std::uint64_t nodule_seed = 0;            // 0: the run's
  NoduleRanges nodules;
  Difficulty difficulty = Difficulty::drawn;
  int level = 3;              // of the first trial, where a staircase sets it
  std::string learning_file;  // to which finished searches are added (learning_file.h); empty: to none
  TrialRules rules;
  TraineeSettings trainee;
};

const scene::SettingSchema& setting_schema();
PalpationSettings palpation_settings(const scene::SettingValues& values);
// Of a scene that comes from anywhere. Throws std::invalid_argument where its payload is not as the schema has it.
PalpationSettings palpation_settings(const scene::SceneDescription& scene);
// --mesh, --unit, --nodules, --tissue, --difficulty, --learning.
std::vector<scene::ApplicationOption> options();
// Fills what the scene says of palpation: the bare stylus, the bodies, the mesh to be read, the payload. With a staircase
// and a file of searches that a staircase has set, the level is the newest one there: whoever has the scene, as a recording
// has, needs no file. Throws std::invalid_argument for a file that is no such.
void describe(const scene::SettingValues& values, scene::SceneDescription& scene);
// A search so short that a quick demo sees its end, where its length is as it was.
void shorten_for_a_quick_demo(scene::SettingValues& values);

}  // namespace palpate::applications::palpation
