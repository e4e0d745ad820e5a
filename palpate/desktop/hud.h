// What stands over the picture: score, figures, the force that nobody feels, warnings, hints, the list of
// keys.
//
// lay_out() is a function of content and size; panels that have not changed are not drawn again. Sizes follow
// the framebuffer's, so that letters are as large on a screen of twice the density. One thread.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "palpate/desktop/letterbox.h"
#include "palpate/desktop/lettering.h"
#include "palpate/scene/application_registry.h"

namespace palpate::desktop {

// What the hand, the program and the view can do here: keys that would do nothing are not listed.
struct KeysInUse {
  bool mouse = true, strokes = true, program = true, view = true;
  bool looks = false;     // there are several ways to draw it
  bool head = false;      // it is a simulated one, and can be held still
  bool explores = false;  // the mouse leads the tip over a surface and presses it
  scene::Handling handling;
};

struct HudContent {
  std::vector<std::string> score;  // the first line is the large one
  std::optional<double> pictures_per_s, delay_s;
  std::optional<double> overlay_px;  // as the system itself estimates it, rms
  double force_n = 0.0, last_force_n = 0.0;
  double full_force_n = 8.5;          // the bar's end: what the arm can give; 0: no bar
  std::vector<std::string> warnings;  // the most important first
  std::string hint;                   // what to do now; empty: nothing
  bool paused = false;
  std::optional<KeysInUse> help;  // the list of keys; none: it is not shown
};

struct Panel {
  int x = 0, y = 0;  // of its upper left corner in the framebuffer
  Canvas canvas;
  std::uint64_t version = 0;  // another number, another picture
};

class Hud {
 public:
  // Names of the panels; also their order from back to front.
  enum Place : std::size_t { kScore, kFigures, kForce, kHint, kPaused, kWarnings, kHelp, kPlaces };

  explicit Hud(std::unique_ptr<Lettering> lettering) : lettering_(std::move(lettering)) {}

  // One panel for each place; where there is nothing to show it is empty. Valid until the next call.
  const std::vector<Panel>& lay_out(const HudContent& content, Size framebuffer);

  // Lines no wider than `width`, broken between words.
  std::vector<std::string> wrapped(const std::string& words, int size, int width);

 private:
  struct Text {
    std::string words;
    int size = 0;
    Colour colour;
  };
  Canvas box_of(const std::vector<Text>& lines, const Colour& ground, int padding);
  Canvas force_bar(const HudContent& content, int size);
  Canvas warning_list(const std::vector<std::string>& warnings, int size, int width);
  Canvas help(const KeysInUse& uses, int size);
  // Draws a place again where its signature has changed.
  template <typename Draw>
  void renew(Place place, const std::string& signature, Draw&& draw);

  std::unique_ptr<Lettering> lettering_;
  std::vector<Panel> panels_{kPlaces};
  std::vector<std::string> signatures_{kPlaces};
  std::uint64_t versions_ = 0;
};

// The keys and what they do, as the help shows them.
struct KeyHelp {
  std::string keys, does;
};
std::vector<KeyHelp> key_help(const KeysInUse& uses);

}  // namespace palpate::desktop
