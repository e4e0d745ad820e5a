#include "palpate/desktop/hud.h"

#include <gtest/gtest.h>

#include <numeric>

namespace palpate::desktop {
namespace {

Hud a_hud() {
  auto lettering = Lettering::open();
  if (!lettering) throw std::runtime_error(lettering.error().message);
  return Hud(std::move(*lettering));
}

HudContent full_content() {
  HudContent content;
  content.score = {"rally 3", "returned 5 of 12", "longest 7"};
  content.pictures_per_s = 29.7;
  content.delay_s = 0.061;
  content.overlay_px = 0.23;
  content.force_n = content.last_force_n = 4.2;
  content.warnings = {
      "The tracker does not see the camera's marker: virtual things are not where they belong",
      "No landmarks"};
  content.hint = "Nobody else can play: `--player` seats the program beside you";
  content.paused = true;
  content.help = KeysInUse{.handling = {.begins = "serve"}};
  return content;
}

// How much of the canvas' width the colour reaches in some row.
int reach(const Canvas& canvas, auto&& is) {
  int most = 0;
  for (int y = 0; y < canvas.height; ++y)
    for (int x = most; x < canvas.width; ++x)
      if (is(canvas.at(x, y))) most = x;
  return most;
}

class HudSizes : public testing::TestWithParam<Size> {};
INSTANTIATE_TEST_SUITE_P(Hud, HudSizes,
                         testing::Values(Size{640, 480}, Size{960, 720}, Size{1920, 1080}, Size{3840, 2160},
                                         Size{480, 900}));

TEST_P(HudSizes, KeepsEveryPanelWithinTheWindow) {
  Hud hud = a_hud();
  for (const Panel& panel : hud.lay_out(full_content(), GetParam())) {
    EXPECT_GT(panel.canvas.width, 0);
    EXPECT_GE(panel.x, 0);
    EXPECT_GE(panel.y, 0);
    EXPECT_LE(panel.x + panel.canvas.width, GetParam().width)
        << &panel - &hud.lay_out(full_content(), GetParam())[0];
    EXPECT_LE(panel.y + panel.canvas.height, GetParam().height);
  }
}

TEST_P(HudSizes, LaysScoreAndFiguresAndForceSideBySide) {
  Hud hud = a_hud();
  const auto& panels = hud.lay_out(full_content(), GetParam());
  const auto apart = [&](Hud::Place a, Hud::Place b) {
    const Panel &p = panels[a], &q = panels[b];
    return p.x + p.canvas.width <= q.x || q.x + q.canvas.width <= p.x || p.y + p.canvas.height <= q.y ||
           q.y + q.canvas.height <= p.y;
  };
  EXPECT_TRUE(apart(Hud::kScore, Hud::kFigures));
  EXPECT_TRUE(apart(Hud::kScore, Hud::kForce));
  EXPECT_TRUE(apart(Hud::kScore, Hud::kHint));
  EXPECT_TRUE(apart(Hud::kScore, Hud::kWarnings));
  EXPECT_TRUE(apart(Hud::kFigures, Hud::kWarnings));
  EXPECT_TRUE(apart(Hud::kForce, Hud::kHint));
  EXPECT_TRUE(apart(Hud::kForce, Hud::kWarnings));
  EXPECT_TRUE(apart(Hud::kHelp, Hud::kWarnings));
}

TEST(Hud, GrowsWithTheWindow) {
  Hud hud = a_hud();
  const int small = hud.lay_out(full_content(), {960, 720})[Hud::kHelp].canvas.height;
  const int large = hud.lay_out(full_content(), {1920, 1440})[Hud::kHelp].canvas.height;
  EXPECT_NEAR(static_cast<double>(large) / small, 2.0, 0.1);  // to the rounding of letters
}

TEST(Hud, ShowsNothingWhereThereIsNothingToSay) {
  Hud hud = a_hud();
  const auto& panels = hud.lay_out({}, {640, 480});
  for (const auto place : {Hud::kScore, Hud::kFigures, Hud::kHint, Hud::kPaused, Hud::kWarnings, Hud::kHelp})
    EXPECT_EQ(panels[place].canvas.width, 0) << place;
  EXPECT_GT(panels[Hud::kForce].canvas.width, 0);
}

TEST(Hud, DrawsAPanelAgainOnlyWhenItsWordsChange) {
  Hud hud = a_hud();
  HudContent content = full_content();
  const auto version = [&](Hud::Place place) { return hud.lay_out(content, {640, 480})[place].version; };
  const auto score = version(Hud::kScore), figures = version(Hud::kFigures);
  content.delay_s = 0.0612;  // the same in whole milliseconds
  EXPECT_EQ(version(Hud::kFigures), figures);
  content.delay_s = 0.064;
  EXPECT_NE(version(Hud::kFigures), figures);
  EXPECT_EQ(version(Hud::kScore), score);
  content.score[0] = "rally 4";
  EXPECT_NE(version(Hud::kScore), score);
}

TEST(Hud, FillsTheForceBarInProportionAndColoursItByStrength) {
  Hud hud = a_hud();
  HudContent content;
  const auto bar = [&](double newton) -> const Canvas& {
    content.force_n = content.last_force_n = newton;
    return hud.lay_out(content, {960, 720})[Hud::kForce].canvas;
  };
  const auto green = [](const std::array<std::uint8_t, 4>& p) {
    return p[1] > p[0] + 40 && p[1] > p[2] + 40;
  };
  const auto red = [](const std::array<std::uint8_t, 4>& p) { return p[0] > p[1] + 90 && p[0] > p[2] + 90; };
  EXPECT_EQ(reach(bar(0.0), green), 0);
  const int quarter = reach(bar(0.25 * 8.5), green), tenth = reach(bar(0.1 * 8.5), green);
  EXPECT_GT(quarter, tenth);
  const int padding = bar(0.0).width - reach(bar(2.0 * 8.5), red);  // beyond the end: full
  EXPECT_LT(padding, bar(0.0).width / 10);
  const int width = bar(0.0).width - 2 * padding;
  EXPECT_NEAR(quarter - padding, 0.25 * width, 0.03 * width);
}

TEST(Hud, ShowsNoForceBarWhereNoHandIs) {
  Hud hud = a_hud();
  HudContent content = full_content();
  content.full_force_n = 0.0;
  EXPECT_EQ(hud.lay_out(content, {640, 480})[Hud::kForce].canvas.width, 0);
  content.full_force_n = 8.5;
  EXPECT_GT(hud.lay_out(content, {640, 480})[Hud::kForce].canvas.width, 0);
}

TEST(Hud, TellsAForceThatIsGoneFromOneThatIsFelt) {
  Hud hud = a_hud();
  HudContent content;
  const auto bright = [&](double now) {  // letters in white: of a force that is felt
    content.force_n = now;
    content.last_force_n = 4.2;
    const Canvas& canvas = hud.lay_out(content, {960, 720})[Hud::kForce].canvas;
    int count = 0;
    for (int y = 0; y < canvas.height / 2; ++y)
      for (int x = 0; x < canvas.width; ++x) count += canvas.at(x, y)[0] > 240;
    return count;
  };
  EXPECT_GT(bright(4.2), 10);
  EXPECT_EQ(bright(0.0), 0) << "the number stays, in grey";
  EXPECT_GT(bright(3.9), 10);
}

const scene::Handling kRacket{
    .held = "racket", .plays = "swing", .faces = "net", .buttons = "spin it", .begins = "throw up"};

TEST(KeyHelp, ListsOnlyKeysThatDoSomething) {
  const auto keys = [](const KeysInUse& uses) {
    std::string all;
    for (const auto& one : key_help(uses)) all += one.keys + ' ';
    return all;
  };
  EXPECT_EQ(keys({.handling = kRacket}),
            "Mouse Wheel, Up, Down Left, right button Space P R A S V F11 ? Q, Esc ");
  EXPECT_EQ(keys({.program = false, .handling = kRacket}),
            "Mouse Wheel, Up, Down Left, right button Space P R S V F11 ? Q, Esc ");
  EXPECT_EQ(keys({.mouse = false, .strokes = false, .program = false, .view = false, .handling = kRacket}),
            "Space P R F11 ? Q, Esc ");
  EXPECT_EQ(keys({.program = false, .head = true, .handling = kRacket}),
            "Mouse Wheel, Up, Down Left, right button Space P R S K V F11 ? Q, Esc ");
  EXPECT_EQ(keys({.strokes = false}), "Mouse Wheel, Up, Down Left, right button P R A V F11 ? Q, Esc ");
}

TEST(KeyHelp, SpeaksInTheWordsOfTheApplication) {
  const auto does = [](const KeysInUse& uses) {
    std::string all;
    for (const auto& one : key_help(uses)) all += one.does + '\n';
    return all;
  };
  EXPECT_TRUE(does({.handling = kRacket})
                  .starts_with("moves the racket: it goes where you point\nracket farther away, nearer\n"
                               "spin it\nthrow up\n"));
  EXPECT_NE(does({.handling = kRacket}).find("let the program swing, take the racket back\n"),
            std::string::npos);
  // What explores presses with its buttons.
  EXPECT_NE(does({.explores = true}).find("stylus up, down\npress, lift off: while held\n"),
            std::string::npos);
  // What hangs down is led from above.
  EXPECT_TRUE(does({}).starts_with(
      "moves the stylus: it goes where you point\nstylus up, down\nturn the stylus\npause"));
}

TEST(Hud, BreaksLongLinesBetweenWords) {
  Hud hud = a_hud();
  const std::string words = full_content().warnings[0];
  const auto lines = hud.wrapped(words, 16, 300);
  EXPECT_GT(lines.size(), 1u);
  const std::string again =
      std::accumulate(lines.begin() + 1, lines.end(), lines.front(),
                      [](const std::string& a, const std::string& b) { return a + " " + b; });
  EXPECT_EQ(again, words);
  auto lettering = Lettering::open();
  ASSERT_TRUE(lettering);
  for (const auto& line : lines) EXPECT_LE((*lettering)->width(line, 16), 300) << line;
}

TEST(Lettering, WritesWordsWhereAndAsWideAsItSays) {
  auto lettering = Lettering::open();
  ASSERT_TRUE(lettering);
  Canvas canvas(400, 60);
  const int end = (*lettering)->write(canvas, 10, 10, "Hill 0123", 24, {255, 255, 255, 255});
  EXPECT_EQ(end, 10 + (*lettering)->width("Hill 0123", 24));
  int left = 400, right = 0, top = 60, bottom = 0;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 400; ++x)
      if (canvas.at(x, y)[3] > 40)
        left = std::min(left, x), right = std::max(right, x), top = std::min(top, y),
        bottom = std::max(bottom, y);
  EXPECT_NEAR(left, 12, 3);
  EXPECT_NEAR(right, end, 4);
  EXPECT_GE(top, 10);
  EXPECT_LE(bottom, 10 + (*lettering)->line_height(24));
  EXPECT_NEAR(bottom - top, 18, 3);  // capitals are about three quarters of the letter size high
}

TEST(Lettering, DrawsWhatIsNotAsciiAsQuestionMarks) {
  auto lettering = Lettering::open();
  ASSERT_TRUE(lettering);
  EXPECT_EQ((*lettering)->width("\xC3\xA4", 20), (*lettering)->width("??", 20));
}

TEST(Canvas, LaysColoursOverEachOtherAsCoversAdd) {
  Canvas canvas(1, 1);
  canvas.lay(0, 0, {200, 100, 0, 128});
  EXPECT_NEAR(canvas.at(0, 0)[0], 100, 1);  // multiplied by its cover
  EXPECT_EQ(canvas.at(0, 0)[3], 128);
  canvas.lay(0, 0, {0, 0, 255, 255});
  EXPECT_EQ(canvas.at(0, 0), (std::array<std::uint8_t, 4>{0, 0, 255, 255}));
  canvas.lay(5, 5, {1, 2, 3, 255});  // beyond its edges nothing happens
  canvas.lay(-1, 0, {1, 2, 3, 255});
}

// Area of a rectangle less the four corners outside their quarter circles: (4 - pi) r^2.
TEST(Canvas, RoundsCornersAsCirclesDo) {
  Canvas canvas(200, 100);
  canvas.rounded(0, 0, 200, 100, 30, {255, 255, 255, 255});
  double covered = 0.0;
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 200; ++x) covered += canvas.at(x, y)[3] / 255.0;
  EXPECT_NEAR(covered, 200.0 * 100.0 - (4.0 - 3.14159265) * 900.0, 60.0);  // half a pixel along the arcs
  EXPECT_EQ(canvas.at(0, 0)[3], 0);
  EXPECT_EQ(canvas.at(100, 50)[3], 255);
}

}  // namespace
}  // namespace palpate::desktop
