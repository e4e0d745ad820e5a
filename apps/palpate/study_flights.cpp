// palpate study flights: recorded ball flights against the simulator.
#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <memory>

#include "apps/palpate/command.h"
#include "palpate/core/csv.h"
#include "palpate/core/json.h"
#include "palpate/core/units.h"
#include "palpate/physics/flight.h"
#include "palpate/physics/flight_file.h"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

constexpr double kFitWindow_s = 0.100;
constexpr std::array kHorizons_ms = {100, 300, 500};
// Recorded balls are about 180 Hz with gaps of up to two frames: a sample nearer than this counts as "at" a
// horizon.
constexpr double kNearest_s = 0.006;
constexpr double kBouncePlane_m = 0.760;  // height of the ball's centre at a bounce, of these recordings

struct Flight {
  std::string name, set;  // set: the name without its trailing number
  std::vector<SeenBall> balls;
};

Expected<Flight> flight_of(const fs::path& path) {
  auto balls = read_flight(path);
  if (!balls) return tl::unexpected(balls.error());
  Flight flight{path.stem().string(), path.stem().string(), std::move(*balls)};
  const auto end = flight.set.find_last_not_of("0123456789_");
  if (end != std::string::npos) flight.set.resize(end + 1);
  return flight;
}

// Errors at each horizon, m; NaN where the recording does not reach it.
Expected<std::array<double, kHorizons_ms.size()>> prediction_errors(const BallModel& model,
                                                                    const BouncePlane& table,
                                                                    const Flight& flight) {
  const std::span<const BouncePlane> planes(&table, 1);
  std::vector<SeenBall> window;
  for (const auto& ball : flight.balls) {
    if (ball.time <= flight.balls.front().time + kFitWindow_s) window.push_back(ball);
  }
  const auto fit = fit_flight(model, planes, window);
  if (!fit) return refused("{}: {}", flight.name, fit.error().message);
  std::array<double, kHorizons_ms.size()> errors{};
  for (std::size_t h = 0; h < kHorizons_ms.size(); ++h) {
    const double t = flight.balls.front().time + kFitWindow_s + 1e-3 * kHorizons_ms[h];
    const auto nearest = std::min_element(
        flight.balls.begin(), flight.balls.end(),
        [&](const auto& a, const auto& b) { return std::abs(a.time - t) < std::abs(b.time - t); });
    if (std::abs(nearest->time - t) > kNearest_s) {
      errors[h] = std::nan("");
      continue;
    }
    BallState ball = fit->state;
    advance(model, planes, ball, nearest->time - fit->time);
    errors[h] = (ball.position - nearest->position).norm();
  }
  return errors;
}

// Value below which the share `q` of the sorted values lies (linear between neighbours).
double quantile(const std::vector<double>& sorted, double q) {
  const double at = q * static_cast<double>(sorted.size() - 1);
  const auto i = static_cast<std::size_t>(at);
  const double next = sorted[std::min(i + 1, sorted.size() - 1)];
  return sorted[i] + (at - static_cast<double>(i)) * (next - sorted[i]);
}

Json horizons(std::array<std::vector<double>, kHorizons_ms.size()> errors) {
  Json list = Json::array();
  for (std::size_t h = 0; h < kHorizons_ms.size(); ++h) {
    auto& e = errors[h];
    if (e.empty()) continue;
    std::sort(e.begin(), e.end());
    list.push_back({{"horizon_ms", kHorizons_ms[h]},
                    {"median_mm", mm_from_metres(quantile(e, 0.5))},
                    {"p90_mm", mm_from_metres(quantile(e, 0.9))},
                    {"flights", e.size()}});
  }
  return list;
}

struct FlightsOptions {
  std::string data, out, json;
};

Expected<void> study_flights(const FlightsOptions& options) {
  if (options.data.empty())
    return wrong_use("study flights: --data names the folder of recorded flights (*.csv)");
  std::error_code ignored;
  if (!fs::is_directory(options.data, ignored)) {
    return wrong_use("study flights: {} is not a folder; --data expects one with *.csv flights",
                     options.data);
  }
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(options.data, ignored)) {
    if (entry.path().extension() == ".csv") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  if (files.empty()) return wrong_use("study flights: {} holds no *.csv flight", options.data);

  Json result;
  CsvWriter table({"mode", "flight", "error_100_mm", "error_300_mm", "error_500_mm"});
  // The first two differ in the air only: what the table does is taken from the recordings for both. The
  // third is the paper to the letter, whose table does not rub.
  for (const std::string mode : {"paper", "full", "paper_without_friction"}) {
    BallModel model = mode == "full" ? BallModel() : BallModel::paper();
    model.gravity = {0.0, 0.0, -9.81};  // these recordings have z upwards
    BouncePlane plane;
    plane.point = {0.0, 0.0, kBouncePlane_m};
    plane.normal = Vector3::UnitZ();
    plane.law = {0.925, mode == "paper_without_friction" ? 0.0 : Bounce().friction};
    std::array<std::vector<double>, kHorizons_ms.size()> all;
    std::map<std::string, std::array<std::vector<double>, kHorizons_ms.size()>> sets;
    for (const auto& file : files) {
      const auto flight = flight_of(file);
      if (!flight) return tl::unexpected(flight.error());
      const auto errors = prediction_errors(model, plane, *flight);
      if (!errors) return tl::unexpected(errors.error());
      std::vector<std::string> row{mode, flight->name};
      for (std::size_t h = 0; h < kHorizons_ms.size(); ++h) {
        const double e = (*errors)[h];
        row.push_back(std::isnan(e) ? "" : number_text(mm_from_metres(e)));
        if (std::isnan(e)) continue;
        all[h].push_back(e);
        sets[flight->set][h].push_back(e);
      }
      table.row(row);
    }
    Json by_set;
    for (const auto& [name, errors] : sets) by_set[name] = {{"horizons", horizons(errors)}};
    result[mode] = {{"horizons", horizons(all)}, {"sets", by_set}};
  }
  if (!options.out.empty()) {
    const fs::path out = options.out;
    if (auto done = make_folder(out); !done) return done;
    if (auto done = write_file(out / "flights.csv", table.content()); !done) return done;
    if (auto done = write_json(out / "flights.json", result); !done) return done;
  }
  if (!options.json.empty())
    if (auto done = write_json(options.json, result); !done) return done;
  for (const char* mode : {"paper", "full"}) {
    for (const auto& h : result[mode]["horizons"]) {
      fmt::print(stderr, "{:5}  +{} ms  median {:6.1f} mm  p90 {:6.1f} mm  of {} flights\n", mode,
                 h["horizon_ms"].get<int>(), h["median_mm"].get<double>(), h["p90_mm"].get<double>(),
                 h["flights"].get<int>());
    }
  }
  return {};
}

}  // namespace

void add_study_flights(CLI::App& study) {
  auto* flights = study.add_subcommand("flights", "Recorded ball flights against the simulator");
  auto options = std::make_shared<FlightsOptions>();
  flights->add_option("--data", options->data, "Folder of flights, CSV t_s,x_m,y_m,z_m with z upwards")
      ->required();
  flights->add_option("--out", options->out, "Folder for flights.csv and flights.json");
  flights->add_option("--json", options->json, "Result file, - for standard output");
  on(flights, [options] { return study_flights(*options); });
}

}  // namespace palpate::app
