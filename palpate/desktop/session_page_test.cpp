#include "palpate/desktop/session_page.h"

#include <gtest/gtest.h>

#include "palpate/desktop/session_colours.h"

namespace palpate::desktop {
namespace {

using device::Gesture;

constexpr Size kPageSize{1280, 800};

SessionPage a_page() {
  auto lettering = Lettering::open();
  if (!lettering) throw std::runtime_error(lettering.error().message);
  return SessionPage(std::move(*lettering));
}

// The stylus is to be held somewhere; the camera's picture is all of one red.
SessionView posing() {
  SessionView view;
  view.step = 4;
  view.steps = 8;
  view.step_name = "arm";
  view.request = device::Request{Gesture::next_pose, "", 0};
  view.request->target = device::PoseTarget{{Vector3(0.1, -1.3, 1.6)}, Quaternion::Identity(), {0, 0, -0.1}};
  view.instruction = "Bring the stylus to the place that is told and hold it still.";
  view.progress = "12 cm to the left; turn it by 20 degrees";
  view.person.stylus.seen = true;
  view.person.stylus.translation = {0.22, -1.3, 1.7};
  auto picture = std::make_shared<SessionPicture>();
  picture->image.width = 64;
  picture->image.height = 48;
  for (int i = 0; i < 64 * 48; ++i) picture->image.rgb.insert(picture->image.rgb.end(), {150, 20, 30});
  view.picture = picture;
  return view;
}

double share(const Canvas& canvas, const Box& box, const auto& is) {
  int found = 0, all = 0;
  for (int y = box.y; y < box.y + box.height; ++y)
    for (int x = box.x; x < box.x + box.width; ++x) ++all, found += is(canvas.at(x, y)) ? 1 : 0;
  return static_cast<double>(found) / std::max(1, all);
}

auto is_colour(const Colour& colour) {
  return [colour](const std::array<std::uint8_t, 4>& pixel) {
    return pixel[0] == colour.red && pixel[1] == colour.green && pixel[2] == colour.blue;
  };
}

std::vector<std::string> keys_of(const SessionView& view) {
  std::vector<std::string> keys;
  for (const auto& key : session_keys(view)) keys.push_back(key.key);
  return keys;
}

using Keys = std::vector<std::string>;

TEST(SessionPage, NamesTheKeysThatAnswer) {
  SessionView view = posing();
  EXPECT_EQ(keys_of(view), (Keys{"Enter", "S", "Q"}));
  view.request->target.reset();  // held still is enough
  EXPECT_EQ(keys_of(view), (Keys{"S", "Q"}));
  view.request = device::Request{Gesture::touch, "landmark", 3};
  EXPECT_EQ(keys_of(view), (Keys{"Enter", "N", "Q"}));
  view.request->known = true;
  EXPECT_EQ(keys_of(view), (Keys{"Enter", "Q"}));
  view.request = device::Request{Gesture::touch, "table", 3};
  EXPECT_EQ(keys_of(view), (Keys{"Enter", "Q"}));
  view.request = device::Request{Gesture::swing_pointer, "", 0};
  EXPECT_EQ(keys_of(view), (Keys{"Enter", "Q"}));
  view.taken_s = 3.0;  // it is being recorded
  EXPECT_EQ(keys_of(view), (Keys{"Q"}));
  view.outcome = calibration::session::StepOutcome{"arm", true, "fine", false};
  EXPECT_EQ(keys_of(view), (Keys{"Enter", "R", "U", "Q"}));
  view.outcome = calibration::session::StepOutcome{"arm", false, "hidden", true};
  EXPECT_EQ(keys_of(view), (Keys{"R", "Q"}));
  view.ending = true;
  EXPECT_TRUE(keys_of(view).empty());
}

TEST(SessionPage, TellsHowItGoes) {
  SessionView view = posing();
  EXPECT_EQ(session_state(view).words, "12 cm to the left; turn it by 20 degrees");
  EXPECT_EQ(session_state(view).mood, Mood::plain);
  view.person.near_target = true;
  EXPECT_EQ(session_state(view).mood, Mood::wait);
  view.person.stylus.still = true;
  EXPECT_EQ(session_state(view).mood, Mood::good);
  view.person.stylus.seen = false;
  EXPECT_EQ(session_state(view).mood, Mood::bad);
  EXPECT_NE(session_state(view).words.find("does not see"), std::string::npos);
  view.person.arm_answers = false;
  EXPECT_NE(session_state(view).words.find("arm does not answer"), std::string::npos);
  view = posing();
  view.request = device::Request{Gesture::wander, "", 0};
  view.person.now_s = 12.0;
  EXPECT_EQ(session_state(view).mood, Mood::plain);
  view.taken_s = 5.0;
  EXPECT_EQ(session_state(view).words, "Recording, 7 s: keep on");
  EXPECT_EQ(session_state(SessionView()).mood, Mood::wait);  // the devices are opened
  EXPECT_EQ(marker_state("Pointer", {}).mood, Mood::bad);
  EXPECT_EQ(marker_state("Pointer", {.seen = true}).mood, Mood::wait);
  EXPECT_EQ(marker_state("Pointer", {.seen = true, .still = true}).words, "Pointer: held still");
}

TEST(SessionPage, SaysWhyNothingIsDrawnIntoThePicture) {
  SessionView view = posing();
  EXPECT_NE(no_drawing_reason(view).find("calibrated"), std::string::npos);
  rig::Rig rig;
  rig.camera.emplace();
  rig.hand_eye.emplace();
  view.rig = std::make_shared<rig::Rig>(rig);
  EXPECT_NE(no_drawing_reason(view).find("does not see the camera's marker"), std::string::npos);
  auto seen = std::make_shared<SessionPicture>(*view.picture);
  seen->marker.seen = true;
  view.picture = seen;
  EXPECT_EQ(no_drawing_reason(view), "");
  view = posing();
  view.request = device::Request{Gesture::look_around_board, "", 0};  // nothing to draw
  EXPECT_EQ(no_drawing_reason(view), "");
}

class SessionPageSizes : public testing::TestWithParam<Size> {};
INSTANTIATE_TEST_SUITE_P(SessionPage, SessionPageSizes,
                         testing::Values(Size{320, 240}, Size{800, 600}, kPageSize, Size{1920, 1080},
                                         Size{600, 900}, Size{2560, 1000}));

TEST_P(SessionPageSizes, KeepsItsPartsApartAndWithinTheWindow) {
  SessionView view = posing();
  view.guidance.resize(3);
  view.guided_of = 70;
  const auto at = SessionPage::layout(view, GetParam());
  const std::array<Box, 5> boxes{at.header, at.picture, at.plans, at.curves, at.words};
  for (const Box& box : boxes) {
    EXPECT_GT(box.width, 0);
    EXPECT_GT(box.height, 0);
    EXPECT_GE(box.x, 0);
    EXPECT_GE(box.y, 0);
    EXPECT_LE(box.x + box.width, GetParam().width);
    EXPECT_LE(box.y + box.height, GetParam().height);
    for (const Box& other : boxes)
      EXPECT_TRUE(&box == &other || box.x + box.width <= other.x || other.x + other.width <= box.x ||
                  box.y + box.height <= other.y || other.y + other.height <= box.y);
  }
  SessionPage page = a_page();
  const Canvas& drawn = page.draw(view, GetParam());
  EXPECT_EQ(drawn.width, GetParam().width);
  EXPECT_EQ(
      share(drawn, {0, 0, drawn.width, drawn.height}, [](const auto& pixel) { return pixel[3] == 255; }),
      1.0);
}

TEST(SessionPage, ShowsThePictureTheTargetAndWhatIsHeld) {
  SessionPage page = a_page();
  const SessionView view = posing();
  const auto at = SessionPage::layout(view, kPageSize);
  const Canvas& drawn = page.draw(view, kPageSize);
  EXPECT_GT(share(drawn, at.picture, is_colour({150, 20, 30})), 0.5);
  EXPECT_GT(share(drawn, at.plans, is_colour(kGoal)), 5e-4);
  EXPECT_GT(share(drawn, at.plans, is_colour(kPresent)), 2e-4);
  EXPECT_EQ(share(drawn, at.picture, is_colour(kGoal)), 0.0);  // the camera is not calibrated
  SessionView empty = view;
  empty.request.reset();
  empty.picture.reset();
  const Canvas& without = page.draw(empty, kPageSize);
  EXPECT_EQ(share(without, at.picture, is_colour({150, 20, 30})), 0.0);
  EXPECT_EQ(share(without, at.plans, is_colour(kGoal)), 0.0);
}

TEST(SessionPage, DrawsTheTargetIntoThePictureOfACalibratedCamera) {
  SessionView view = posing();
  rig::Rig rig;
  rig.camera.emplace();
  rig.camera->model.width = 64;
  rig.camera->model.height = 48;
  rig.camera->model.fx = rig.camera->model.fy = 50.0;
  rig.camera->model.cx = 31.5;
  rig.camera->model.cy = 23.5;
  rig.hand_eye.emplace();
  rig.hand_eye->X_marker_camera.rotation = Quaternion(0.0, 1.0, 0.0, 0.0);  // it looks along -z
  view.rig = std::make_shared<rig::Rig>(rig);
  auto seen = std::make_shared<SessionPicture>(*view.picture);
  seen->marker.seen = true;
  seen->marker.translation = {0.1, -1.3, 2.1};  // half a metre before the target
  view.picture = seen;
  SessionPage page = a_page();
  const auto at = SessionPage::layout(view, kPageSize);
  const Canvas& drawn = page.draw(view, kPageSize);
  const Box picture = letterbox({64, 48}, {at.picture.width, at.picture.height});
  const int x = at.picture.x + picture.x + picture.width / 2,
            y = at.picture.y + picture.y + picture.height / 2;
  EXPECT_GT(share(drawn, {x - 20, y - 20, 40, 40}, is_colour(kGoal)), 0.05);
  view.outcome = calibration::session::StepOutcome{"arm", true, "fine", false};
  view.person.near_target = true;
  EXPECT_EQ(share(page.draw(view, kPageSize), at.picture, is_colour(kGoal)), 0.0);
}

TEST(SessionPage, ShowsAResultInItsColour) {
  SessionPage page = a_page();
  SessionView view = posing();
  const auto at = SessionPage::layout(view, kPageSize);
  view.outcome = calibration::session::StepOutcome{"arm", true, "mean error 0.2 mm", false};
  EXPECT_GT(share(page.draw(view, kPageSize), at.picture, is_colour(kGood)), 1e-3);
  view.outcome->done = false;
  const Canvas& failed = page.draw(view, kPageSize);
  EXPECT_GT(share(failed, at.picture, is_colour(kBad)), 1e-3);
  EXPECT_EQ(share(failed, at.picture, is_colour(kGood)), 0.0);
}

TEST(SessionPage, HasCurvesWherePosesAreGuided) {
  SessionPage page = a_page();
  SessionView view = posing();
  EXPECT_EQ(SessionPage::layout(view, kPageSize).curves, Box{});
  for (int i = 0; i < 20; ++i) {
    calibration::session::GuidanceState state;
    state.poses = i + 1;
    state.predicted_error = 1e-3 / (i + 1);
    state.coverage = 0.03 * i;
    view.guidance.push_back(state);
  }
  view.guided_of = 30;
  const auto at = SessionPage::layout(view, kPageSize);
  EXPECT_GT(share(page.draw(view, kPageSize), at.curves, is_colour(kPresent)), 2e-3);
}

TEST(SessionExchange, HandsKeysOverInTheirOrderAndCountsChanges) {
  SessionExchange exchange;
  EXPECT_FALSE(exchange.take_key());
  exchange.press('r');
  exchange.press('\n');
  EXPECT_EQ(exchange.take_key(), 'r');
  EXPECT_EQ(exchange.take_key(), '\n');
  EXPECT_FALSE(exchange.take_key());
  const auto before = exchange.view().version;
  exchange.change([](SessionView& view) { view.progress = "still"; });
  EXPECT_EQ(exchange.view().progress, "still");
  EXPECT_NE(exchange.view().version, before);
  for (int i = 0; i < 1000; ++i) exchange.press('x');  // of a key that somebody leans on
  int kept = 0;
  while (exchange.take_key()) ++kept;
  EXPECT_LT(kept, 100);
}

}  // namespace
}  // namespace palpate::desktop
