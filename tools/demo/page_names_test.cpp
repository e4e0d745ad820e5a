// The templates of the demo's page and of the applications' parts name what the report holds.
#include <gtest/gtest.h>

#include <regex>
#include <set>

#include "applications/pingpong/specification.h"
#include "applications/touch/specification.h"
#include "palpate/evaluation/report/page.h"
#include "tools/demo/demo_report.h"
#include "tools/demo/play_folder_for_tests.h"

namespace palpate::tools::demo {
namespace {

const scene::ApplicationRegistry kBoth{applications::pingpong::specification(),
                                       applications::touch::specification()};

class PageNames : public PlayFolderTest {
 protected:
  // A summary with all that the program writes, on two hosts, with two eyes.
  void write_everything(const std::string& application, int missed_ticks, double spin_us) {
    write_raw();
    write_network();
    Json all = Json::parse(read_file(folder_ / "summary.json").value());
    all.merge_patch(Json::parse(R"({"command": "palpate demo",
      "arm": {"stylus_error_to_truth_deg": 0.1},
      "registration": {"right_eye": {"world_px_rms": 0.2, "tip_px_rms": 0.4}, "disparity": {"ball_px_rms": 0.1}},
      "rally": {"serves": 24, "returned": 20, "longest": 3},
      "touch": {"contact_s": 11.5, "of_s": 30.0, "touches": 4, "slips": 17, "force_n": {"mean": 1.4},
        "depth_mm": {"mean": 1, "max": 2}, "friction": {"median": 0.3}, "unsettled": 2},
      "force": {"peak_limited_ticks": 1},
      "made": {"version": "0.1.0", "commit": "3d8d93f1", "compiler": "Clang 14", "options": "Release", "date": "2026-11-28T16:00:00Z",
        "processor": "of a test", "cores": 2, "kernel": "Linux 6.1", "system": "Debian", "load_before": 0.4, "load_after": 2.1,
        "renderer": "llvmpipe", "scheduling": "SCHED_FIFO priority 80"},
      "realtime": {"overlay": {"frames": 270, "late": 3, "pose_from": {"none": 2}, "world_px_rms": 0.1, "tip_px_rms_in_time": 0.2, "tip_px_rms_late": 3},
        "force": {"lost_impulse_rel": 0.001, "machine_stalls": 2, "longest_machine_stall_ms": 7.5,
                  "outages_in_machine_stalls": 1, "trips_in_machine_stalls": 0}, "own_game": ["6 of 12 serves returned"], "headset": {"frames": 272, "with_picture": 257, "rate_hz": 90, "losses": 0, "age_ms": {"median": 90}}, "predicted": {"tip": {"shown": {"rms_mm": 0.6}, "registered": {"rms_mm": 9}}}, "photon_to_photon": {"median_ms": 60, "p99_ms": 70, "instrument_error_ms": 0.5},
        "haptic": {"ticks": 9991, "missed_in_a_row": 5}}})"));
    all["application"] = application;
    if (application == "another") all.erase("command");
    all["realtime"]["haptic"]["missed"] = missed_ticks;
    all["realtime"]["haptic"]["jitter_us"] = {{"p50", spin_us}, {"p99", 2 * spin_us}, {"max", 2000}};
    write("summary.json", all.dump());
    write("video.mp4", "film");
    write("pictures/a.png", "picture");
    write("raw/ball.csv", "time_s,x_m,y_m,z_m\n0,0,1,2\n");
    write(
        "raw/touch.csv",
        "time_s,force_n,tangential_n,depth_mm,speed_mm_s,sliding,tip_x_m,tip_z_m\n1.000,5,3,2,1,0,0.1,1.7\n");
    write("raw/realtime_sync.csv", "time_s,offset_s,offset_error_us,uncertainty_us\n0.6,5,1,2\n1.6,5,1,2\n");
    write("raw/realtime_jitter.csv",
          "loop,late_from_us,late_to_us,ticks\nhaptic,96,128,31\nphysics,24.576,32.768,9000\n");
    write("raw/realtime_photons.csv",
          "exposure_ms,transfer_ms,wait_ms,draw_ms,scan_out_ms,total_ms\n1,2,3,4,5,15\n");
    write("raw/realtime_poses.csv", "time_s,late,world_px,tip_px\n1.5,0,0.1,0.2\n2.5,1,0.3,4.5\n");
  }

