#include "tools/demo/demo_report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>

#include "palpate/core/json.h"
#include "palpate/core/random.h"
#include "tests/scratch_folder.h"
#include "tools/demo/swing_for_tests.h"

namespace palpate::tools::demo {
namespace {
namespace fs = std::filesystem;

const scene::ApplicationRegistry kApplications = registry_for_tests();

// A folder as a demo leaves it, filled with numbers that look like a run but stand for nothing.
class DemoReport : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* keep = std::getenv("PALPATE_KEEP_REPORT");  // a folder to look at afterwards
    folder_ = keep != nullptr ? fs::path(keep) : scratch_.path();
    fs::create_directories(folder_ / "raw");
    write("summary.json", summary().dump());
  }

  void write(const std::string& name, const std::string& content) {
    ASSERT_TRUE(write_file(folder_ / name, content).has_value()) << name;
  }

  static Json summary() {
    return Json::parse(R"({"seed": 1, "application": "swing",
      "arm": {"error_to_truth_mean_mm": 0.105, "heldout_mean_mm": 0.19, "uncorrected_mean_mm": 3.05, "one_pass_error_to_truth_mm": 1.31,
        "uncorrected_error_to_truth_mm": 3.02, "alternating_error_to_truth_mm": 0.98, "eq7_error_to_truth_mm": 0.86, "samples": 70,
        "true_tip_one_pass_error_to_truth_mm": 0.61, "true_tip_alternating_error_to_truth_mm": 0.14,
        "true_tip_eq7_error_to_truth_mm": 0.10, "true_tip_joint_error_to_truth_mm": 0.10},
      "pivot": {"error_to_truth_mm": 0.97}, "hand_eye": {"error_to_truth_mm": 0.41, "rotation_error_deg": 0.05}, "camera": {"rms_px": 0.21},
      "registration": {"world_px_rms": 0.27, "world_px_p95": 0.49, "world_px_rms_tracker_only": 0.91, "tip_px_rms": 0.55, "tip_px_p95": 2.31,
        "own_estimate_px_rms": 0.2468},
      "exchange": {"frames": 900, "late": 4, "answers": {"exact": 12, "interpolated": 880, "extrapolated": 8, "too_old": 0}},
      "swing": {"passes": 24},
      "force": {"peak_n": 7.9, "limit_n": 8.5, "limited_ticks": 3, "lost_impulse_rel": 0.002, "impulse_error_rel_max": 3e-13},
      "realtime": {"exchange": {"round_trip_us": {"median": 118, "p99": 402}, "frames": 300, "late": 0},
        "sync": {"offset_error_us_p99": 14, "uncertainty_us": 31}, "haptic": {"rate_hz": 1000, "overruns": 0, "jitter_us": {"p50": 4, "p99": 37, "max": 210}},
        "physics": {"rate_hz": 1000}, "graphics": {"rate_hz": 27.4}}})");
  }

  void write_raw() {
    Random random(7, "report/synthetic");
    std::string errors = "method,pose,error_mm,x_mm,y_mm,z_mm,dx_mm,dy_mm,dz_mm\n";
    const std::pair<const char*, double> methods[] = {
        {"uncorrected", 1.75}, {"one-pass", 0.75}, {"alternating", 0.57}, {"eq7", 0.5}, {"joint", 0.06}};
    for (const auto& [name, sd] : methods) {
      for (int i = 0; i < 1000; ++i) {
        const double a = 0.13 * i, b = 0.031 * i, s = 209 * (std::cos(a) * 0.5 + 0.8);
        const double dx = sd * std::cos(a), dy = sd * std::sin(b),
                     dz = sd * std::sin(a) + random.normal(0.1 * sd);
        errors += fmt::format("{},{},{:.4f},{:.1f},{:.1f},{:.1f},{:.4f},{:.4f},{:.4f}\n", name, i,
                              std::hypot(dx, dy, dz), s * std::sin(b), 150 * std::sin(a), s * std::cos(b), dx,
                              dy, dz);
      }
    }
    write("raw/arm_errors.csv", errors);
    std::string guidance = "poses,guided_mm,chosen_mm\n";
    for (int i = 8; i <= 70; ++i)
      guidance += fmt::format("{},{:.4f},{:.4f}\n", i, 0.36 / std::sqrt(i), 0.5 / std::sqrt(i));
    write("raw/arm_guidance.csv", guidance);
    std::string pivot = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n";
    for (int i = 0; i < 600; ++i) {
      const double a = 0.21 * i, tilt = 0.9 * std::sqrt(i / 600.0);
      pivot += fmt::format("{:.2f},{:.3f},{:.3f},{:.3f},1,0,0,0\n", 0.01 * i,
                           118 * std::sin(tilt) * std::cos(a) + random.normal(0.3),
                           118 * std::cos(tilt) + random.normal(0.3), 118 * std::sin(tilt) * std::sin(a));
    }
    write("raw/pivot.csv", pivot);
    write("raw/lens.csv",
          "which,fx,fy,cx,cy,k1,k2,p1,p2,k3\nest,560.31,561.62,318.4,242.5,-0.2793,0.0881,0.00103,-0.00049,0."
          "0002\n"
          "true,560,561.5,318.7,242.1,-0.28,0.09,0.001,-0.0005,0\n");
    write("raw/surface.csv",
          "label,x_mm,y_mm,z_mm\ntable,-375,-1520,1800\ntable,375,-1520,1800\ntable,375,-1520,800\ntable,-"
          "375,-1520,800\n"
          "wall,-375,-1520,800\nwall,375,-1520,800\nwall,375,-920,800\nwall,-375,-920,800\n");
    std::string frames = "frame,mid_exposure_s,answer,late,world_px,tip_px,expected_world_px\n",
                swing = "time_s,x_m\n";
    for (int i = 0; i < 900; ++i) {
      frames += fmt::format("{},{:.4f},interpolated,0,{:.4f},{},0.25\n", i, 3.2 + i / 30.0,
                            std::abs(0.2 + random.normal(0.08)),
                            i % 50 == 7 ? "" : fmt::format("{:.4f}", std::abs(0.45 + random.normal(0.2))));
      swing += fmt::format("{:.4f},{:.4f}\n", i / 30.0, 0.1 * std::sin(i / 5.0));
    }
    write("raw/frames.csv", frames);
    write("raw/swing.csv", swing);
    std::string haptics = "time_s,force_x_n,force_y_n,force_z_n,asked_n,given_n\n";
    for (int hit = 0; hit < 20; ++hit) {
      const double peak = random.uniform(2.5, 9.2);
      for (int ms = -6; ms < 12; ++ms) {
        const double asked = ms > 0 && ms < 5 ? peak * std::sin(std::numbers::pi * ms / 5.0) : 0.0;
        haptics += fmt::format("{:.3f},0,0,{:.4f},{:.4f},{:.4f}\n", 1.5 * hit + 1 + ms / 1000.0, asked, asked,
                               std::min(asked, 8.5));
      }
    }
    write("raw/haptics.csv", haptics);
    std::string trips = "frame,time_s,round_trip_us\n", sync = "time_s,offset_error_us,uncertainty_us\n";
    for (int i = 0; i < 300; ++i)
      trips += fmt::format("{},{:.3f},{:.1f}\n", i, i / 30.0, 95 + 25 * std::exp(random.normal(0.7)));
    for (int i = 0; i < 100; ++i)
      sync +=
          fmt::format("{:.2f},{:.2f},{:.2f}\n", 0.1 * i, random.normal(5.0), 28 + 30 * std::exp(-0.1 * i));
    write("raw/realtime_frames.csv", trips);
    write("raw/realtime_sync.csv", sync);
  }

  // Ten seconds on two hosts, the cable out from 4 s to 7 s.
  void write_network() {
    Json with_network = summary();
    with_network["realtime"]["network"] =
        Json::parse(R"({"encrypted": true, "physics_address": "tcp://there:1",
      "graphics_place": "here", "cut_at_s": 4.0, "cut_for_s": 3.0, "gone_after_s": 0.6, "back_after_s": 0.3,
      "replies_after_s": 0.35, "client_forgotten_after_s": 0.9, "answers_after_s": 1.2, "unsent": 60, "lost": 12,
      "repeated": 0, "out_of_order": 0, "cut": {"frames": 90, "late": 89, "clock_inside_share": 1.0}})");
    write("summary.json", with_network.dump());
    Random random(8, "report/network");
    std::string trips = "frame,time_s,round_trip_us,late\n", sync = "time_s,offset_error_us,uncertainty_us\n",
                loops = "time_s,haptic_ticks,physics_ticks\n";
    for (int i = 0; i < 300; ++i) {
      const double t = i / 30.0;
      const bool out = t > 4.0 && t < 7.35;
      trips +=
          fmt::format("{},{:.3f},{},{}\n", i, t,
                      out ? "" : fmt::format("{:.1f}", 95 + 25 * std::exp(random.normal(0.7))), out ? 1 : 0);
      sync += fmt::format("{:.3f},{:.2f},{:.2f}\n", t, random.normal(5.0), out ? 30 + 10 * (t - 4) : 30.0);
      loops += fmt::format("{:.3f},{},{}\n", t, 1000 + std::lround(1000 * t), 1000 + std::lround(1000 * t));
    }
    write("raw/realtime_frames.csv", trips);
    write("raw/realtime_sync.csv", sync);
    write("raw/realtime_loops.csv", loops);
  }

  ScratchFolder scratch_;
  fs::path folder_;
};

