#include "palpate/evaluation/outage_analysis.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace palpate::evaluation {
namespace {

// A table's columns by name.
class Columns {
 public:
  static Expected<Columns> of(const CsvTable& table, const std::vector<std::string>& names) {
    Columns columns(table);
    for (const auto& name : names) {
      const auto at = table.require(name);
      if (!at) return tl::unexpected(at.error());
      columns.at_[name] = *at;
    }
    return columns;
  }
  std::size_t rows() const { return table_->rows.size(); }
  // Not a number where the cell is empty.
  double at(std::size_t row, const std::string& name) const { return table_->rows[row][at_.at(name)]; }
  double time(std::size_t row) const { return at(row, "time_s"); }

  // The first row from `from` on of which `holds` is true; its time after `from`.
  template <typename Holds>
  std::optional<double> first(double from, double to, Holds holds) const {
    for (std::size_t i = 0; i < rows(); ++i)
      if (time(i) >= from && time(i) < to && holds(i)) return time(i) - from;
    return std::nullopt;
  }
  // How far a count went on between two moments.
  double gain(const std::string& name, double from, double to) const {
    double before = 0.0, last = 0.0;
    bool any = false;
    for (std::size_t i = 0; i < rows() && time(i) < to; ++i) {
      last = at(i, name);
      if (!any || time(i) < from) before = last;
      any = true;
    }
    return last - before;
  }

 private:
  explicit Columns(const CsvTable& table) : table_(&table) {}
  const CsvTable* table_;
  std::map<std::string, std::size_t> at_;
};

void put_figure(Json& json, const char* key, std::optional<double> value) {
  if (value) json[key] = *value;
}

std::optional<double> change_after(const NetworkRecords& records, double from, bool there) {
  for (const auto& change : records.server_there)
    if (change.time_s >= from && change.there == there) return change.time_s - from;
  return std::nullopt;
}

Json phase(const Columns& frames, const Columns& sync, const Columns& loops, double from, double to) {
  Json json;
  std::uint64_t drawn = 0, late = 0, inside = 0, compared = 0;
  double error = 0.0, stated = 0.0;
  for (std::size_t i = 0; i < frames.rows(); ++i) {
    if (frames.time(i) < from || frames.time(i) >= to) continue;
    ++drawn;
    late += frames.at(i, "late") != 0.0 ? 1 : 0;
  }
  for (std::size_t i = 0; i < sync.rows(); ++i) {
    if (sync.time(i) < from || sync.time(i) >= to) continue;
    ++compared;
    const double off = std::abs(sync.at(i, "offset_error_us")), sure = sync.at(i, "uncertainty_us");
    inside += off <= sure ? 1 : 0;
    error = std::max(error, off);
    stated = std::max(stated, sure);
  }
  json["frames"] = drawn;
  json["late"] = late;
  for (const std::string loop : {"haptic", "physics"})
    for (const std::string count : {"ticks", "overruns", "missed"})
      json[loop + "_" + count] =
          static_cast<std::int64_t>(std::llround(loops.gain(loop + "_" + count, from, to)));
  if (compared > 0) {
    json["clock_error_us_max"] = error;
    json["clock_uncertainty_us_max"] = stated;
    json["clock_inside_share"] = static_cast<double>(inside) / static_cast<double>(compared);
  }
  return json;
}

}  // namespace

Expected<Json> outage_analysis(const NetworkRecords& records) {
  const auto frames = Columns::of(
      records.frames, {"time_s", "round_trip_us", "late", "unsent", "lost", "repeated", "out_of_order"});
  if (!frames) return tl::unexpected(frames.error());
  const auto sync = Columns::of(records.sync, {"time_s", "offset_error_us", "uncertainty_us"});
  if (!sync) return tl::unexpected(sync.error());
  const auto loops =
      Columns::of(records.loops, {"time_s", "clients", "requests", "haptic_ticks", "haptic_overruns",
                                  "haptic_missed", "physics_ticks", "physics_overruns", "physics_missed"});
  if (!loops) return tl::unexpected(loops.error());
  const double pulled = records.pulled_s, plugged = records.plugged_s, end = 1e9;

  Json json;
  json["encrypted"] = records.encrypted;
  json["physics_address"] = records.physics_address;
  json["graphics_place"] = records.graphics_place;
  json["cut_at_s"] = pulled;
  json["cut_for_s"] = plugged - pulled;
  put_figure(json, "gone_after_s", change_after(records, pulled, false));
  put_figure(json, "back_after_s", change_after(records, plugged, true));
  put_figure(json, "replies_after_s",
             frames->first(plugged, end, [&](std::size_t i) { return frames->at(i, "late") == 0.0; }));
  const auto clients_before = [&](std::size_t i) { return i > 0 ? loops->at(i - 1, "clients") : 0.0; };
  put_figure(json, "client_forgotten_after_s", loops->first(pulled, plugged, [&](std::size_t i) {
    return loops->at(i, "clients") < clients_before(i);
  }));
  put_figure(json, "answers_after_s", loops->first(plugged, end, [&](std::size_t i) {
    return i > 0 && loops->at(i, "requests") > loops->at(i - 1, "requests");
  }));
  json["before"] = phase(*frames, *sync, *loops, 0.0, pulled);
  json["cut"] = phase(*frames, *sync, *loops, pulled, plugged);
  json["after"] = phase(*frames, *sync, *loops, plugged, end);
  for (const char* count : {"unsent", "lost", "repeated", "out_of_order"})
    json[count] = static_cast<std::int64_t>(std::llround(frames->gain(count, -end, end)));
  return json;
}

std::string network_events(const NetworkRecords& records) {
  std::vector<std::pair<double, std::string>> events{{records.pulled_s, "cable pulled"},
                                                     {records.plugged_s, "cable plugged in"}};
  for (const auto& change : records.server_there)
    events.emplace_back(change.time_s, change.there ? "physics server back" : "physics server gone");
  std::sort(events.begin(), events.end());
  CsvWriter csv({"time_s", "event"});
  for (const auto& [time, what] : events) csv.row(std::vector<std::string>{number_text(time), what});
  return csv.content();
}

}  // namespace palpate::evaluation
