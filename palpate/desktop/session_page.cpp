#include "palpate/desktop/session_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/desktop/drawing.h"
#include "palpate/desktop/session_colours.h"
#include "palpate/desktop/session_curves.h"
#include "palpate/desktop/session_shapes.h"

namespace palpate::desktop {
namespace {

using device::Gesture;

constexpr double kFlash_s = 0.7;  // a border after something was taken

const Colour& colour_of(Mood mood) {
  switch (mood) {
    case Mood::good:
      return kGood;
    case Mood::wait:
      return kGoal;
    case Mood::bad:
      return kBad;
    case Mood::plain:
      break;
  }
  return kInkWhite;
}

bool is_movement(const device::Request& request) {
  return request.gesture != Gesture::next_pose && request.gesture != Gesture::touch &&
         request.gesture != Gesture::rest;
}

const calibration::session::SeenMarker& watched(const SessionView& view) {
  switch (watched_marker(*view.request)) {
    case device::MarkerId::pointer:
      return view.person.pointer;
    case device::MarkerId::camera_marker:
      return view.person.head;
    default:
      return view.person.stylus;
  }
}

bool flashes(const SessionView& view) { return view.taken_s && view.person.now_s < *view.taken_s + kFlash_s; }

bool is_on(const Canvas& canvas, const Eigen::Vector2d& at) {
  return at.x() >= 0.0 && at.y() >= 0.0 && at.x() < canvas.width && at.y() < canvas.height;
}

void border(Canvas& canvas, const Box& box, int width, const Colour& colour) {
  canvas.rectangle(box.x, box.y, box.width, width, colour);
  canvas.rectangle(box.x, box.y + box.height - width, box.width, width, colour);
  canvas.rectangle(box.x, box.y, width, box.height, colour);
  canvas.rectangle(box.x + box.width - width, box.y, width, box.height, colour);
}

}  // namespace

std::vector<KeyWords> session_keys(const SessionView& view) {
  if (view.ending) return {};
  if (view.outcome) {
    std::vector<KeyWords> keys;
    if (view.outcome->done) keys.push_back({"Enter", "go on"});
    keys.push_back({"R", "repeat it"});
    if (!view.outcome->first) keys.push_back({"U", "undo: the one before, too"});
    keys.push_back({"Q", "stop"});
    return keys;
  }
  if (!view.request) return {{"Q", "stop"}};
  std::vector<KeyWords> keys;
  const device::Request& request = *view.request;
  const bool recording = is_movement(request) && view.taken_s;
  if (request.gesture == Gesture::next_pose) {
    if (request.target) keys.push_back({"Enter", "take it where it is"});
    keys.push_back({"S", request.target ? "another place" : "skip this one"});
  } else if (request.gesture == Gesture::touch) {
    keys.push_back({"Enter", "the tip is there"});
    if (request.what == "landmark" && !request.known) keys.push_back({"N", "there are no more"});
  } else if (!recording) {
    keys.push_back({"Enter", request.gesture == Gesture::rest ? "done" : "I have begun"});
  }
  keys.push_back({"Q", "stop"});
  return keys;
}

StateWords session_state(const SessionView& view) {
  if (view.ending) return {"Stopping; what is done is kept", Mood::wait};
  if (view.steps == 0) return {"Opening the devices", Mood::wait};
  if (view.outcome) return {};
  if (!view.request) return {"One moment", Mood::wait};
  if (!view.person.arm_answers) return {"The arm does not answer", Mood::bad};
  if (view.request->gesture == Gesture::rest) return {};
  const auto& marker = watched(view);
  if (!marker.seen) return {"The tracker does not see the marker: turn it towards the tracker", Mood::bad};
  if (is_movement(*view.request)) {
    if (!view.taken_s) return {"The tracker sees the marker", Mood::plain};
    return {fmt::format("Recording, {:.0f} s: keep on", std::max(0.0, view.person.now_s - *view.taken_s)),
            Mood::good};
  }
  if (flashes(view)) return {"Taken", Mood::good};
  const bool arrived = !view.request->target || view.person.near_target;
  std::string words = view.progress;
  if (!words.empty() && words[0] >= 'a' && words[0] <= 'z')
    words[0] = static_cast<char>(words[0] - 'a' + 'A');
  return {words, arrived && marker.still ? Mood::good : arrived ? Mood::wait : Mood::plain};
}

StateWords marker_state(const char* name, const calibration::session::SeenMarker& marker) {
  if (!marker.seen) return {fmt::format("{}: not seen", name), Mood::bad};
  return marker.still ? StateWords{fmt::format("{}: held still", name), Mood::good}
                      : StateWords{fmt::format("{}: seen, moving", name), Mood::wait};
}

std::string no_drawing_reason(const SessionView& view) {
  if (!view.picture || !view.request) return "";
  if (view.request->gesture != Gesture::next_pose && view.request->gesture != Gesture::touch) return "";
  if (!view.rig || !view.rig->camera || !view.rig->hand_eye)
    return "Nothing is drawn into this picture until the camera is calibrated; the plans show the place";
  if (!view.picture->marker.seen)
    return "The tracker does not see the camera's marker: nothing can be drawn into this picture";
  return "";
}

SessionPage::Layout SessionPage::layout(const SessionView& view, Size size) {
  Layout at;
  at.letter = std::max(9, std::min(size.height / 42, size.width / 66));
  const int letter = at.letter, edge = letter / 2;
  at.header = {edge, edge, size.width - 2 * edge, 2 * letter + edge};
  const int top = at.header.y + at.header.height + edge, bottom = size.height - edge;
  const int words = std::min(11 * letter, (bottom - top) / 2);
  const int column = size.width * 32 / 100, left = size.width - 3 * edge - column;
  at.words = {edge, bottom - words, left, words};
  at.picture = {edge, top, left, at.words.y - edge - top};
  at.plans = {2 * edge + left, top, column, bottom - top};
  if (view.guidance.empty()) return at;
  const int curves = std::min(13 * letter, (bottom - top) / 3);
  at.plans.height -= curves + edge;
  at.curves = {at.plans.x, bottom - curves, column, curves};
  return at;
}

int SessionPage::write(int x, int y, const std::string& words, int size, const Colour& colour) {
  return lettering_->write(page_, x, y, words, size, colour);
}

int SessionPage::write_wrapped(int x, int y, int width, int most, const std::string& words, int size,
                               const Colour& colour) {
  auto lines = wrapped_lines(*lettering_, words, size, width);
  if (static_cast<int>(lines.size()) > most) {
    lines.resize(static_cast<std::size_t>(most));
    lines.back() += " ...";
  }
  for (const auto& line : lines) {
    write(x, y, line, size, colour);
    y += lettering_->line_height(size);
  }
  return y;
}

const Canvas& SessionPage::draw(const SessionView& view, Size size) {
  if (page_.width != size.width || page_.height != size.height) page_ = Canvas(size.width, size.height);
  for (std::size_t i = 0; i + 3 < page_.rgba.size(); i += 4) {
    page_.rgba[i] = kPageGround.red;
    page_.rgba[i + 1] = kPageGround.green;
    page_.rgba[i + 2] = kPageGround.blue;
    page_.rgba[i + 3] = 255;
  }
  const Layout at = layout(view, size);
  draw_header(view, at);
  draw_camera(view, at);
  draw_plans(view, at);
  if (at.curves.height > 0) {
    page_.rounded(at.curves.x, at.curves.y, at.curves.width, at.curves.height, at.letter / 2, kPageBox);
    const auto curves = guidance_curves(view.guidance, view.guided_of);
    const int edge = at.letter / 2, small = at.letter * 4 / 5;
    const int high = (at.curves.height - 3 * edge) / static_cast<int>(curves.size());
    for (std::size_t i = 0; i < curves.size(); ++i)
      draw_curve(page_, *lettering_, curves[i],
                 {at.curves.x + edge, at.curves.y + edge + static_cast<int>(i) * (high + edge),
                  at.curves.width - 2 * edge, high},
                 small);
  }
  draw_words(view, at);
  if (view.outcome) draw_outcome(view, at);
  return page_;
}

void SessionPage::draw_header(const SessionView& view, const Layout& at) {
  const int letter = at.letter, size = letter * 3 / 2;
  const Box& box = at.header;
  const std::string title = view.steps == 0
                                ? "Calibration"
                                : fmt::format("Step {} of {}: {}", view.step + 1, view.steps, view.step_name);
  write(box.x + letter / 2, box.y + letter / 4, title, size, kInkWhite);
  if (view.steps == 0) return;
  // A box for each step, those behind filled.
  const int steps = static_cast<int>(view.steps), gap = std::max(2, letter / 5);
  const int room = std::min(box.width / 3, steps * 3 * letter), wide = room / steps - gap;
  for (int i = 0; i < steps; ++i) {
    const Colour& colour = i < static_cast<int>(view.step)    ? kGood
                           : i == static_cast<int>(view.step) ? kInkWhite
                                                              : kPageLine;
    page_.rounded(box.x + box.width - room + i * (wide + gap), box.y + letter, wide, std::max(3, letter / 3),
                  letter / 6, colour);
  }
}

void SessionPage::draw_camera(const SessionView& view, const Layout& at) {
  const int letter = at.letter;
  const Box& room = at.picture;
  if (room.width <= 0 || room.height <= 0) return;
  page_.rounded(room.x, room.y, room.width, room.height, letter / 2, kPageBox);
  if (!view.picture || view.picture->image.width <= 0) {
    const std::string words = view.steps == 0 ? "Opening the devices" : "No picture from the camera yet";
    write(room.x + (room.width - lettering_->width(words, letter)) / 2, room.y + room.height / 2, words,
          letter, kInkGrey);
    return;
  }
  const auto& image = view.picture->image;
  Box box = letterbox({image.width, image.height}, {room.width, room.height});
  // Drawn on a canvas of its own, whose edges cut what goes beyond.
  Canvas picture(box.width, box.height);
  draw_picture(picture, image.rgb, {image.width, image.height}, {0, 0, box.width, box.height});
  const SessionShapes shapes = shapes_of(view);
  const bool is_place = view.request && !view.outcome && !is_movement(*view.request);
  if (const auto projection = picture_projection(view, {0, 0, box.width, box.height}); projection && is_place)
    draw_shapes(picture, shapes, *projection, is_near_goal(view, shapes), letter);
  box.x += room.x, box.y += room.y;
  put(page_, picture, box.x, box.y);
  if (flashes(view)) border(page_, box, std::max(3, letter / 3), kGood);
  const std::string reason = view.outcome ? "" : no_drawing_reason(view);
  if (reason.empty()) return;
  const int small = letter * 4 / 5;
  const auto lines = wrapped_lines(*lettering_, reason, small, box.width - 2 * letter);
  const int high = static_cast<int>(lines.size()) * lettering_->line_height(small) + letter / 2;
  page_.rectangle(box.x, box.y + box.height - high, box.width, high, {12, 14, 18, 190});
  write_wrapped(box.x + letter / 2, box.y + box.height - high + letter / 4, box.width - letter, 3, reason,
                small, kInkGrey);
}

void SessionPage::draw_plans(const SessionView& view, const Layout& at) {
  const int edge = at.letter / 2, high = (at.plans.height - edge) / 2;
  for (const bool above : {true, false})
    draw_plan(view, {at.plans.x, at.plans.y + (above ? 0 : high + edge), at.plans.width, high}, at.letter,
              above);
}

void SessionPage::draw_plan(const SessionView& view, const Box& box, int letter, bool above) {
  const int small = letter * 4 / 5, line = lettering_->line_height(small), edge = letter / 2;
  if (box.width < 4 * letter || box.height < 4 * letter) return;
  page_.rounded(box.x, box.y, box.width, box.height, edge, kPageBox);
  write(box.x + edge, box.y + edge / 2, above ? "From above" : "From where you stand", small, kInkGrey);
  const SessionShapes shapes = shapes_of(view);
  const Plan plan = plan_of(shapes);
  const Size size{box.width - 2 * edge, box.height - 2 * line - edge};
  Canvas canvas(size.width, size.height);
  const auto side = above ? PlanSide::above : PlanSide::front;
  const Projection projection = plan.projection(size, side);
  for (const auto& surface : shapes.surfaces) {
    std::vector<Eigen::Vector2d> corners;
    for (const auto& corner : surface.corners) corners.push_back(*projection(corner));
    fill_polygon(canvas, corners, {kSurface.red, kSurface.green, kSurface.blue, 28});
  }
  if (shapes.head) draw_ring(canvas, *projection(*shapes.head), 0.4 * letter, 0.15 * letter, kInkGrey);
  const bool is_near = is_near_goal(view, shapes);
  draw_shapes(canvas, shapes, projection, is_near, letter);
  const int x = box.x + edge, y = box.y + line + edge / 2;
  put(page_, canvas, x, y);
  // A decimetre, and what the colours mean.
  const int foot = box.y + box.height - line - edge / 4;
  const int decimetre = static_cast<int>(std::lround(0.1 * plan.pixels_per_metre(size)));
  const std::string scale = "10 cm";
  const int right = box.x + box.width - edge;
  page_.rectangle(right - decimetre, foot + line / 2, decimetre, std::max(2, letter / 8), kInkGrey);
  write(right - decimetre - edge - lettering_->width(scale, small), foot, scale, small, kInkGrey);
  int legend = x;
  if (shapes.present) legend = write(legend, foot, "you", small, kPresent) + letter;
  if (shapes.goal()) legend = write(legend, foot, "hold it here", small, is_near ? kGood : kGoal) + letter;
  const bool has_head = shapes.head && is_on(canvas, *projection(*shapes.head));
  if (has_head) write(legend, foot, "camera", small, kInkGrey);
}

void SessionPage::draw_keys(const std::vector<KeyWords>& keys, int x, int y, int size, int right) {
  const int pad = size / 2, line = lettering_->line_height(size), begin = x;
  for (const auto& [key, does] : keys) {
    const int cap = lettering_->width(key, size) + 2 * pad, all = cap + pad + lettering_->width(does, size);
    if (x > begin && x + all > right) x = begin, y += line + size;
    page_.rounded(x, y, cap, line + size / 2, size / 3, kPageLine);
    page_.rounded(x + 1, y + 1, cap - 2, line + size / 2 - 3, size / 3, {52, 60, 70, 255});
    write(x + pad, y + size / 5, key, size, kInkWhite);
    write(x + cap + pad, y + size / 5, does, size, kInkGrey);
    x += all + 2 * size;
  }
}

void SessionPage::draw_words(const SessionView& view, const Layout& at) {
  const int letter = at.letter, pad = letter / 2, small = letter * 4 / 5;
  const Box& box = at.words;
  page_.rounded(box.x, box.y, box.width, box.height, pad, kPageBox);
  int x = box.x + letter, y = box.y + pad;
  // Whether each marker is seen, first.
  for (const auto& [name, marker] :
       {std::pair("Stylus", &view.person.stylus), std::pair("Pointer", &view.person.pointer),
        std::pair("Camera", &view.person.head)}) {
    const StateWords state = marker_state(name, *marker);
    draw_disc(page_, {x + 0.3 * letter, y + 0.55 * letter}, 0.28 * letter, colour_of(state.mood));
    x = write(x + letter, y, state.words, small, kInkGrey) + letter;
  }
  y += lettering_->line_height(small) + pad;
  x = box.x + letter;
  const int right = box.x + box.width - letter;
  if (view.outcome) {
    write(x, y, "See the result above; then:", letter * 6 / 5, kInkWhite);
  } else {
    write_wrapped(x, y, right - x, 3, view.ending ? "" : view.instruction, letter * 21 / 20, kInkWhite);
    const StateWords state = session_state(view);
    int size = letter * 13 / 10;  // smaller only where it would not fit
    while (size > letter * 3 / 4 && lettering_->width(state.words, size) > right - x) --size;
    write_wrapped(x, y + 3 * lettering_->line_height(letter * 21 / 20) + pad / 2, right - x, 1, state.words,
                  size, colour_of(state.mood));
    // What has been taken of it so far.
    std::string count;
    if (view.guided_of > 0 && view.request && view.request->gesture == Gesture::next_pose &&
        !view.guidance.empty() && view.guidance.back().poses < view.guided_of)
      count = fmt::format("{} of {} taken", view.guidance.back().poses, view.guided_of);
    else if (view.taken > 0 && view.request && !is_movement(*view.request))
      count = fmt::format("{} taken", view.taken);
    write(right - lettering_->width(count, letter), box.y + pad, count, letter, kInkWhite);
  }
  draw_keys(session_keys(view), x, box.y + box.height - lettering_->line_height(letter) - letter, letter,
            right);
}

void SessionPage::draw_outcome(const SessionView& view, const Layout& at) {
  const int letter = at.letter, large = letter * 3 / 2;
  const auto& outcome = *view.outcome;
  const int wide = std::min(at.picture.width - 2 * letter, 44 * letter);
  if (wide <= 4 * letter) return;
  const auto lines = wrapped_lines(*lettering_, outcome.words, letter, wide - 2 * letter);
  const int high = lettering_->line_height(large) +
                   std::min(9, static_cast<int>(lines.size())) * lettering_->line_height(letter) +
                   5 * letter / 2;
  const int x = at.picture.x + (at.picture.width - wide) / 2,
            y = at.picture.y + std::max(0, (at.picture.height - high) / 2);
  page_.rounded(x, y, wide, high, letter / 2, {16, 20, 26, 235});
  page_.rounded(x, y, letter / 2, high, letter / 4, outcome.done ? kGood : kBad);
  write(x + letter, y + letter / 2, (outcome.done ? "Done: " : "Failed: ") + outcome.step, large,
        outcome.done ? kGood : kBad);
  write_wrapped(x + letter, y + letter + lettering_->line_height(large), wide - 2 * letter, 9, outcome.words,
                letter, kInkWhite);
}

}  // namespace palpate::desktop