TEST_F(DemoReport, IsWrittenFromTheSummaryAlone) {
  ASSERT_TRUE(write_demo_report(folder_, kApplications).has_value());
  const std::string page = read_file(folder_ / "report.html").value();
  EXPECT_NE(page.find("0.105\u00a0mm"), std::string::npos);
  EXPECT_EQ(page.find("<video"), std::string::npos);
  EXPECT_EQ(page.find("Overlay error, frame by frame"), std::string::npos);
}

TEST_F(DemoReport, ShowsTheSystemsOwnEstimateOfItsErrorBesideTheTruth) {
  write_raw();
  const std::string page = demo_report(folder_, kApplications)->html();
  EXPECT_NE(page.find("0.247\u00a0px"), std::string::npos);
  EXPECT_NE(page.find("\"name\":\"real scene, as the system estimates it itself\""), std::string::npos);
}

TEST_F(DemoReport, LeavesOutSectionsWithoutFigures) {
  write("summary.json", R"({"seed": 3})");
  ASSERT_TRUE(write_demo_report(folder_, kApplications).has_value());
  const std::string page = read_file(folder_ / "report.html").value();
  EXPECT_EQ(page.find("Against the wall clock"), std::string::npos);
  EXPECT_NE(page.find("Seed 3."), std::string::npos);
}

