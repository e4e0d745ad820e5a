#include "applications/palpation/settings.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "applications/palpation/learning_file.h"

namespace palpate::applications::palpation {
namespace {

constexpr double kMillimetre = 1e-3, kKilopascal = 1e3;

constexpr const char* kSection = "palpation";

using scene::choice_field;
using scene::number_field;
using scene::numbers_field;
using scene::SettingField;

std::vector<SettingField> organ_fields() {
  return {
      number_field(kSection, "young_kpa", 6.0, {0.5, 50.0},
                   "Young's modulus of the organ; a healthy liver has 3 to 8", kKilopascal),
      number_field(kSection, "poisson", 0.45, {0.30, 0.49}, "Poisson's ratio"),
      number_field(kSection, "friction", 0.15, {0.0, 1.0}, "Coulomb's coefficient"),
      number_field(kSection, "tip_radius_mm", 6.0, {3.0, 8.0}, "Of the sphere at the tip", kMillimetre),
      number_field(kSection, "deepest_mm", 8.0, {3.0, 12.0}, "How deep a press is computed", kMillimetre),
      number_field(kSection, "element_mm", 10.0, {5.0, 20.0}, "Edge of the elements inside", kMillimetre)};
}

std::vector<SettingField> trial_fields() {
  return {
      numbers_field(kSection, "nodules", {1.0, 2.0}, {0.0, 3.0}, "Fewest and most of them"),
      numbers_field(kSection, "nodule_mm", {14.0, 18.0}, {4.0, 30.0}, "Smallest and largest diameter",
                    kMillimetre),
      numbers_field(kSection, "nodule_depth_mm", {4.0, 6.0}, {1.0, 30.0},
                    "Of its top below the surface, least and most", kMillimetre),
      numbers_field(kSection, "nodule_ratio", {8.0, 12.0}, {0.1, 100.0},
                    "How many times as stiff as the organ, least and most"),
      number_field(kSection, "nodule_seed", 0.0, {0.0, 1e9}, "Draws the nodules; 0: the run's own seed"),
      number_field(kSection, "trial_s", 90.0, {5.0, 3600.0}, "Longest time to search, from the first touch"),
      number_field(kSection, "dwell_s", 1.0, {0.3, 10.0},
                   "Pressed and held still so long, a place is marked"),
      number_field(kSection, "hard_n", 1.5, {0.1, 20.0}, "Pressing harder counts as too hard"),
      number_field(kSection, "found_mm", 10.0, {1.0, 50.0}, "So near a mark has found a nodule", kMillimetre),
      number_field(kSection, "pause_s", 0.0, {0.0, 600.0},
                   "Shown so long, the next trial begins; 0: when asked for")};
}

std::vector<SettingField> difficulty_fields() {
  return {choice_field(kSection, "difficulty", "drawn", {"drawn", "staircase"},
                       "What sets size and depth: a draw between both ends, or what has been found"),
          number_field(kSection, "level", 3.0, {0.0, kHardestLevel},
                       "Of the staircase's first search: 0 largest and shallowest, 10 smallest and deepest"),
          {.section = kSection,
           .key = "learning_file",
           .kind = scene::SettingKind::file,
           .initial = "",
           .help = "Table to which finished searches are added, over sessions; empty: none"}};
}

std::vector<SettingField> trainee_fields() {
  return {choice_field(kSection, "trainee_senses", "yes", {"yes", "no"},
                       "Whether the scripted trainee feels what it presses"),
          number_field(kSection, "trainee_weber", 0.14, {0.0, 5.0}, "Its Weber fraction for force"),
          number_field(kSection, "trainee_spacing_mm", 15.0, {4.0, 40.0}, "Between the places it presses",
                       kMillimetre),
          number_field(kSection, "trainee_press_mm", 5.0, {1.0, 10.0}, "How deep it presses", kMillimetre)};
}

std::vector<SettingField> fields() {
  auto all =
      scene::mesh_fields("palpation", "Closed surface as STL, OBJ or PLY; empty: the liver that is built in",
                         {70.0, 70.0, 50.0}, "tray");
  for (auto* part : {organ_fields, trial_fields, difficulty_fields, trainee_fields})
    for (auto& field : part()) all.push_back(std::move(field));
  return all;
}

std::vector<scene::SettingComplaint> relations(const scene::SettingValues& values) {
  for (const char* key : {"nodules", "nodule_mm", "nodule_depth_mm", "nodule_ratio"}) {
    const auto [low, high] = values.range(std::string("palpation.") + key);
    if (low > high) return {{"palpation", key, "the smaller number first is expected"}};
  }
  for (const double count : values.range("palpation.nodules"))
    if (count != std::round(count)) return {{"palpation", "nodules", "whole numbers are expected"}};
  for (const char* key : {"nodule_seed", "level"})
    if (const double number = values.number(std::string("palpation.") + key); number != std::round(number))
      return {{"palpation", key, "a whole number is expected"}};
  if (values.number("palpation.deepest_mm") > 1.4 * values.number("palpation.tip_radius_mm"))
    return {{"palpation", "deepest_mm", "at most 1.4 times tip_radius_mm is expected"}};
  if (values.number("palpation.trainee_press_mm") > values.number("palpation.deepest_mm"))
    return {{"palpation", "trainee_press_mm", "at most deepest_mm is expected"}};
  return {};
}

Expected<void> set_nodules(const std::string& how, scene::SettingValues& values) {
  struct Level {
    const char* name;
    std::array<double, 2> diameter, depth;
  };
  constexpr std::array<Level, 3> kLevels{{{"easy", {16.0, 20.0}, {3.0, 5.0}},
                                          {"plain", {14.0, 18.0}, {4.0, 6.0}},
                                          {"hard", {8.0, 12.0}, {5.0, 10.0}}}};
  for (const auto& level : kLevels)
    if (how == level.name) {
      values.set("palpation.nodule_mm", std::vector<double>(level.diameter.begin(), level.diameter.end()));
      values.set("palpation.nodule_depth_mm", std::vector<double>(level.depth.begin(), level.depth.end()));
    }
  return {};
}

Expected<void> set_tissue(const std::string& name, scene::SettingValues& values) {
  // Shear-wave elastography of livers, healthy and cirrhotic; a soft gel for those who like large dents.
  for (const auto& [tissue, kpa] :
       {std::pair{"gel", 3.0}, std::pair{"liver", 6.0}, std::pair{"cirrhotic", 15.0}})
    if (name == tissue) values.set("palpation.young_kpa", kpa);
  return {};
}

Expected<void> set_difficulty(const std::string& what, scene::SettingValues& values) {
  values.set("palpation.difficulty", what);
  return {};
}

Expected<void> set_learning_file(const std::string& file, scene::SettingValues& values) {
  if (file.empty()) return wrong_use("--learning: the name of a file is expected");
  const auto path = std::filesystem::absolute(file).lexically_normal();
  if (const auto lines = read_learning_if_there(path); !lines) return tl::unexpected(lines.error());
  values.set("palpation.learning_file", path.string());
  return {};
}

}  // namespace

const scene::SettingSchema& setting_schema() {
  static const scene::SettingSchema schema{fields(), relations};
  return schema;
}

std::vector<scene::ApplicationOption> options() {
  auto all = scene::mesh_options("palpation", "STL, OBJ or PLY file to press instead of the liver");
  all.push_back({.name = "--nodules",
                 .help = "easy, plain or hard to feel; the settings of [palpation] hold the numbers",
                 .choices = {"easy", "plain", "hard"},
                 .apply = set_nodules});
  all.push_back({.name = "--tissue",
                 .help = "gel, liver or cirrhotic; the settings of [palpation] hold the numbers",
                 .choices = {"gel", "liver", "cirrhotic"},
                 .apply = set_tissue});
  all.push_back({.name = "--difficulty",
                 .help = "drawn, or by staircase: harder after two searches that found all, easier after one "
                         "that did not",
                 .choices = {"drawn", "staircase"},
                 .apply = set_difficulty});
  all.push_back({.name = "--learning",
                 .help =
                     "CSV file to which every finished search is added, over sessions; a staircase goes on "
                     "where it ended there",
                 .apply = set_learning_file});
  return all;
}

PalpationSettings palpation_settings(const scene::SettingValues& values) {
  const auto number = [&](const char* key) { return values.number(std::string("palpation.") + key); };
  const auto range = [&](const char* key) { return values.range(std::string("palpation.") + key); };
  PalpationSettings s{scene::chosen_mesh(values, "palpation")};
  s.young_pa = number("young_kpa");
  s.poisson = number("poisson");
  s.friction = number("friction");
  s.tip_radius = number("tip_radius_mm");
  s.deepest = number("deepest_mm");
  s.element = number("element_mm");
  s.nodule_seed = static_cast<std::uint64_t>(number("nodule_seed"));
  s.nodules = {.fewest = static_cast<int>(range("nodules")[0]),
               .most = static_cast<int>(range("nodules")[1]),
               .diameter = range("nodule_mm"),
               .depth = range("nodule_depth_mm"),
               .ratio = range("nodule_ratio")};
  s.difficulty =
      values.text("palpation.difficulty") == "staircase" ? Difficulty::staircase : Difficulty::drawn;
  s.level = static_cast<int>(number("level"));
  s.learning_file = values.text("palpation.learning_file");
  s.rules = {.seconds = number("trial_s"),
             .dwell_s = number("dwell_s"),
             .hard_n = number("hard_n"),
             .within = number("found_mm"),
             .pause_s = number("pause_s")};
  s.trainee = {.senses = values.text("palpation.trainee_senses") == "yes",
               .weber_fraction = number("trainee_weber"),
               .spacing = number("trainee_spacing_mm"),
               .press = number("trainee_press_mm")};
  return s;
}

PalpationSettings palpation_settings(const scene::SceneDescription& scene) {
  const auto values = scene::from_payload(setting_schema(), scene.settings);
  if (!values) throw std::invalid_argument("palpation: " + values.error().message);
  return palpation_settings(*values);
}

void shorten_for_a_quick_demo(scene::SettingValues& values) {
  constexpr double kSearch_s = 21.5;
  const scene::SettingValues initial(setting_schema());
  if (values.number("palpation.trial_s") == initial.number("palpation.trial_s"))
    values.set("palpation.trial_s", kSearch_s);
}

void describe(const scene::SettingValues& values, scene::SceneDescription& scene) {
  const PalpationSettings s = palpation_settings(values);
  scene.carried_offset.setZero();  // the bare stylus
  scene.bodies = {{"Organ", 0.0}, {"Stylus", 0.0}};
  scene::set_mesh(s, scene);
  scene::SettingValues resolved = values;
  if (s.difficulty == Difficulty::staircase && !s.learning_file.empty()) {
    const auto lines = read_learning_if_there(s.learning_file);
    if (!lines) throw std::invalid_argument(lines.error().message);
    if (const auto level = newest_level(*lines)) resolved.set("palpation.level", *level);
  }
  scene.settings = scene::to_payload(setting_schema(), resolved);
}

}  // namespace palpate::applications::palpation
