// The page that a person sees in a guided session: the camera's picture with what can be drawn into it, plans of the room,
// how good the calibration would be by now, what is asked for, which keys answer.
//
// A function of view and size. One thread per object.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "palpate/desktop/letterbox.h"
#include "palpate/desktop/lettering.h"
#include "palpate/desktop/session_view.h"

namespace palpate::desktop {

struct KeyWords {
  std::string key, does;
};
// The keys that answer what the view shows.
std::vector<KeyWords> session_keys(const SessionView& view);

enum class Mood : std::uint8_t { plain, good, wait, bad };
// How it goes, in one line.
struct StateWords {
  std::string words;
  Mood mood = Mood::plain;
};
StateWords session_state(const SessionView& view);

// Whether the tracker sees a marker.
StateWords marker_state(const char* name, const calibration::session::SeenMarker& marker);

// Why nothing is drawn into the camera's picture although there is something to draw; empty: it is.
std::string no_drawing_reason(const SessionView& view);

class SessionPage {
 public:
  explicit SessionPage(std::unique_ptr<Lettering> lettering) : lettering_(std::move(lettering)) {}

  // Where the parts stand; boxes may be empty.
  struct Layout {
    int letter = 0;  // px
    Box header, picture, plans, curves, words;
  };
  static Layout layout(const SessionView& view, Size size);

  // The whole page, opaque. Valid until the next call.
  const Canvas& draw(const SessionView& view, Size size);

 private:
  void draw_header(const SessionView& view, const Layout& at);
  void draw_camera(const SessionView& view, const Layout& at);
  void draw_plans(const SessionView& view, const Layout& at);
  void draw_plan(const SessionView& view, const Box& box, int letter, bool above);
  void draw_words(const SessionView& view, const Layout& at);
  void draw_keys(const std::vector<KeyWords>& keys, int x, int y, int size, int right);
  void draw_outcome(const SessionView& view, const Layout& at);
  int write(int x, int y, const std::string& words, int size, const Colour& colour);
  // Writes lines no wider than `width`, `most` of them; returns where the next would be.
  int write_wrapped(int x, int y, int width, int most, const std::string& words, int size,
                    const Colour& colour);

  std::unique_ptr<Lettering> lettering_;
  Canvas page_;
};

}  // namespace palpate::desktop