TEST_F(DemoReport, ShowsVideoAndPicturesWithTheirCaptions) {
  Json with_caption = summary();
  with_caption["pictures"] = {{"a.png", "The serve & the wall"}};
  write("summary.json", with_caption.dump());
  fs::create_directories(folder_ / "pictures");
  write("pictures/a.png", "picture A");
  write("video.mp4", "film");
  write("poster.png", "poster");
  const std::string page = demo_report(folder_, kApplications)->html();
  EXPECT_NE(page.find("data:image/png;base64," + evaluation::report::base64("picture A")), std::string::npos);
  EXPECT_NE(page.find("<figcaption>The serve &amp; the wall</figcaption>"), std::string::npos);
  EXPECT_NE(page.find("data:video/mp4;base64," + evaluation::report::base64("film")), std::string::npos);
  EXPECT_NE(page.find("poster=\"data:image/png;base64," + evaluation::report::base64("poster")),
            std::string::npos);
}

TEST_F(DemoReport, ShowsThePictureFromTheSideAfterThreeOthers) {
  write("summary.json", summary().dump());
  fs::create_directories(folder_ / "pictures");
  for (const std::string name : {"01", "02", "03", "04", "05", "outside"})
    write("pictures/" + name + ".png", "picture " + name);
  const std::string page = demo_report(folder_, kApplications)->html();
  const auto at = [&](const std::string& name) {
    return page.find(evaluation::report::base64("picture " + name));
  };
  EXPECT_LT(at("01"), at("03"));
  EXPECT_LT(at("03"), at("outside"));
  EXPECT_NE(at("outside"), std::string::npos);
  EXPECT_EQ(at("04"), std::string::npos);
}

