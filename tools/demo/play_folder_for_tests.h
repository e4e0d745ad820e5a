// For tests: a folder as a demo leaves it, filled with numbers that look like a run but stand for nothing.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "palpate/core/file.h"
#include "palpate/core/json.h"
#include "palpate/core/random.h"
#include "tests/scratch_folder.h"

namespace palpate::tools::demo {

class PlayFolderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* keep = std::getenv("PALPATE_KEEP_REPORT");  // a folder to look at afterwards
    folder_ = keep != nullptr ? std::filesystem::path(keep) : scratch_.path();
    std::filesystem::create_directories(folder_ / "raw");
    write("summary.json", summary().dump());
  }

  void write(const std::string& name, const std::string& content) {
    std::filesystem::create_directories((folder_ / name).parent_path());
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
  std::filesystem::path folder_;
};

}  // namespace palpate::tools::demo