  // Of its page, the conditions that the report held; each is checked to be written without a complaint.
  void add_found(std::set<std::string>& found) {
    evaluation::report::PageTemplates templates;
    const auto report = demo_report(folder_, kBoth, templates);
    ASSERT_TRUE(report) << report.error().message;
    const auto page = evaluation::report::page_of(*report, templates, folder_);
    ASSERT_TRUE(page) << page.error().message;
    found.insert(page->found.begin(), page->found.end());
  }
};

void add_conditions(std::set<std::string>& names, const figures::PageFiles& files) {
  static const std::regex condition(R"(\{\{[#^]\s*([^}]*?)\s*\}\})");
  for (const auto& file : files) {
    const std::string name(file.name), text(file.text);
    if (!name.ends_with(".html") || name.starts_with("stud") || name == "flights.html" ||
        name == "psychometric.html")
      continue;
    for (std::sregex_iterator at(text.begin(), text.end(), condition), end; at != end; ++at)
      names.insert((*at)[1]);
  }
}

// A condition that no report ever holds is a name misspelt. A value's name that is not held is an error anyway
// (Templates.ANameThatIsNotThereIsAnErrorUnlessItIsACondition).
TEST_F(PageNames, EveryConditionIsHeldBySomeReport) {
  std::set<std::string> names, found;
  add_conditions(names, evaluation::report::report_files());
  for (const auto& spec : kBoth.specs()) add_conditions(names, spec.page);
  for (const char* application : {"pingpong", "touch", "another"})
    for (const int missed : {0, 5}) {
      write_everything(application, missed, missed == 0 ? 0.01 : 50.0);
      add_found(found);
    }
  // What only runs without a fault hold, counts of seconds in which something went wrong, and sections that stand as data.
  write("raw/realtime_frames.csv",
        "time_s,round_trip_us,late,lost,repeated,out_of_order\n0.5,100,1,0,0,0\n1.5,120,0,0,0,0\n");
  write("raw/realtime_loops.csv",
        "time_s,haptic_ticks,physics_ticks,haptic_overruns,haptic_missed,physics_overruns,physics_missed\n"
        "0.5,500,500,0,1,0,0\n1.5,1500,1500,0,0,0,0\n");
  std::string trips = "time_s,tick,cause,who,away_s,returned,lost_n_s,file,outage_s,kind\n";
  for (int i = 0; i < 50; ++i)
    trips += fmt::format("{},{},late tick,,0.01,{},0.001,,0.01,{}\n", i, 1000 * i + 1, i % 2,
                         i % 3 == 0 ? "trip" : "outage");
  write("raw/realtime_trips.csv", trips);
  write("raw/arm_guidance.csv", "poses,guided_mm,chosen_mm\n30,0.1,0.3\n");
  add_found(found);
  evaluation::report::PageTemplates templates;
  figures::Plot plot{.title = "p", .series = {{.name = "s", .x = {1}, .y = {1}}}, .caption = "c"};
  plot.levels = {{.at = 1.0}};
  const Json sections{
      {"kind", "sections"},
      {"sections", evaluation::report::json_of(std::vector<figures::Section>{
                       {"t",
                        "a",
                        {"words", std::vector<figures::Figure>{{"l", "v", "b", figures::Verdict::holds}},
                         std::vector<figures::Plot>{plot}, figures::Table{{"h"}, {{"r"}}}}}})}};
  const auto page = evaluation::report::page_of(sections, templates, folder_);
  ASSERT_TRUE(page) << page.error().message;
  found.insert(page->found.begin(), page->found.end());
  for (const auto& name : names) EXPECT_TRUE(found.contains(name)) << "{{#" << name << "}}";
}

}  // namespace
}  // namespace palpate::tools::demo