TEST_F(DemoReport, HasTheApplicationsWordsFiguresSectionsAndTables) {
  write_raw();
  const std::string page = demo_report(folder_, kApplications)->html();
  for (const char* told :
       {"A swing", "calibrate everything, watch a weight, and hold", "The weight is not there. In this run",
        "How it swung", "To and fro.", "<b>falls short</b> at most 3", "raw/swing.csv",
        "the weight, picture by picture", "Strongest force the hand felt"})
    EXPECT_NE(page.find(told), std::string::npos) << told;
  const auto exchange = page.find("Two servers, one moment"), swing = page.find("To and fro."),
             real_time = page.find("118");
  EXPECT_LT(exchange, swing);
  EXPECT_NE(real_time, std::string::npos);
}

// A page can be made where the application of the folder is not known, and where it has no part in pages.
TEST_F(DemoReport, OfAnApplicationWithoutAPartIsPlain) {
  write_raw();
  const std::string unknown = demo_report(folder_, scene::ApplicationRegistry())->html();
  scene::ApplicationRegistry without_report;
  auto spec = swing_for_tests();
  spec.report = nullptr;
  without_report.add(spec);
  const std::string silent = demo_report(folder_, without_report)->html();
  for (const std::string& page : {unknown, silent}) {
    EXPECT_NE(page.find("Palpate: swing"), std::string::npos);
    EXPECT_NE(page.find("Peak force"), std::string::npos);
    EXPECT_EQ(page.find("To and fro."), std::string::npos);
  }
  EXPECT_EQ(unknown.find("raw/swing.csv"), std::string::npos);
  EXPECT_NE(silent.find("raw/swing.csv"), std::string::npos);
}

TEST_F(DemoReport, HoldsThePeakForceAgainstTheLimitOfTheArmThatPlayed) {
  Json told = summary();
  told["force"]["limit_n"] = 3.3;
  write("summary.json", told.dump());
  EXPECT_NE(demo_report(folder_, kApplications)->html().find("<b>falls short</b> at most 3.3 N"),
            std::string::npos);
  told["force"].erase("limit_n");
  write("summary.json", told.dump());
  EXPECT_EQ(demo_report(folder_, kApplications)->html().find("the arm&#39;s limit"), std::string::npos);
}

TEST_F(DemoReport, CallsADisparityByTheBodysName) {
  Json told = summary();
  told["registration"]["disparity"] = {{"world_px_rms", 0.1}, {"weight_px_rms", 0.4}, {"weight_px_p95", 0.8}};
  write("summary.json", told.dump());
  const std::string page = demo_report(folder_, kApplications)->html();
  EXPECT_NE(page.find("Virtual weight&#39;s disparity"), std::string::npos);
  EXPECT_EQ(page.find("Virtual world"), std::string::npos);
}

TEST_F(DemoReport, RefusesAMissingOrBrokenSummaryAndABrokenTable) {
  EXPECT_EQ(write_demo_report(folder_ / "nowhere", kApplications).error().exit_code(), 2);
  write("raw/frames.csv", "a,b\n1\n");
  EXPECT_NE(write_demo_report(folder_, kApplications).error().message.find("frames.csv:2"),
            std::string::npos);
  fs::remove(folder_ / "raw/frames.csv");
  write("summary.json", "[1]");
  EXPECT_NE(write_demo_report(folder_, kApplications).error().message.find("not a JSON object"),
            std::string::npos);
}

// 0.36 / sqrt(30) is 0.5 / sqrt(57.9).
TEST_F(DemoReport, TellsWhatThirtyGuidedPosesAreWorth) {
  write_raw();
  EXPECT_NE(demo_report(folder_, kApplications)->html().find("Thirty of them are worth 58 of"),
            std::string::npos);
}

