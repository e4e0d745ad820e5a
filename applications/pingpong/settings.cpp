#include "applications/pingpong/settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "applications/pingpong/match.h"

namespace palpate::applications::pingpong {
namespace {

constexpr double kMs = 1e-3;
constexpr double kLightestBat = 0.02;  // kg; the lightest stylus alone weighs more
constexpr NumberRange kRestitution{0.0, 1.0};
// A damped spring that lets go at zero force cannot take more of the speed away: exp(-2) is its bound.
constexpr NumberRange kRestitutionOfBat{0.15, 1.0};

using scene::choice_field;
using scene::number_field;
using scene::numbers_field;

std::vector<scene::SettingField> fields() {
  return {
      number_field("scene", "bat_radius_m", 0.075, kPositive, "Radius of the bat's blade"),
      numbers_field("scene", "bat_offset_m", {0.0, 0.0, -0.09}, {},
                    "From the stylus tip to the blade's centre, in Tip"),
      number_field("scene", "bat_mass_kg", 0.0, {0.0, 10.0},
                   "What an impact has to move: bat, stylus and what of the hand gives way; 0: held fast"),
      number_field("ball", "mass_kg", 0.0027, kPositive, "Mass of the ball"),
      number_field("ball", "radius_m", 0.020, kPositive, "Radius of the ball"),
      number_field("ball", "restitution_table", 0.93, kRestitution, "Of the ball on table and wall"),
      number_field("ball", "restitution_bat", 0.80, kRestitutionOfBat, "Of the ball on the bat"),
      number_field("ball", "contact_ms", 4.0, kPositive, "Duration of a contact with the bat", kMs),
      numbers_field("ball", "serve_speed_m_s", {2.0, 3.5}, kPositive,
                    "Speed of the slowest and the fastest serve"),
      choice_field("ball", "physics", "full", {"full", "paper"}, "Air, spin and friction, or gravity alone"),
      choice_field("ball", "contact", "non-sticky", {"non-sticky", "paper", "hunt-crossley"},
                   "The spring of the bat"),
      number_field("match", "serves", 0.0, {0.0, 1000.0},
                   "After so many a match is over; 0: it has no end and one level, serve_speed_m_s"),
      number_field("match", "level", 1.0, {1.0, kLevels},
                   "That a match begins with; one that is won leads to the next")};
}

std::vector<scene::SettingComplaint> relations(const scene::SettingValues& values) {
  std::vector<scene::SettingComplaint> complaints;
  const double bat = values.number("scene.bat_mass_kg"), ball = values.number("ball.mass_kg");
  const auto speed = values.range("ball.serve_speed_m_s");
  if (bat > 0.0 && bat < kLightestBat)
    complaints.push_back({"scene", "bat_mass_kg",
                          fmt::format("is {}; 0 (held fast), or {} to 10 for bat, stylus and what of the "
                                      "hand gives way, is expected",
                                      bat, kLightestBat)});
  if (bat > 0.0 && ball >= bat)
    complaints.push_back(
        {"ball", "mass_kg",
         fmt::format("is {}, the bat's {}; a ball lighter than the bat is expected", ball, bat)});
  for (const char* key : {"serves", "level"})
    if (const double value = values.number(fmt::format("match.{}", key)); value != std::floor(value))
      complaints.push_back({"match", key, fmt::format("is {}, a whole number is expected", value)});
  if (speed[0] > speed[1]) complaints.push_back({"ball", "serve_speed_m_s", "[low, high] with low <= high"});
  return complaints;
}

scene::ContactModel contact_model_of(const std::string& name) {
  return name == "paper"           ? scene::ContactModel::paper
         : name == "hunt-crossley" ? scene::ContactModel::hunt_crossley
                                   : scene::ContactModel::non_sticky;
}

}  // namespace

const scene::SettingSchema& setting_schema() {
  static const scene::SettingSchema schema{fields(), relations};
  return schema;
}

GameSettings game_settings(const scene::SettingValues& values) {
  GameSettings game;
  game.ball_radius = values.number("ball.radius_m");
  game.ball_mass = values.number("ball.mass_kg");
  game.surface_restitution = values.number("ball.restitution_table");
  game.bat_radius = values.number("scene.bat_radius_m");
  game.bat_restitution = values.number("ball.restitution_bat");
  if (const double mass = values.number("scene.bat_mass_kg"); mass > 0.0) game.bat_mass = mass;
  game.contact_s = values.number("ball.contact_ms");
  game.flight = values.text("ball.physics") == "paper" ? Flight::paper : Flight::full;
  game.contact_model = contact_model_of(values.text("ball.contact"));
  game.serve_speed = values.range("ball.serve_speed_m_s");
  game.match.serves = static_cast<int>(values.number("match.serves"));
  game.match.level = static_cast<int>(values.number("match.level"));
  return game;
}

GameSettings game_settings(const scene::SceneDescription& scene) {
  const auto values = scene::from_payload(setting_schema(), scene.settings);
  if (!values) throw std::invalid_argument("pingpong: " + values.error().message);
  return game_settings(*values);
}

void ease_for_a_person(scene::SettingValues& values) {
  constexpr double kFastestToBegin = 2.3;  // m/s
  constexpr double kServesOfAMatch = 20.0;
  const auto serve = values.range("ball.serve_speed_m_s");
  // A match has its own serves: who has set speeds wants those.
  const scene::Setting& as_set = values.at("ball.serve_speed_m_s");
  if (as_set.value == as_set.field.initial && values.number("match.serves") == 0.0)
    values.set("match.serves", kServesOfAMatch);
  values.set("ball.serve_speed_m_s",
             std::vector<double>{serve[0], std::min(serve[1], std::max(kFastestToBegin, serve[0]))});
}

void describe(const scene::SettingValues& values, scene::SceneDescription& scene) {
  scene.carried_offset = values.vector("scene.bat_offset_m");
  scene.bodies = {{"Ball", values.number("ball.mass_kg")}, {"Bat", values.number("scene.bat_mass_kg")}};
  scene.settings = scene::to_payload(setting_schema(), values);
}

}  // namespace palpate::applications::pingpong
