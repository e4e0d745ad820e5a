#include "palpate/evaluation/studies/flights_study.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "palpate/core/csv.h"
#include "palpate/core/statistics.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/physics/flight_file.h"

namespace palpate::evaluation::studies {
namespace {

namespace fs = std::filesystem;

// Recorded balls come at about 180 Hz with gaps of up to two frames: nearer than this counts as "at" a
// horizon.
constexpr double kNearest_s = 0.006;
constexpr double kSameTable_m = 0.03;  // a bounce further from its set's table was elsewhere: floor, frame
// A bounce of which less was seen on one side says where it was, and little about its speed.
constexpr double kSeenForRestitution_s = 0.100;
// Recorded bounces have 0.92 to 0.95, and the flights used here 0.925; docs/theory/ball-flight.md.
constexpr double kTableRestitution = 0.925;
const Vector3 kUp = Vector3::UnitZ();

physics::BallModel model_of(const FlightMode& mode) {
  physics::BallModel model = mode.air ? physics::BallModel() : physics::BallModel::paper();
  model.gravity = -9.81 * kUp;
  return model;
}

// The moment of the first impact, which no simulation foresees; the end of the recording without one.
double played_until(const RecordedFlight& flight) {
  for (const auto& jump : flight.jumps)
    if (!physics::bounced_on_resting_surface(jump, kUp)) return jump.time;
  return flight.seen.back().time;
}

std::vector<const physics::VelocityJump*> bounces_of(const RecordedFlight& flight) {
  std::vector<const physics::VelocityJump*> bounces;
  for (const auto& jump : flight.jumps)
    if (physics::bounced_on_resting_surface(jump, kUp)) bounces.push_back(&jump);
  return bounces;
}

std::set<std::string> sets_of(const std::vector<RecordedFlight>& flights) {
  std::set<std::string> sets;
  for (const auto& flight : flights) sets.insert(flight.set);
  return sets;
}

Json horizons_json(const std::vector<const Told*>& told) {
  Json list = Json::array();
  for (const int at : kKeyHorizons_ms) {
    const auto h = static_cast<std::size_t>(at / kHorizonStep_ms - 1);
    std::vector<double> errors;
    for (const auto* one : told)
      if (std::isfinite(one->error_mm[h])) errors.push_back(one->error_mm[h]);
    if (errors.empty()) continue;
    list.push_back({{"horizon_ms", at},
                    {"median_mm", quantile(errors, 0.5)},
                    {"p90_mm", quantile(errors, 0.9)},
                    {"flights", errors.size()}});
  }
  return list;
}

Curve curve_over(const std::string& figure, const FlightMode& mode, const std::vector<const Told*>& told) {
  Curve curve{figure, std::string(mode.label), "horizon_ms", "error_mm", {}};
  for (std::size_t h = 0; h < kHorizons; ++h) {
    std::vector<double> errors;
    for (const auto* one : told)
      if (std::isfinite(one->error_mm[h])) errors.push_back(one->error_mm[h]);
    if (!errors.empty()) curve.points.push_back({horizon_ms(h), summary_of(errors)});
  }
  return curve;
}

void add_bounces(StudyResult& study, const std::vector<RecordedFlight>& flights) {
  CsvWriter csv({"flight", "kind", "time_s", "x_m", "y_m", "z_m", "speed_before_m_s", "speed_after_m_s",
                 "normal_before_m_s", "restitution", "slide_kept", "gap_mm"});
  Json by_set;
  for (const auto& set : sets_of(flights)) {
    const auto table = table_of(flights, set);
    std::vector<double> restitution, approach, kept;
    int impacts = 0, elsewhere = 0, all = 0;
    for (const auto& flight : flights) {
      if (flight.set != set) continue;
      for (const auto& jump : flight.jumps) {
        const bool bounced = physics::bounced_on_resting_surface(jump, kUp);
        const bool on_table = bounced && std::abs(jump.place.z() - table.height) <= kSameTable_m;
        const Vector3 in = jump.before - kUp.dot(jump.before) * kUp,
                      out = jump.after - kUp.dot(jump.after) * kUp;
        const double slide = in.squaredNorm() > 0.0 ? in.dot(out) / in.squaredNorm() : kNoValue;
        all += on_table;
        impacts += !bounced;
        elsewhere += bounced && !on_table;
        if (on_table && jump.seen_s >= kSeenForRestitution_s) {
          restitution.push_back(physics::restitution_of(jump, kUp));
          approach.push_back(-kUp.dot(jump.before));
          kept.push_back(slide);
        }
        csv.row(std::vector<std::string>{
            flight.name,
            on_table  ? "table"
            : bounced ? "elsewhere"
                      : "blow",
            number_text(jump.time), number_text(jump.place.x()), number_text(jump.place.y()),
            number_text(jump.place.z()), number_text(jump.before.norm()), number_text(jump.after.norm()),
            number_text(-kUp.dot(jump.before)),
            on_table ? number_text(physics::restitution_of(jump, kUp)) : "",
            on_table ? number_text(slide) : "", number_text(mm_from_metres(jump.gap))});
      }
    }
    Json json{{"bounces", all}, {"told", restitution.size()}, {"blows", impacts}, {"elsewhere", elsewhere}};
    if (!restitution.empty()) {
      json["table_height_m"] = table.height;
      json["restitution"] = {{"median", quantile(restitution, 0.5)},
                             {"p10", quantile(restitution, 0.1)},
                             {"p90", quantile(restitution, 0.9)},
                             {"sd", number_or_null(summary_of(restitution).sd)}};
      json["approach_m_s"] = {{"median", quantile(approach, 0.5)},
                              {"least", *std::min_element(approach.begin(), approach.end())},
                              {"most", *std::max_element(approach.begin(), approach.end())}};
      json["slide_kept_median"] = quantile(kept, 0.5);
      json["each"] = {{"restitution", restitution}, {"approach_m_s", approach}};
      study.lines.push_back(
          fmt::format("{}: {}, restitution {:.3f} (p10 {:.3f}, p90 {:.3f}) at {:.1f} m/s; {}", set,
                      counted(restitution.size(), "bounce"), quantile(restitution, 0.5),
                      quantile(restitution, 0.1), quantile(restitution, 0.9), quantile(approach, 0.5),
                      counted(static_cast<std::size_t>(impacts), "blow")));
    }
    by_set[set] = json;
  }
  study.values["bounces"] = by_set;
  study.files.emplace_back("bounces.csv", csv.content());
}

// The flight whose error in full mode at 300 ms is the middle one of its set, for a picture.
void add_examples(StudyResult& study, const std::vector<RecordedFlight>& flights,
                  const std::vector<std::vector<Told>>& told) {
  constexpr std::size_t kAt = 300 / kHorizonStep_ms - 1;
  Json examples = Json::array();
  for (const auto& set : sets_of(flights)) {
    std::vector<std::pair<double, std::size_t>> errors;
    for (std::size_t i = 0; i < flights.size(); ++i)
      if (flights[i].set == set && std::isfinite(told[1][i].error_mm[kAt]))
        errors.emplace_back(told[1][i].error_mm[kAt], i);
    if (errors.empty()) continue;
    std::sort(errors.begin(), errors.end());
    const std::size_t i = errors[errors.size() / 2].second;
    const Vector3 start = flights[i].seen.front().position;
    Vector3 along = flights[i].seen.back().position - start;
    for (const auto& ball : flights[i].seen)  // the way it was shot, not where it ended
      if (ball.time - flights[i].seen.front().time <= kFitWindow_s) along = ball.position - start;
    along -= kUp.dot(along) * kUp;
    if (along.norm() > 0.0) along.normalize();
    const auto path = [&](const std::vector<physics::SeenBall>& balls) {
      Json x = Json::array(), y = Json::array();
      for (const auto& ball : balls) {
        if (ball.time > played_until(flights[i])) break;
        x.push_back(along.dot(ball.position - start));
        y.push_back(kUp.dot(ball.position));
      }
      return Json{{"x_m", x}, {"z_m", y}};
    };
    Json example{{"flight", flights[i].name}, {"seen", path(flights[i].seen)}};
    for (std::size_t m = 0; m < 3; ++m)
      example[std::string(kFlightModes[m].name)] = path(told[m][i].simulated);
    examples.push_back(example);
  }
  study.values["examples"] = examples;
}

}  // namespace

Expected<std::vector<RecordedFlight>> read_flights(const FlightsOptions& options) {
  std::error_code ignored;
  if (!fs::is_directory(options.data, ignored))
    return wrong_use("study flights: {} is not a folder; --data expects one with *.csv flights",
                     options.data.string());
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(options.data, ignored))
    if (entry.path().extension() == ".csv") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  if (files.empty())
    return wrong_use("study flights: {} holds no *.csv flight; --data expects a folder with some",
                     options.data.string());
  std::vector<Expected<RecordedFlight>> slots(files.size());
  auto settings = options.repeats;
  if (settings.progress)
    settings.progress = [done = options.repeats.progress](double share) { done(0.3 * share); };
  repeat(files.size(), settings, [&](std::size_t i) {
    auto seen = physics::read_flight(files[i]);
    if (!seen) {
      slots[i] = tl::unexpected(seen.error());
      return;
    }
    RecordedFlight flight{files[i].stem().string(), files[i].stem().string(), std::move(*seen), {}};
    const auto end = flight.set.find_last_not_of("0123456789_");
    if (end != std::string::npos) flight.set.resize(end + 1);
    flight.jumps = physics::find_velocity_jumps(-9.81 * kUp, flight.seen);
    slots[i] = std::move(flight);
  });
  std::vector<RecordedFlight> flights;
  for (auto& slot : slots) {
    if (!slot) return tl::unexpected(slot.error());
    flights.push_back(std::move(*slot));
  }
  return flights;
}

