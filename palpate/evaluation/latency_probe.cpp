#include "palpate/evaluation/latency_probe.h"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/core/log.h"
#include "palpate/core/statistics.h"

namespace palpate::evaluation {
namespace {

constexpr Log kLog("graphics");
constexpr std::size_t kMostKept = 100'000;  // pictures in the figures: an hour's
constexpr Duration kMostUnsure = std::chrono::milliseconds(1);
constexpr std::uint64_t kImagesBeforeWord = 90;  // without a timecode in any, somebody should hear of it

double in_ms(Duration d) { return 1e3 * to_seconds(d); }

}  // namespace

Expected<std::unique_ptr<LatencyProbe>> LatencyProbe::open(std::unique_ptr<device::OpenedDisplay> display,
                                                           const LatencySettings& settings,
                                                           const MonotonicClock<GraphicsClock>& clock,
                                                           const std::filesystem::path& out) {
  std::unique_ptr<LatencyProbe> probe(new LatencyProbe(settings, clock));
  if (display) {
    probe->display_ = std::move(display);
    probe->thread_ = std::thread([raw = probe.get()] { raw->show_time(); });
  }
  if (!out.empty()) {
    auto rows = CsvFile::begin(out / "realtime_photons.csv",
                               {"camera_frame", "presented_monotonic_ns", "exposure_ms", "transfer_ms",
                                "wait_ms", "draw_ms", "scan_out_ms", "total_ms", "unsure_ms"});
    if (!rows) return tl::unexpected(rows.error());
    probe->rows_.emplace(std::move(*rows));
  }
  return probe;
}

LatencyProbe::~LatencyProbe() {
  done_ = true;
  if (thread_.joinable()) thread_.join();
}

void LatencyProbe::show_time() {
  pthread_setname_np(pthread_self(), "palpate-strip");
  MonotonicClock<GraphicsClock> machine;
  for (auto next = machine.now(); !done_.load(std::memory_order_relaxed);
       next = std::max(next + std::chrono::milliseconds(1), machine.now())) {
    machine.sleep_until(next);
    const Duration code = clock_.now().since_epoch % device::kTimecodeCycle;
    const auto at = clock_.from_monotonic(display_->device().show_timecode(code));
    const std::lock_guard lock(mutex_);
    shown_.emplace_back(at, code);
  }
}

void LatencyProbe::look(const server::graphics::GraphicsServer& server,
                        const server::graphics::FrameRecord& frame, Instant<GraphicsClock> presented) {
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [at, code] : shown_) meter_.timecode_shown(at, code);
    shown_.clear();
  }
  const auto delay = meter_.look(server.finished_image(), frame, presented);
  if (!delay) {
    if (!told_ && meter_.read() == 0 && meter_.images() >= kImagesBeforeWord) {
      told_ = true;
      kLog.write(LogLevel::warning, delay.error().message);
    }
    return;
  }
  if (delay->unsure > kMostUnsure) {
    ++unsure_;
    return;
  }
  if (delays_.size() < kMostKept) delays_.push_back(*delay);
  if (!rows_) return;
  std::vector<std::string> row{fmt::format("{}", delay->camera_frame),
                               fmt::format("{}", clock_.to_monotonic(presented))};
  for (const Duration d : {delay->exposure, delay->transfer, delay->wait, delay->draw, delay->scan_out,
                           delay->total(), delay->unsure})
    row.push_back(fmt::format("{:.4f}", in_ms(d)));
  rows_->row(row);
}

Json LatencyProbe::figures() const {
  ErrorSummary total, unsure, exposure, transfer, wait, draw, scan_out;
  for (const auto& delay : delays_) {
    total.add(in_ms(delay.total()));
    unsure.add(in_ms(delay.unsure));
    exposure.add(in_ms(delay.exposure));
    transfer.add(in_ms(delay.transfer));
    wait.add(in_ms(delay.wait));
    draw.add(in_ms(delay.draw));
    scan_out.add(in_ms(delay.scan_out));
  }
  Json json = {{"images", meter_.images()}, {"strips_read", meter_.read()}, {"strips_unsure", unsure_}};
  if (delays_.empty()) {
    json["trouble"] = meter_.trouble();
    return json;
  }
  json["median_ms"] = total.quantile(0.5);
  json["p99_ms"] = total.quantile(0.99);
  json["mean_ms"] = total.mean();
  json["unsure_ms_median"] = unsure.quantile(0.5);
  json["parts"] = {{"exposure_ms", exposure.mean()},
                   {"transfer_ms", transfer.mean()},
                   {"wait_ms", wait.mean()},
                   {"draw_ms", draw.mean()},
                   {"scan_out_ms", scan_out.mean()}};
  return json;
}

Expected<Json> evaluate_latency(const std::filesystem::path& photons, const std::filesystem::path& exposures,
                                Duration scan_out) {
  auto measured = read_csv(photons);
  if (!measured) return tl::unexpected(measured.error());
  auto taken = read_csv(exposures);
  if (!taken) return tl::unexpected(taken.error());
  std::vector<std::size_t> at;
  for (const auto* name : {"camera_frame", "presented_monotonic_ns", "total_ms"}) {
    const auto column = measured->require(name);
    if (!column) return tl::unexpected(column.error());
    at.push_back(*column);
  }
  const auto frame = taken->require("frame"), moment = taken->require("mid_exposure_monotonic_ns");
  if (!frame) return tl::unexpected(frame.error());
  if (!moment) return tl::unexpected(moment.error());
  std::map<std::uint64_t, double> mid_exposure;
  for (const auto& row : taken->rows) mid_exposure[static_cast<std::uint64_t>(row[*frame])] = row[*moment];
  auto header = measured->header;
  header.insert(header.end(), {"true_ms", "error_ms"});
  CsvWriter judged(header);
  ErrorSummary errors;
  double sum = 0.0;
  for (std::size_t i = 0; i < measured->rows.size(); ++i) {
    const auto& row = measured->rows[i];
    const auto known = mid_exposure.find(static_cast<std::uint64_t>(row[at[0]]));
    if (known == mid_exposure.end()) continue;
    const double truth = 1e-6 * (row[at[1]] - known->second) + in_ms(scan_out), error = row[at[2]] - truth;
    errors.add(std::abs(error));
    sum += error;
    auto cells = measured->text[i];
    cells.push_back(fmt::format("{:.4f}", truth));
    cells.push_back(fmt::format("{:.4f}", error));
    judged.row(cells);
  }
  if (auto done = write_file(photons, judged.content()); !done) return tl::unexpected(done.error());
  Json json = Json::object();
  if (errors.empty()) return json;
  json["instrument_error_ms"] = errors.quantile(0.99);
  json["instrument_error_max_ms"] = errors.maximum();
  json["instrument_error_mean_ms"] = sum / static_cast<double>(errors.count());
  return json;
}

}  // namespace palpate::evaluation
