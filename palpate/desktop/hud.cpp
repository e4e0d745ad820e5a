#include "palpate/desktop/hud.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace palpate::desktop {
namespace {

constexpr Colour kGround{18, 22, 28, 170}, kSolidGround{18, 22, 28, 225}, kWhite{255, 255, 255, 255},
    kGrey{190, 200, 210, 255}, kAmber{255, 190, 60, 240}, kBlack{20, 16, 8, 255}, kTrough{255, 255, 255, 50},
    kGentle{80, 200, 120, 255}, kStrong{240, 180, 40, 255}, kHard{235, 80, 60, 255};

// Letters of 1/34 of the window's height or 1/46 of its width: some 40 lines, readable at a desk.
int letter_size(Size framebuffer) {
  return std::max(10, std::min(framebuffer.height / 34, framebuffer.width / 46));
}

constexpr double kGone = 0.5;  // of the last peak: a bar lower than this is falling

// Of the number beside a bar that ends there: a hundredth of it is told.
int decimals_of(double full_n) { return full_n < 3.0 ? 2 : 1; }

Colour force_colour(double share) { return share < 0.4 ? kGentle : share < 0.8 ? kStrong : kHard; }

}  // namespace

std::vector<KeyHelp> key_help(const KeysInUse& uses) {
  std::vector<KeyHelp> list;
  const auto add = [&list](bool used, const char* keys, std::string does) {
    if (used) list.push_back({keys, std::move(does)});
  };
  const auto& [held, plays, faces, buttons, begins] = uses.handling;
  add(uses.mouse, "Mouse", fmt::format("moves the {}: it goes where you point", held));
  add(uses.mouse, "Wheel, Up, Down", held + (faces.empty() ? " up, down" : " farther away, nearer"));
  add(uses.mouse && uses.explores, "Left, right button", "press, lift off: while held");
  add(uses.mouse && !uses.explores, "Left, right button", buttons);
  add(!begins.empty(), "Space", begins);
  add(true, "P", "pause, go on");
  add(true, "R", "start again from zero");
  add(uses.program, "A", fmt::format("let the program {}, take the {} back", plays, held));
  add(uses.strokes, "S", "strokes by themselves, or only by pushing");
  add(uses.looks, "L", "draw it in another way");
  add(uses.head, "K", "keep the head still, move it again");
  add(uses.view, "V", "see it from the side, see it with your own eyes");
  add(true, "F11", "full screen");
  add(true, "?", "close this list");
  add(true, "Q, Esc", "quit");
  return list;
}

std::vector<std::string> Hud::wrapped(const std::string& words, int size, int width) {
  return wrapped_lines(*lettering_, words, size, width);
}

Canvas Hud::box_of(const std::vector<Text>& lines, const Colour& ground, int padding) {
  int wide = 0, high = 0;
  for (const auto& line : lines) {
    wide = std::max(wide, lettering_->width(line.words, line.size));
    high += lettering_->line_height(line.size);
  }
  Canvas canvas(wide + 2 * padding, high + 2 * padding);
  canvas.rounded(0, 0, canvas.width, canvas.height, padding, ground);
  int top = padding;
  for (const auto& line : lines) {
    lettering_->write(canvas, padding, top, line.words, line.size, line.colour);
    top += lettering_->line_height(line.size);
  }
  return canvas;
}

Canvas Hud::force_bar(const HudContent& content, int size) {
  const int padding = size / 2, wide = 16 * size, thick = std::max(4, size / 2);
  const int line = lettering_->line_height(size);
  Canvas canvas(wide + 2 * padding, line + thick + 2 * padding + size / 4);
  canvas.rounded(0, 0, canvas.width, canvas.height, padding, kGround);
  // The number stays to be read when the bar has fallen, but as what it then is: gone.
  const bool gone = content.force_n < kGone * content.last_force_n;
  lettering_->write(canvas, padding, padding, gone ? "Last force on your hand" : "Force on your hand", size,
                    kGrey);
  const std::string newtons =
      fmt::format("{:.{}f} N", content.last_force_n, decimals_of(content.full_force_n));
  lettering_->write(canvas, canvas.width - padding - lettering_->width(newtons, size), padding, newtons, size,
                    gone ? kGrey : kWhite);
  const double share = std::clamp(content.force_n / content.full_force_n, 0.0, 1.0);
  const int top = padding + line + size / 4;
  canvas.rounded(padding, top, wide, thick, thick / 2, kTrough);
  const int filled = static_cast<int>(std::lround(share * wide));
  if (filled > 0) canvas.rounded(padding, top, filled, thick, thick / 2, force_colour(share));
  return canvas;
}

Canvas Hud::warning_list(const std::vector<std::string>& warnings, int size, int width) {
  std::vector<Text> lines;
  for (const auto& warning : warnings)
    for (const auto& line : wrapped(warning, size, width)) lines.push_back({line, size, kBlack});
  return box_of(lines, kAmber, size / 2);
}

