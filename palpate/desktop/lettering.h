// Words on a canvas: the machine's sans-serif font (found by fontconfig, drawn by FreeType).
//
// Printable ASCII; anything else is drawn as '?'. Sizes in pixels from one baseline to the next. Refused,
// with the package's name, where the machine has no font. One thread per object.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/desktop/canvas.h"

namespace palpate::desktop {

class Lettering {
 public:
  static Expected<std::unique_ptr<Lettering>> open();
  ~Lettering();

  int line_height(int size) const;  // of one line, px
  int width(std::string_view words, int size);
  // `top` is the line's upper edge. Returns where the words end.
  int write(Canvas& canvas, int x, int top, std::string_view words, int size, const Colour& colour);

 private:
  struct Impl;
  explicit Lettering(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// Lines no wider than `width`, broken between words.
std::vector<std::string> wrapped_lines(Lettering& lettering, const std::string& words, int size, int width);

}  // namespace palpate::desktop
