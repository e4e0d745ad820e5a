// What people set of ping-pong: ball, bat, how they meet, how fast serves are, and when a match is over. Stands in
// the world file's [ball], [scene] and [match], travels as the scene's payload. SI; values.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "palpate/scene/application.h"
#include "palpate/scene/setting_schema.h"

namespace palpate::applications::pingpong {

// How balls fly and bounce: with drag, spin and friction, or under gravity alone as in the 2006 paper.
enum class Flight : std::uint8_t { full, paper };

struct MatchSettings {
  int serves = 0;  // of a match; 0: it has no end, and serves are as GameSettings has them
  int level = 1;   // that it begins with

  bool operator==(const MatchSettings&) const = default;
};

struct GameSettings {
  double ball_radius = 0.020, ball_mass = 0.0027;
  double surface_restitution = 0.93;  // of table and wall
  double bat_radius = 0.075, bat_restitution = 0.80;
  // What an impact has to move: bat, stylus and as much of the hand as gives way at once, kg. Infinite: it is
  // held fast.
  double bat_mass = std::numeric_limits<double>::infinity();
  double contact_s = 0.004;  // duration of a bat contact
  Flight flight = Flight::full;
  scene::ContactModel contact_model = scene::ContactModel::non_sticky;
  std::array<double, 2> serve_speed{2.0, 3.5};  // slowest and fastest, m/s
  MatchSettings match;

  bool operator==(const GameSettings&) const = default;
};

const scene::SettingSchema& setting_schema();
GameSettings game_settings(const scene::SettingValues& values);
// Of a scene that comes from anywhere. Throws std::invalid_argument where its payload is not as the schema
// has it; scene::from_payload() says so beforehand.
GameSettings game_settings(const scene::SceneDescription& scene);
// Settings that a person can begin with: slow serves; a match of twenty where nobody has set their speed.
void ease_for_a_person(scene::SettingValues& values);
// Fills what the scene says of the game: the bat on the stylus, the bodies, the payload.
void describe(const scene::SettingValues& values, scene::SceneDescription& scene);

}  // namespace palpate::applications::pingpong