TableHeight table_of(const std::vector<RecordedFlight>& flights, std::string_view set) {
  std::vector<double> heights;
  for (const auto& flight : flights)
    if (flight.set == set)
      for (const auto* bounce : bounces_of(flight)) heights.push_back(bounce->place.z());
  if (heights.empty()) return {};
  return {quantile(heights, 0.5), static_cast<int>(heights.size())};
}

Expected<Told> tell_flight(const RecordedFlight& flight, const FlightMode& mode, const TableHeight& table) {
  const auto model = model_of(mode);
  physics::BouncePlane plane;
  plane.point = table.height * kUp;
  plane.normal = kUp;
  plane.law = {kTableRestitution, mode.rubs ? physics::Bounce().friction : 0.0};
  const std::span<const physics::BouncePlane> planes(&plane, table.bounces > 0 ? 1 : 0);
  const double start = flight.seen.front().time, end = played_until(flight);
  std::vector<physics::SeenBall> window, whole;
  for (const auto& ball : flight.seen) {
    if (ball.time <= start + kFitWindow_s) window.push_back(ball);
    if (ball.time <= end) whole.push_back(ball);
  }
  Told told;
  if (mode.spin_known) {
    const auto fit = physics::fit_flight_and_spin(model, planes, whole);
    if (!fit) return refused("{}: {}", flight.name, fit.error().message);
    told.spin = fit->state.spin;
  }
  const auto fit = physics::fit_flight(model, planes, window, told.spin);
  if (!fit) return refused("{}: {}", flight.name, fit.error().message);
  physics::BallState ball = fit->state;
  for (std::size_t i = 0; i < flight.seen.size(); ++i) {
    physics::advance(model, planes, ball,
                     flight.seen[i].time - (i > 0 ? flight.seen[i - 1].time : fit->time));
    told.simulated.push_back({flight.seen[i].time, ball.position});
  }
  for (std::size_t h = 0; h < kHorizons; ++h) {
    const double t = start + kFitWindow_s + 1e-3 * horizon_ms(h);
    const auto nearest = std::min_element(
        flight.seen.begin(), flight.seen.end(),
        [&](const auto& a, const auto& b) { return std::abs(a.time - t) < std::abs(b.time - t); });
    const bool seen = std::abs(nearest->time - t) <= kNearest_s && nearest->time <= end;
    const auto i = static_cast<std::size_t>(nearest - flight.seen.begin());
    told.error_mm.push_back(seen ? mm_from_metres((told.simulated[i].position - nearest->position).norm())
                                 : kNoValue);
  }
  return told;
}

