#include "palpate/haptics/trip_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/core/log.h"
#include "palpate/time/real_time.h"

namespace palpate::haptics {
namespace {

constexpr Log kLog("physics");
constexpr auto kLook = std::chrono::milliseconds(20);
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr auto kAfter = std::chrono::milliseconds(500);
constexpr auto kLogApart = std::chrono::seconds(1);

template <typename Numbers>
void put(std::vector<std::string>& row, const Numbers& v) {
  for (const double number : v) row.push_back(number_text(number));
}

}  // namespace

std::string trip_csv(const HapticCondition& trip, const std::vector<HapticRecord>& records) {
  std::vector<std::string> columns{"time_s",        "state",         "fault",        "tip_x_m",   "tip_y_m",
                                   "tip_z_m",       "tip_speed_m_s", "asked_x_n",    "asked_y_n", "asked_z_n",
                                   "commanded_x_n", "commanded_y_n", "commanded_z_n"};
  const Eigen::Index joints = records.empty() ? 3 : records.back().joints.size();
  for (Eigen::Index j = 1; j <= joints; ++j) columns.push_back(fmt::format("reading_{}_rad", j));
  CsvWriter csv(columns);
  for (const auto& record : records) {
    std::vector<std::string> row{fmt::format("{:.6f}", record.time.seconds()),
                                 std::string(name_of(record.state)), std::string(name_of(record.fault))};
    put(row, record.tip);
    row.push_back(number_text(record.speed));
    put(row, record.requested);
    put(row, record.commanded);
    device::JointVector readings = device::JointVector::filled(joints, kNone);
    const Eigen::Index read = std::min(joints, record.joints.size());
    readings.head(read) = record.joints.head(read);
    put(row, readings);
    csv.row(row);
  }
  return fmt::format("# tripped: {} in tick {}; tip and asked in World, commanded in ArmBase\n{}",
                     name_of(trip.trip_fault), trip.trip_tick, csv.content());
}

TripWriter::TripWriter(const HapticLoop& loop, std::filesystem::path folder, Instant<PhysicsClock> begun)
    : loop_(loop), folder_(std::move(folder)), begun_(begun), log_(loop) {
  thread_ = std::thread([this] { watch(); });
}

void TripWriter::stop() {
  stopping_.store(true);
  if (thread_.joinable()) thread_.join();
}

void TripWriter::watch() {
  name_and_pin_thread("palpate-trips", -1);
  while (!stopping_.load()) {
    look(false);
    std::this_thread::sleep_for(kLook);
  }
  look(true);
}

void TripWriter::look(bool at_the_end) {
  const auto now = std::chrono::steady_clock::now();
  const HapticCondition condition = loop_.condition();
  if (condition.trips != seen_) {
    const std::uint64_t fresh = condition.trips - seen_;
    seen_ = condition.trips;
    const bool available =
        !open_ && written_ < kMostFiles && (written_ == 0 || now - last_written_ >= kLeastApart);
    left_out_ += available ? fresh - 1 : fresh;
    if (available) {
      pending_ = condition;
      noticed_ = now;
      open_ = true;
    }
  }
  log_is_newer_ |= log_.look();
  if (open_ && (at_the_end || now - noticed_ >= kAfter)) write(pending_, condition.ticks);
  write_log(at_the_end);
}

void TripWriter::write_log(bool at_the_end) {
  const auto now = std::chrono::steady_clock::now();
  if (at_the_end ? log_.trips().empty() : !log_is_newer_ || now - log_written_ < kLogApart) return;
  log_is_newer_ = false;
  log_written_ = now;
  const auto path = folder_ / "realtime_trips.csv";
  if (auto done = write_file(path, trips_csv(log_.trips(), begun_, loop_)); !done && at_the_end)
    kLog.warning("{}", done.error().message);
}

void TripWriter::write(const HapticCondition& trip, std::uint64_t until) {
  const std::string who = loop_.name_of(trip.trip_culprit);
  const std::string why = std::string(name_of(trip.trip_fault)) + (who.empty() ? "" : ": " + who);
  open_ = false;
  last_written_ = std::chrono::steady_clock::now();
  const auto path = folder_ / fmt::format("trip_{}.csv", written_.load() + 1);
  if (auto done = write_file(path, trip_csv(trip, loop_.records_before(until))); !done) {
    ++left_out_;
    if (!heals(trip.trip_fault))
      kLog.warning("forces tripped ({}); the last seconds are lost: {}", why, done.error().message);
    return;
  }
  ++written_;
  log_.set_file(trip.trip_tick, path.filename().string());
  log_is_newer_ = true;
  if (!heals(trip.trip_fault))
    kLog.warning("forces tripped ({}); the last seconds are in {}", why, path.string());
}

}  // namespace palpate::haptics
