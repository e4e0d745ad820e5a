// The report a demo ends with, written from what the demo left in its folder: summary.json, raw/*.csv,
// pictures, video. Its words are templates in share/report, its limits share/report/limits.toml.
//
// Files read, each of them optional but summary.json; a missing one leaves its part of the page out:
//   video.mp4, poster.png, pictures/*.png (in name order; captions from summary.json "pictures" {"name.png":
//   "..."}) raw/arm_errors.csv       method,pose,error_mm  and, for the cloud, x_mm,y_mm,z_mm (true tip),
//   dx_mm,dy_mm,dz_mm
//                            (estimate minus truth). Methods: uncorrected, one-pass, alternating, eq7, joint.
//   raw/pivot.csv            x_mm,y_mm,z_mm,... marker poses while the tip was held
//   raw/lens.csv             which(est|true),fx,fy,cx,cy,k1,k2,p1,p2,k3
//   raw/surface.csv          label,x_mm,y_mm,z_mm touched corners, four of each label in touching order, once
//                            or several times
//   raw/frames.csv           mid_exposure_s,world_px,tip_px,...
//   raw/haptics.csv          time_s,asked_n,given_n around the impacts
//   and what the application's part reads, its own tables among it
//   raw/realtime_frames.csv  time_s,round_trip_us,late,lost,repeated,out_of_order
//   raw/realtime_sync.csv    time_s,offset_error_us,uncertainty_us,offset_s
//   raw/realtime_trips.csv   time_s,tick,cause,who,away_s,returned,lost_n_s,file,outage_s,kind
//                            (haptics/trip_log.h), where there were any
//   raw/realtime_loops.csv   time_s and, of haptic_ and physics_ each, ticks,overruns,missed since the start
//   raw/realtime_jitter.csv  loop,late_from_us,late_to_us,ticks
//   summary.json "realtime/network" where the run was played on two hosts
//   (palpate/evaluation/outage_analysis.h)
// Keys of summary.json beyond those acceptance reads, shown where present: seed, command,
// arm {true_tip_one_pass_error_to_truth_mm, true_tip_alternating_..., true_tip_eq7_..., true_tip_joint_...,
// samples}, pivot {poses}, hand_eye {rotation_error_deg}, camera {rms_px}.
#pragma once

#include <filesystem>

#include "palpate/core/expected.h"
#include "palpate/evaluation/report/page.h"
#include "palpate/scene/application_registry.h"

namespace palpate::tools::demo {

// The report of a play's folder (docs/report.md). Its application is the one that summary.json names: `applications` has
// its part and its templates, which `templates` gets where it has none of that name yet. Errors: wrong use for a folder
// without a summary, for a broken table, and for limits or words that are none.
Expected<Json> demo_report(const std::filesystem::path& folder,
                           const scene::ApplicationRegistry& applications,
                           evaluation::report::PageTemplates& templates);

// folder/report.json, which is returned, and folder/report.html.
Expected<Json> write_demo_report(const std::filesystem::path& folder,
                                 const scene::ApplicationRegistry& applications,
                                 evaluation::report::PageTemplates templates = {});

}  // namespace palpate::tools::demo
