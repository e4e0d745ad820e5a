#include "tools/demo/demo_report.h"

#include <gtest/gtest.h>

#include "tools/demo/play_folder_for_tests.h"
#include "tools/demo/swing_for_tests.h"

namespace palpate::tools::demo {
namespace {
namespace fs = std::filesystem;

const scene::ApplicationRegistry kApplications = registry_for_tests();

class DemoReport : public PlayFolderTest {
 protected:
  Json report(const scene::ApplicationRegistry& applications = kApplications) {
    evaluation::report::PageTemplates templates;
    const auto made = demo_report(folder_, applications, templates);
    EXPECT_TRUE(made) << made.error().message;
    return made.value_or(Json());
  }
  std::string page(const scene::ApplicationRegistry& applications = kApplications) {
    const auto done = write_demo_report(folder_, applications);
    EXPECT_TRUE(done) << done.error().message;
    const std::string html = read_file(folder_ / "report.html").value_or("");
    return html.substr(0, html.find("</main>"));  // without scripts
  }
  // Verdict of one judgement where a figure of the summary is another one.
  Json verdict(const char* judgement, const Json& change) {
    Json told = summary();
    told.merge_patch(change);
    write("summary.json", told.dump());
    return report()["judged"][judgement]["verdict"];
  }
};

TEST_F(DemoReport, HasTheFiguresOfTheSummaryWithLimitsAndVerdicts) {
  const Json made = report();
  EXPECT_EQ(made["summary"]["arm"]["samples"], 70);
  const Json& arm = made["judged"]["arm_error"];
  EXPECT_EQ(arm["value"], 0.105);
  EXPECT_EQ(arm["unit"], "mm");
  EXPECT_EQ(arm["limit"], 0.3) << "half of the paper's 0.86 mm is more";
  EXPECT_EQ(arm["verdict"], "holds");
  EXPECT_EQ(made["data"]["answers"]["interpolated"]["share"], 880.0 / 900.0);
}

TEST_F(DemoReport, AVerdictFlipsWhereTheFigureCrossesItsLimit) {
  EXPECT_EQ(verdict("arm_error", {{"arm", {{"eq7_error_to_truth_mm", 0.2}}}}), "falls short");
  EXPECT_EQ(verdict("world_overlay", {{"registration", {{"world_px_rms", 0.31}}}}), "falls short");
  EXPECT_EQ(verdict("world_overlay", {{"registration", {{"world_px_rms", 0.3}}}}), "holds");
  EXPECT_EQ(verdict("haptic_rate", {{"realtime", {{"haptic", {{"rate_hz", 989.0}}}}}}), "falls short");
  EXPECT_EQ(verdict("clocks", {{"realtime", {{"sync", {{"offset_error_us_p99", 51}}}}}}), "falls short");
  EXPECT_EQ(verdict("lost_impulse", {{"realtime", {{"force", {{"lost_impulse_rel", 0.02}}}}}}),
            "falls short");
}

TEST_F(DemoReport, HoldsThePeakForceAgainstTheLimitOfTheArmThatPlayed) {
  EXPECT_EQ(verdict("peak_force", {{"force", {{"limit_n", 8.5}}}}), "holds");
  EXPECT_EQ(verdict("peak_force", {{"force", {{"limit_n", 3.3}}}}), "falls short");
  EXPECT_EQ(verdict("peak_force", {{"force", {{"limit_n", nullptr}}}}), nullptr);
}

TEST_F(DemoReport, IsWrittenFromTheSummaryAlone) {
  const std::string html = page();
  EXPECT_NE(html.find("0.105\u00a0mm"), std::string::npos);
  EXPECT_EQ(html.find("<video"), std::string::npos);
  EXPECT_EQ(html.find("<figure class=\"cloud\""), std::string::npos);
  EXPECT_EQ(Json::parse(read_file(folder_ / "report.json").value())["kind"], "demo");
}

// Parts of a page of which nothing is known are not there, and no name of a template is without a value.
TEST_F(DemoReport, LeavesOutSectionsWithoutFigures) {
  write("summary.json", R"({"seed": 3})");
  const std::string html = page();
  for (const char* anchor : {"arm", "camera", "overlay", "exchange", "forces", "real-time", "two-hosts"})
    EXPECT_EQ(html.find(fmt::format("<h2 id=\"{}\">", anchor)), std::string::npos) << anchor;
  for (const char* anchor : {"see", "how"})
    EXPECT_NE(html.find(fmt::format("<h2 id=\"{}\">", anchor)), std::string::npos) << anchor;
}

// Each part of the summary alone, and all without it.
TEST_F(DemoReport, NeedsNoPartOfTheSummaryForAnother) {
  const Json all = summary();
  for (const auto& [key, part] : all.items()) {
    write("summary.json", Json{{key, part}}.dump());
    page();
    Json rest = all;
    rest.erase(key);
    write("summary.json", rest.dump());
    page();
  }
}

TEST_F(DemoReport, ShowsVideoAndPicturesWithTheirCaptions) {
  Json with_caption = summary();
  with_caption["pictures"] = {{"a.png", "The serve & the wall"}};
  write("summary.json", with_caption.dump());
  write("pictures/a.png", "picture A");
  write("video.mp4", "film");
  write("poster.png", "poster");
  const Json made = report();
  EXPECT_EQ(made["video"], "video.mp4");
  EXPECT_EQ(made["pictures"][0][0]["caption"], "The serve & the wall");
  const std::string html = page();
  for (const char* carried :
       {"src=\"data:video/mp4;base64,ZmlsbQ==\"", "poster=\"data:image/png;base64,cG9zdGVy\"",
        "src=\"data:image/png;base64,cGljdHVyZSBB\"", "The serve &amp; the wall"})
    EXPECT_NE(html.find(carried), std::string::npos) << carried;
}

// Early in a play nothing has been scored yet: what is late shows more, events first, the view from the side last.
TEST_F(DemoReport, ShowsTheLastEventFirstAndNoPictureTwice) {
  const auto shown = [this] {
    std::string names;
    const Json rows = report()["pictures"];
    for (const auto& row : rows)
      for (const auto& picture : row)
        names += fs::path(picture["file"].get<std::string>()).stem().string() + ' ';
    return names;
  };
  for (const std::string name : {"01-hit", "02-play", "03-hit", "04-play", "05-play", "06-play", "outside"})
    write("pictures/" + name + ".png", name);
  EXPECT_EQ(report()["poster"], nullptr) << "without a film";
  EXPECT_EQ(shown(), "03-hit 05-play 06-play outside ");
  write("video.mp4", "film");
  EXPECT_EQ(report()["poster"], "pictures/03-hit.png");
  EXPECT_EQ(shown(), "01-hit 05-play 06-play outside ");
  fs::remove(folder_ / "pictures/01-hit.png");
  fs::remove(folder_ / "pictures/03-hit.png");
  fs::remove(folder_ / "pictures/outside.png");
  EXPECT_EQ(report()["poster"], "pictures/06-play.png");
  EXPECT_EQ(shown(), "02-play 04-play 05-play ");
}

TEST_F(DemoReport, HasTheApplicationsWordsFiguresSectionsAndTables) {
  write_raw();
  const Json application = report()["application"];
  EXPECT_EQ(application["task"], "watch a weight");
  EXPECT_EQ(application["figures"][0]["verdict"], "falls short");
  EXPECT_EQ(application["tables"][0]["file"], "swing.csv");
  const std::string html = page();
  const auto exchange = html.find("<h2 id=\"exchange\">"), swing = html.find("<h2 id=\"swing\">"),
             real_time = html.find("<h2 id=\"real-time\">");
  EXPECT_LT(exchange, swing);
  EXPECT_LT(swing, real_time);
  for (const char* told : {"<h1>A swing</h1>", "The weight is not there.", "To and fro.", "raw/swing.csv"})
    EXPECT_NE(html.find(told), std::string::npos) << told;
}

TEST_F(DemoReport, TakesAnApplicationsWordsLimitsAndTemplatesFromItsFiles) {
  scene::ApplicationSpec spec = swing_for_tests();
  spec.page = {
      {"swing.toml", "title = \"Swinging\"\ntask = \"watch\""},
      {"swing-limits.toml", "[passes]\nfigure = \"swing/passes\"\nat_most = 23"},
      {"swing-sections.html",
       "<h2 id=\"own\">Own</h2>{{#judged.passes}}<b>{{verdict}}</b> {{data.count}}{{/judged.passes}}"}};
  spec.report = [](const auto&) { return scene::PlayReport{.scene = "Own scene.", .data = {{"count", 17}}}; };
  const std::string html = page({spec});
  for (const char* told : {"<h1>Swinging</h1>", "Own scene.", "<b>falls short</b> 17", "href=\"#own\""})
    EXPECT_NE(html.find(told), std::string::npos) << told;
}

// A page can be made where the application of the folder is not known, and where it has no part in pages.
TEST_F(DemoReport, OfAnApplicationWithoutAPartIsPlain) {
  write_raw();
  scene::ApplicationSpec silent = swing_for_tests();
  silent.report = nullptr;
  const std::string of_unknown = page(scene::ApplicationRegistry()), of_silent = page({silent});
  for (const std::string& html : {of_unknown, of_silent}) {
    EXPECT_NE(html.find("<h1>Palpate: swing</h1>"), std::string::npos);
    EXPECT_NE(html.find("<h2 id=\"forces\">"), std::string::npos);
    EXPECT_EQ(html.find("To and fro."), std::string::npos);
  }
  // Each file of the folder is named; what it holds, the application alone knows.
  EXPECT_NE(of_unknown.find("raw/swing.csv"), std::string::npos);
  EXPECT_EQ(of_unknown.find("the weight, picture by picture"), std::string::npos);
  EXPECT_NE(of_silent.find("the weight, picture by picture"), std::string::npos);
}

TEST_F(DemoReport, JudgesADisparityUnderTheBodysName) {
  Json told = summary();
  told["registration"]["disparity"] = {{"world_px_rms", 0.1}, {"weight_px_rms", 0.4}, {"weight_px_p95", 0.8}};
  write("summary.json", told.dump());
  const Json disparities = report()["disparities"];
  ASSERT_EQ(disparities.size(), 1u);
  EXPECT_EQ(disparities[0]["body"], "weight");
  EXPECT_EQ(disparities[0]["verdict"], "falls short");
}

TEST_F(DemoReport, TellsWhatMadeItsFiguresAndOnWhatMachine) {
  Json told = summary();
  told["made"] = {{"version", "0.1.0"},
                  {"commit", "3d8d93f1"},
                  {"compiler", "Clang 14"},
                  {"options", "Release"},
                  {"date", "2026-11-28T16:00:00Z"},
                  {"processor", "of a test"},
                  {"cores", 2},
                  {"kernel", "Linux 6.1"},
                  {"load_before", 0.4},
                  {"renderer", "llvmpipe"},
                  {"scheduling", "SCHED_FIFO priority 80"}};
  write("summary.json", told.dump());
  for (const char* words :
       {"palpate 0.1.0, commit 3d8d93f1", "Clang 14 (Release)", "2026-11-28T16:00:00Z", "of a test, 2 cores",
        "Linux 6.1", "llvmpipe", "SCHED_FIFO priority 80", "0.40 when"})
    EXPECT_NE(page().find(words), std::string::npos) << words;
  EXPECT_EQ(page().find("belong to the machine"), std::string::npos) << "nothing of real time falls short";
  told["realtime"]["haptic"]["rate_hz"] = 812.5;
  write("summary.json", told.dump());
  for (const char* words : {"<li>Real time: rate of the haptic loop: 812.5 Hz (at least 990 is wanted)</li>",
                            "2 cores, with a load of 0.4 when"})
    EXPECT_NE(page().find(words), std::string::npos) << words;
  told["made"]["commit"] = nullptr;
  told["made"]["load_before"] = nullptr;
  write("summary.json", told.dump());
  EXPECT_NE(page().find("commit not known"), std::string::npos);
}

TEST_F(DemoReport, JudgesTheOverlayInRealTimeAsInLockStepAndSaysWhereTheMachineWasTooBusy) {
  const auto with = [](double px, int without_tracker) -> Json {
    return {{"realtime",
             {{"overlay",
               {{"world_px_rms", px},
                {"frames", 270},
                {"late", 3},
                {"pose_from", {{"none", without_tracker}}}}}}}};
  };
  EXPECT_EQ(verdict("realtime_world_overlay", with(0.1, 0)), "holds");
  EXPECT_EQ(page().find("too busy"), std::string::npos);
  EXPECT_EQ(verdict("realtime_world_overlay", with(13.3, 2)), "falls short");
  EXPECT_NE(page().find("Of 270 pictures 2 were drawn before"), std::string::npos);
}

TEST_F(DemoReport, HasACardOfThePersonsOwnGame) {
  EXPECT_EQ(page().find("Your own game"), std::string::npos);
  Json told = summary();
  told["realtime"]["own_game"] = {"6 of 12 serves returned"};
  write("summary.json", told.dump());
  const std::string html = page();
  EXPECT_NE(html.find("Your own game"), std::string::npos);
  EXPECT_NE(html.find("6 of 12 serves returned"), std::string::npos);
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

// Whatever a folder brings: names, captions, labels of tables, the command.
TEST_F(DemoReport, EscapesTextFromOutside) {
  const std::string evil = "<script>alert('x')</script>";
  Json told = summary();
  told["application"] = evil;
  told["command"] = evil;
  told["pictures"] = {{"a.png", evil}};
  told["registration"]["disparity"] = {{evil + "_px_rms", 0.4}};
  write("summary.json", told.dump());
  write("pictures/a.png", "picture A");
  write("raw/lens.csv", "which,fx," + evil + "\nest,1,2\n");
  const std::string html = page();
  EXPECT_EQ(html.find("<script>alert"), std::string::npos);
  EXPECT_NE(html.find("&lt;script&gt;alert"), std::string::npos);
}

TEST_F(DemoReport, JudgesTheRightEyeWhereThereIsOne) {
  EXPECT_TRUE(report()["judged"]["right_world_overlay"]["verdict"].is_null());
  EXPECT_EQ(verdict("right_world_overlay", {{"registration", {{"right_eye", {{"world_px_rms", 0.12}}}}}}),
            "holds");
  EXPECT_EQ(verdict("right_world_overlay", {{"registration", {{"right_eye", {{"world_px_rms", 0.31}}}}}}),
            "falls short");
}

#ifdef PALPATE_CHROMIUM
TEST_F(DemoReport, IsDrawnByABrowserWithoutANetwork) {
  write_raw();
  write_network();
  page();
  const std::string command = fmt::format(
      PALPATE_CHROMIUM
      " --headless --no-sandbox --disable-gpu --disable-dev-shm-usage --host-resolver-rules='MAP "
      "* ~NOTFOUND' "
      "--user-data-dir='{0}/profile' "
      "--virtual-time-budget=20000 --enable-logging=stderr --dump-dom 'file://{0}/report.html' 2>&1",
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
  EXPECT_EQ(dom.find(":CONSOLE"), std::string::npos) << "neither an error nor plotly's complaint of margins";
  // The pivot's points reach to 92, 119 and 92 mm: the box around them ends at round numbers.
  EXPECT_NE(dom.find("x from -100 to 100, y from 70 to 120, z from -100 to 100 mm"), std::string::npos);
}
#endif

}  // namespace
}  // namespace palpate::tools::demo
