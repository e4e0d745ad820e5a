#include "palpate/transport/status_json.h"

namespace palpate::transport {

Json status_json(const ServerStatus& status) {
  Json json{{"uptime_s", status.uptime_s},
            {"application", status.application},
            {"failure", status.failure.empty() ? Json() : Json(status.failure)},
            {"loops", Json::array()},
            {"clients", Json::array()}};
  for (const auto& loop : status.loops)
    json["loops"].push_back(
        {{"name", loop.name},
         {"rate_hz", loop.rate_hz},
         {"ticks", loop.ticks},
         {"overruns", loop.overruns},
         {"missed", loop.missed},
         {"late_us", {{"p50", loop.late_p50_us}, {"p99", loop.late_p99_us}, {"max", loop.late_max_us}}},
         {"busy_us", {{"p99", loop.busy_p99_us}}},
         {"late_octaves_from_16_ns", loop.late_octaves},
         {"condition", loop.forces_text()},
         {"limits_n",
          loop.peak_n > 0.0 ? Json{{"peak", loop.peak_n}, {"continuous", loop.continuous_n}} : Json()},
         {"outages", loop.trips},
         {"forces", loop.forces ? Json{{"state", device::name_of(loop.forces->state)},
                                       {"fault", device::name_of(loop.forces->fault)},
                                       {"culprit", loop.culprit}}
                                : Json()}});
  for (const auto& client : status.clients) {
    const auto& f = client.figures;
    Json words = Json::array(), health = Json::array();
    for (const auto& condition : f.conditions) {
      words.push_back(condition.words);
      health.push_back({{"code", device::name_of(condition.code)},
                        {"severity", device::name_of(device::severity_of(condition.code))},
                        {"age_s", condition.age_s}});
    }
    json["clients"].push_back(
        {{"name", client.name},
         {"role", role_name(client.role)},
         {"frames", f.frames},
         {"late", f.late},
         {"lost", f.lost},
         {"rate_hz", f.rate_hz},
         {"round_trip_us", {{"median", f.round_trip_median_us}, {"p99", f.round_trip_p99_us}}},
         {"clock_offset_s", f.clock_offset_s},
         {"clock_uncertainty_us", f.clock_uncertainty_us},
         {"conditions", std::move(words)},
         {"health", std::move(health)}});
  }
  json["service"] = {{"requests", status.requests}, {"published", status.published},
                     {"syncs", status.syncs},       {"controls", status.controls},
                     {"rejected", status.rejected}, {"turned_away", status.rejected_connections},
                     {"unsent", status.unsent}};
  json["recording"] = Json();
  if (const auto& r = status.recording)
    json["recording"] = {{"seconds", r->seconds}, {"dropped", r->dropped}, {"ended", r->ended}};
  return json;
}

}  // namespace palpate::transport
