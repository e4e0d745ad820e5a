// Recorded ball flights beside the simulator: what the first 100 ms of a flight say about the rest of it.
//
// Place and velocity are fitted to the first 100 ms, then the ball is simulated; the error at a horizon,
// counted from the end of these 100 ms, is the distance to the place seen nearest to that moment. Modes
// differ in the air and in the spin they are told; the ball, its drag and its bounce are those the program
// ships, the same for every recording. Where the table lies is found from the bounces (velocity_jump.h) of a
// set, which are also what restitution is told from. Recordings have z upwards, SI. Errors: wrong use for a
// folder without flights or a file that is none; refused where no flight is long enough.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "palpate/evaluation/studies/study.h"
#include "palpate/physics/velocity_jump.h"

namespace palpate::evaluation::studies {

struct FlightsOptions {
  std::filesystem::path data;  // folder with *.csv
  RepeatSettings repeats;
};

Expected<StudyResult> study_flights(const FlightsOptions& options);

// Inside of the study, for its page and its tests.

struct RecordedFlight {
  std::string name, set;  // set: the name without its trailing number
  std::vector<physics::SeenBall> seen;
  std::vector<physics::VelocityJump> jumps;
};

// All *.csv of a folder, in the order of their names, with their jumps.
Expected<std::vector<RecordedFlight>> read_flights(const FlightsOptions& options);

struct TableHeight {
  double height = 0.0;  // of the ball's centre at a bounce, m; without a bounce there is no table
  int bounces = 0;
};
// The median over the bounces of flights of this set.
TableHeight table_of(const std::vector<RecordedFlight>& flights, std::string_view set);

struct FlightMode {
  std::string_view name, label;
  bool air = true, rubs = true, spin_known = false;
};
// "paper" and "full" differ in the air alone: what the table does is the same. "full_with_fitted_spin" is
// told the spin that the whole flight up to an impact shows, which nobody has in play: a bound of what spin
// is worth.
inline constexpr std::array<FlightMode, 4> kFlightModes{
    {{"paper", "paper: gravity alone", false, true, false},
     {"full", "full: drag and lift, spin unknown", true, true, false},
     {"full_with_fitted_spin", "full, spin from the whole flight", true, true, true},
     {"paper_without_friction", "paper, table without friction", false, false, false}}};
inline constexpr double kFitWindow_s = 0.100;
inline constexpr std::array kKeyHorizons_ms{100, 300, 500};
inline constexpr int kHorizonStep_ms = 25, kLastHorizon_ms = 600;
inline constexpr std::size_t kHorizons = kLastHorizon_ms / kHorizonStep_ms;
inline constexpr double horizon_ms(std::size_t h) { return kHorizonStep_ms * (static_cast<double>(h) + 1.0); }

// The flight as one mode tells it: errors at each horizon (mm; not a number where the recording has no ball
// there, or the ball was struck before), and the places simulated at the times seen.
struct Told {
  std::vector<double> error_mm;
  std::vector<physics::SeenBall> simulated;
  Vector3 spin = Vector3::Zero();
};
Expected<Told> tell_flight(const RecordedFlight& flight, const FlightMode& mode, const TableHeight& table);

// From the study's curves and values: horizons, rows, sets and bounces, as its page lists them.
Json flights_page(const StudyResult& study);

}  // namespace palpate::evaluation::studies