TEST_F(DemoReport, IsTheSameForTheSameFolder) {
  write_raw();
  EXPECT_EQ(demo_report(folder_, kApplications)->html(), demo_report(folder_, kApplications)->html());
}

// The figures the page draws: counts of half octaves as they stand in the file, whatever is quicker than
// 0.128 us in one column, and how much the counts grew in each second.
TEST_F(DemoReport, ShowsTheInstrumentsOfTheLoops) {
  write("raw/realtime_jitter.csv",
        "loop,late_from_us,late_to_us,ticks\nhaptic,0.008,0.016,7000\nhaptic,0.064,0.096,1000\n"
        "haptic,96,128,31\nphysics,24.576,32.768,9000\n");
  write("raw/realtime_loops.csv",
        "time_s,haptic_ticks,physics_ticks,haptic_overruns,haptic_missed,physics_overruns,physics_missed\n"
        "-0.5,500,500,4,9,0,0\n0.5,1500,1500,4,9,0,0\n1.5,2500,2500,6,12,1,0\n2.5,3500,3500,6,12,1,0\n");
  const std::string page = demo_report(folder_, kApplications)->html();
  EXPECT_NE(page.find("\"y\":[0.5,8000,8000,31,31,0.5]"), std::string::npos);
  EXPECT_NE(page.find("\"x\":[24.58,24.58,32.77,32.77]"), std::string::npos);
  EXPECT_NE(page.find("\"name\":\"haptic: overrun\""), std::string::npos);
  EXPECT_NE(page.find("\"y\":[0,3,0]"), std::string::npos);  // haptic: left out
}

TEST_F(DemoReport, SaysSoWhereNothingWentWrong) {
  write("raw/realtime_frames.csv",
        "time_s,round_trip_us,late,lost,repeated,out_of_order\n0.5,100,0,0,0,0\n1.5,120,0,0,0,0\n");
  write("raw/realtime_loops.csv",
        "time_s,haptic_ticks,physics_ticks,haptic_overruns,haptic_missed,physics_overruns,physics_missed\n"
        "0.5,500,500,0,0,0,0\n1.5,1500,1500,0,0,0,0\n");
  const std::string page = demo_report(folder_, kApplications)->html();
  EXPECT_NE(page.find("No answer came late"), std::string::npos);
  EXPECT_NE(page.find("No tick of either loop"), std::string::npos);
  EXPECT_EQ(page.find("Ticks of the loops that went wrong"), std::string::npos);
}

TEST_F(DemoReport, ShowsThePicturesOfTheRealTimeLegOnceTheyHaveSettledAndLateOnesApart) {
  write("raw/realtime_poses.csv",
        "time_s,late,pose_source,world_px,tip_px\n0.5,0,refined,9.5,9.5\n1.5,0,refined,0.125,0.25\n"
        "2.5,1,refined,0.375,4.5\n3.5,0,refined,0.5,\n");
  const std::string page = demo_report(folder_, kApplications)->html();
  EXPECT_NE(page.find("Overlay error in real time"), std::string::npos);
  EXPECT_NE(page.find("\"y\":[0.125,0.375,0.5]"), std::string::npos);
  EXPECT_NE(page.find("\"name\":\"stylus tip, answer late\""), std::string::npos);
  EXPECT_NE(page.find("\"y\":[4.5]"), std::string::npos);
  EXPECT_NE(page.find("\"y\":[0.25]"), std::string::npos);
}

