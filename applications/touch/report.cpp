#include "applications/touch/report.h"

#include <algorithm>
#include <cmath>

#include "applications/touch/record.h"

namespace palpate::applications::touch {
namespace {

constexpr double kLiftedOff_s = 0.005;  // without contact that long: another touch

// touch.csv, column by column.
struct Contact {
  std::vector<double> time, force, sideways, depth, sliding, x, z;  // s, N, N, mm, 0 or 1, m, m

  explicit Contact(const CsvTable& touch)
      : time(figures::column(touch, "time_s")),
        force(figures::column(touch, "force_n")),
        sideways(figures::column(touch, "tangential_n")),
        depth(figures::column(touch, "depth_mm")),
        sliding(figures::column(touch, "sliding")),
        x(figures::column(touch, "tip_x_m")),
        z(figures::column(touch, "tip_z_m")) {}
};

struct Span {
  double from, to, zero;  // s; the plot's time counts from `zero`
};

// The rows of a span, with a gap of not a number where the surface was left: the time as "time_s", and columns under
// their names.
Json over_contacts(const std::vector<double>& time, const Span& span,
                   const std::vector<std::pair<const char*, const std::vector<double>*>>& columns) {
  std::vector<double> at;
  std::vector<std::vector<double>> values(columns.size());
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (time[i] < span.from || time[i] > span.to) continue;
    const bool lifted = i > 0 && time[i] - time[i - 1] > kLiftedOff_s;
    if (lifted) at.push_back(NAN);
    at.push_back(time[i] - span.zero);
    for (std::size_t k = 0; k < columns.size(); ++k) {
      if (lifted) values[k].push_back(NAN);
      values[k].push_back((*columns[k].second)[i]);
    }
  }
  Json part{{"time_s", at}};
  for (std::size_t k = 0; k < columns.size(); ++k) part[columns[k].first] = values[k];
  return part;
}

// The moment in which friction gave way after it had held longest.
double slip_to_show(const std::vector<double>& time, const std::vector<double>& sliding) {
  double best = time.front(), longest = 0.0, since = time.front();
  for (std::size_t i = 1; i < time.size(); ++i) {
    if (time[i] - time[i - 1] > kLiftedOff_s || sliding[i - 1] > 0.5) since = time[i];
    if (sliding[i] > 0.5 && sliding[i - 1] < 0.5 && time[i] - since > longest) {
      longest = time[i] - since;
      best = time[i];
    }
  }
  return best;
}

Json around_a_slip(const Contact& contact) {
  const double slip = slip_to_show(contact.time, contact.sliding);
  std::vector<double> normal(contact.force.size());
  for (std::size_t i = 0; i < normal.size(); ++i)
    normal[i] = std::sqrt(
        std::max(0.0, contact.force[i] * contact.force[i] - contact.sideways[i] * contact.sideways[i]));
  return over_contacts(contact.time, {slip - 0.5, slip + 0.5, slip},
                       {{"sideways_n", &contact.sideways}, {"normal_n", &normal}});
}

Json path_from_above(const Contact& contact) {
  constexpr std::size_t kEvery = 5;  // 5 ms: the hand moves less than a millimetre
  Json path;
  for (const char* kind : {"held", "slid"}) path[kind] = {{"x_m", Json::array()}, {"z_m", Json::array()}};
  if (contact.x.empty() || contact.z.empty()) return path;
  for (std::size_t i = 0; i < contact.x.size(); i += kEvery) {
    Json& kind = path[contact.sliding[i] > 0.5 ? "slid" : "held"];
    kind["x_m"].push_back(contact.x[i]);
    kind["z_m"].push_back(contact.z[i]);
  }
  return path;
}

}  // namespace

scene::PlayReport play_report(const figures::PlayFolder& play) {
  scene::PlayReport report;
  report.data["contact"] = nullptr;
  const CsvTable* touch = play.raw(kTouchTable);
  if (touch == nullptr || !figures::has_columns(*touch, {"time_s", "force_n", "tangential_n", "depth_mm",
                                                         "speed_mm_s", "sliding"}))
    return report;
  const Contact contact(*touch);
  const Span all{contact.time.front(), contact.time.back(), contact.time.front()};
  report.data["contact"] = over_contacts(
      contact.time, all,
      {{"force_n", &contact.force}, {"sideways_n", &contact.sideways}, {"depth_mm", &contact.depth}});
  report.data["slip"] = around_a_slip(contact);
  report.data["path"] = path_from_above(contact);
  return report;
}

}  // namespace palpate::applications::touch