Canvas Hud::help(const KeysInUse& uses, int size) {
  const std::vector<KeyHelp> list = key_help(uses);
  const int padding = size, line = lettering_->line_height(size),
            title = lettering_->line_height(size * 3 / 2);
  int keys = 0, does = 0;
  for (const auto& one : list) {
    keys = std::max(keys, lettering_->width(one.keys, size));
    does = std::max(does, lettering_->width(one.does, size));
  }
  const int gap = 2 * size, lines = static_cast<int>(list.size());
  Canvas canvas(keys + gap + does + 2 * padding, title + size / 2 + lines * line + 2 * padding);
  canvas.rounded(0, 0, canvas.width, canvas.height, padding, kSolidGround);
  lettering_->write(canvas, padding, padding, "Keys", size * 3 / 2, kWhite);
  int top = padding + title + size / 2;
  for (const auto& one : list) {
    lettering_->write(canvas, padding, top, one.keys, size, kWhite);
    lettering_->write(canvas, padding + keys + gap, top, one.does, size, kGrey);
    top += line;
  }
  return canvas;
}

template <typename Draw>
void Hud::renew(Place place, const std::string& signature, Draw&& draw) {
  if (signatures_[place] == signature && panels_[place].version > 0) return;
  signatures_[place] = signature;
  panels_[place].canvas = signature.empty() ? Canvas() : draw();
  panels_[place].version = ++versions_;
}

const std::vector<Panel>& Hud::lay_out(const HudContent& content, Size framebuffer) {
  const int size = letter_size(framebuffer), small = std::max(9, size * 3 / 4), edge = size / 2;
  const auto put = [&](Place place, int x, int y) {
    panels_[place].x = x;
    panels_[place].y = y;
  };
  const auto wide = [&](Place place) { return panels_[place].canvas.width; };
  const auto high = [&](Place place) { return panels_[place].canvas.height; };
  const std::string sized = fmt::format("{} ", size);

  std::string signature;
  for (const auto& line : content.score) signature += sized + line + '\n';
  renew(kScore, signature, [&] {
    std::vector<Text> lines;
    for (const auto& line : content.score)
      lines.push_back(lines.empty() ? Text{line, size * 3 / 2, kWhite} : Text{line, size, kGrey});
    return box_of(lines, kGround, size / 2);
  });

  std::vector<std::string> figures;
  if (content.pictures_per_s) figures.push_back(fmt::format("{:.0f} pictures/s", *content.pictures_per_s));
  if (content.delay_s) figures.push_back(fmt::format("delay {:.0f} ms", 1e3 * *content.delay_s));
  if (content.overlay_px) figures.push_back(fmt::format("overlay error {:.1f} px", *content.overlay_px));
  signature.clear();
  for (const auto& line : figures) signature += sized + line + '\n';
  renew(kFigures, signature, [&] {
    std::vector<Text> lines;
    for (const auto& line : figures) lines.push_back({line, small, kGrey});
    return box_of(lines, kGround, size / 2);
  });
  put(kFigures, framebuffer.width - wide(kFigures) - edge, edge);

  signature.clear();
  if (content.full_force_n > 0.0)
    signature = fmt::format("{} {:.0f} {:.{}f} {}", sized, 280.0 * content.force_n / content.full_force_n,
                            content.last_force_n, decimals_of(content.full_force_n),
                            content.force_n < kGone * content.last_force_n);
  renew(kForce, signature, [&] { return force_bar(content, small); });
  put(kForce, edge, framebuffer.height - high(kForce) - edge);
  // Above the force, at the lower edge: what moves comes from above.
  put(kScore, edge, panels_[kForce].y - high(kScore) - (high(kForce) > 0 ? edge : 0));

  const int hint_width = framebuffer.width - wide(kForce) - 4 * edge;
  renew(kHint, content.hint.empty() ? "" : fmt::format("{} {} {}", sized, hint_width, content.hint), [&] {
    std::vector<Text> lines;
    for (const auto& line : wrapped(content.hint, size, hint_width)) lines.push_back({line, size, kWhite});
    return box_of(lines, kGround, size / 2);
  });
  put(kHint, std::max(framebuffer.width - wide(kHint) - edge, wide(kForce) + 2 * edge),
      framebuffer.height - high(kHint) - edge);

  renew(kPaused, content.paused ? sized : "", [&] {
    return box_of({{"Paused", size * 2, kWhite}, {"P goes on", size, kGrey}}, kSolidGround, size);
  });
  put(kPaused, (framebuffer.width - wide(kPaused)) / 2, (framebuffer.height - high(kPaused)) / 2);

  signature.clear();
  for (const auto& line : content.warnings) signature += sized + line + '\n';
  const int warning_width = framebuffer.width * 6 / 10;
  if (!signature.empty()) signature += fmt::format("{}", warning_width);
  renew(kWarnings, signature, [&] { return warning_list(content.warnings, size, warning_width); });
  put(kWarnings, (framebuffer.width - wide(kWarnings)) / 2, framebuffer.height / 5);

  renew(kHelp, content.help ? sized : "", [&] { return help(*content.help, size); });
  // In the middle, but below what warns as far as there is room: both are to be read.
  const int warned = high(kWarnings) > 0 ? panels_[kWarnings].y + high(kWarnings) + edge : 0;
  const int lowest = std::max(0, framebuffer.height - high(kHelp));
  put(kHelp, (framebuffer.width - wide(kHelp)) / 2,
      std::min(lowest, std::max(warned, (framebuffer.height - high(kHelp)) / 2)));
  return panels_;
}

}  // namespace palpate::desktop