// A loop that spins is late by nanoseconds or by a stall: neither is told without the other, nor without what
// was left out.
TEST_F(DemoReport, TellsHowLateHapticTicksBeganAndHowManyNeverDidInOneStatement) {
  Json told = summary();
  const auto page_with = [&](const char* haptic) {
    told["realtime"]["haptic"] = Json::parse(haptic);
    write("summary.json", told.dump());
    return demo_report(folder_, kApplications)->html();
  };
  const std::string spinning = page_with(
      R"({"rate_hz": 998, "ticks": 10137, "overruns": 4, "missed": 9, "missed_in_a_row": 5,
        "jitter_us": {"p50": 0.012, "p99": 0.024, "max": 15161.817}})");
  EXPECT_NE(
      spinning.find("Haptic ticks began late by</div><div class=\"value\">at most 15.2\u00a0ms</div>"
                    "<div class=\"bar\">99 % of them by less than 1\u00a0\u00b5s; 9 of 10146 left out, up to "
                    "5 in a row<"),
      std::string::npos);
  EXPECT_NE(spinning.find("watches the clock until a tick is due"), std::string::npos);
  EXPECT_EQ(spinning.find("0.024"), std::string::npos);
  EXPECT_EQ(spinning.find("Haptic jitter"), std::string::npos);
  const std::string sleeping = page_with(
      R"({"rate_hz": 1000, "ticks": 10000, "missed": 0, "missed_in_a_row": 0,
        "jitter_us": {"p50": 54, "p99": 81.5, "max": 612}})");
  EXPECT_NE(sleeping.find("at most 612\u00a0\u00b5s</div><div class=\"bar\">99 % of them by at most "
                          "81.5\u00a0\u00b5s; none left out<"),
            std::string::npos);
  EXPECT_EQ(sleeping.find("watches the clock"), std::string::npos);
}

TEST_F(DemoReport, SaysOfTwoEyesThatThereAreTwo) {
  Json told = summary();
  told["registration"]["right_eye"] = {{"world_px_rms", 0.12}};
  write("video.mp4", "film");
  const std::string one = demo_report(folder_, kApplications)->html();
  EXPECT_NE(one.find("The player&#39;s view: the camera&#39;s picture, undistorted"), std::string::npos);
  EXPECT_NE(one.find("through a camera worn on the head"), std::string::npos);
  write("summary.json", told.dump());
  const std::string two = demo_report(folder_, kApplications)->html();
  EXPECT_NE(two.find("The player&#39;s view, left eye and right eye side by side: each camera&#39;s picture"),
            std::string::npos);
  EXPECT_NE(two.find("through two cameras worn on the head, one for each eye"), std::string::npos);
  EXPECT_EQ(two.find("the camera&#39;s picture"), std::string::npos);
}

TEST_F(DemoReport, TellsOfTheCableThatWasPulled) {
  write_network();
  const std::string page = demo_report(folder_, kApplications)->html();
  EXPECT_NE(page.find("Two hosts, and a cable pulled"), std::string::npos);
  EXPECT_NE(page.find("asked the physics server at tcp://there:1, encrypted"), std::string::npos);
  EXPECT_NE(page.find("<td>4.60 s</td><td>0.60 s after the pull</td>"), std::string::npos);
  EXPECT_NE(page.find("<td>7.35 s</td><td>0.35 s after the plug</td>"), std::string::npos);
  EXPECT_NE(page.find("<b>falls short</b> at most 1 s"), std::string::npos);  // answers_after_s is 1.2 s
}

#ifdef PALPATE_CHROMIUM
TEST_F(DemoReport, IsDrawnByABrowserWithoutANetwork) {
  write_raw();
  write_network();
  ASSERT_TRUE(write_demo_report(folder_, kApplications).has_value());
  const std::string command =
      fmt::format(PALPATE_CHROMIUM
                  " --headless --no-sandbox --disable-gpu --disable-dev-shm-usage --host-resolver-rules='MAP "
                  "* ~NOTFOUND' "
                  "--user-data-dir='{0}/profile' "
                  "--virtual-time-budget=20000 --dump-dom 'file://{0}/report.html' 2> /dev/null",
                  folder_.string());
  std::FILE* pipe = ::popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string dom;
  char buffer[65536];
  for (std::size_t n; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) dom.append(buffer, n);
  ::pclose(pipe);
  fs::remove_all(folder_ / "profile");
  // page.js counts what it has drawn: 10 plots and 2 clouds; an error in drawing would leave the mark out.
  EXPECT_NE(dom.find("data-drawn=\"12\""), std::string::npos);
  EXPECT_NE(dom.find("class=\"main-svg\""), std::string::npos);
}
#endif

}  // namespace
}  // namespace palpate::tools::demo