Expected<StudyResult> study_flights(const FlightsOptions& options) {
  const auto flights = read_flights(options);
  if (!flights) return tl::unexpected(flights.error());
  std::map<std::string, TableHeight> tables;
  for (const auto& set : sets_of(*flights)) tables[set] = table_of(*flights, set);
  const std::size_t n = flights->size();
  std::vector<Expected<Told>> slots(kFlightModes.size() * n);
  auto settings = options.repeats;
  if (settings.progress)
    settings.progress = [done = options.repeats.progress](double share) { done(0.3 + 0.7 * share); };
  repeat(slots.size(), settings, [&](std::size_t k) {
    const auto& flight = (*flights)[k % n];
    slots[k] = tell_flight(flight, kFlightModes[k / n], tables.at(flight.set));
  });
  std::vector<std::vector<Told>> told(kFlightModes.size());
  for (std::size_t k = 0; k < slots.size(); ++k) {
    if (!slots[k]) return tl::unexpected(slots[k].error());
    told[k / n].push_back(std::move(*slots[k]));
  }

  StudyResult study;
  study.name = "flights";
  CsvWriter csv({"mode", "flight", "error_100_mm", "error_300_mm", "error_500_mm", "spin_x_rad_s",
                 "spin_y_rad_s", "spin_z_rad_s"});
  for (std::size_t m = 0; m < kFlightModes.size(); ++m) {
    const auto& mode = kFlightModes[m];
    std::vector<const Told*> all;
    std::map<std::string, std::vector<const Told*>> sets;
    for (std::size_t i = 0; i < n; ++i) {
      const auto& one = told[m][i];
      all.push_back(&one);
      sets[(*flights)[i].set].push_back(&one);
      std::vector<std::string> row{std::string(mode.name), (*flights)[i].name};
      for (const int at : kKeyHorizons_ms) {
        const double e = one.error_mm[static_cast<std::size_t>(at / kHorizonStep_ms - 1)];
        row.push_back(std::isfinite(e) ? number_text(e) : "");
      }
      for (const double w : one.spin) row.push_back(number_text(w));
      csv.row(row);
    }
    Json by_set;
    study.curves.push_back(curve_over("all sets", mode, all));
    for (const auto& [name, of_set] : sets) {
      by_set[name] = {{"horizons", horizons_json(of_set)}};
      study.curves.push_back(curve_over(name, mode, of_set));
    }
    const Json horizons = horizons_json(all);
    study.values[std::string(mode.name)] = {{"horizons", horizons}, {"sets", by_set}};
    if (m > 2) continue;
    for (const auto& h : horizons)
      study.lines.push_back(fmt::format("{:22} +{} ms  median {:6.1f} mm  p90 {:6.1f} mm  of {}", mode.name,
                                        h["horizon_ms"].get<int>(), h["median_mm"].get<double>(),
                                        h["p90_mm"].get<double>(),
                                        counted(h["flights"].get<std::size_t>(), "flight")));
  }
  if (study.values["full"]["horizons"].empty())
    return refused("study flights: no flight in {} lasts {} ms, which is what the first horizon needs",
                   options.data.string(), 1e3 * kFitWindow_s + kKeyHorizons_ms[0]);
  study.values["flights"] = n;
  study.files.emplace_back("errors.csv", csv.content());
  add_bounces(study, *flights);
  add_examples(study, *flights, told);
  study.page = flights_page(study);
  return study;
}

}  // namespace palpate::evaluation::studies
