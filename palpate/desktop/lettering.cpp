#include "palpate/desktop/lettering.h"

#include <fontconfig/fontconfig.h>
#include <ft2build.h>
#include FT_FREETYPE_H

#include <cmath>
#include <string>
#include <vector>

namespace palpate::desktop {
namespace {

constexpr double kLine = 1.3;       // line height over letter size
constexpr double kBaseline = 0.98;  // from the line's upper edge, in letter sizes

// The file of a plain sans-serif font, empty where there is none.
std::string font_file() {
  FcConfig* config = FcInitLoadConfigAndFonts();
  if (config == nullptr) return "";
  std::string found;
  FcPattern* wanted = FcNameParse(reinterpret_cast<const FcChar8*>("DejaVu Sans,sans-serif:scalable=true"));
  FcConfigSubstitute(config, wanted, FcMatchPattern);
  FcDefaultSubstitute(wanted);
  FcResult result = FcResultNoMatch;
  if (FcPattern* match = FcFontMatch(config, wanted, &result)) {
    FcChar8* file = nullptr;
    if (FcPatternGetString(match, FC_FILE, 0, &file) == FcResultMatch)
      found = reinterpret_cast<const char*>(file);
    FcPatternDestroy(match);
  }
  FcPatternDestroy(wanted);
  FcConfigDestroy(config);
  return found;
}

}  // namespace

struct Lettering::Impl {
  FT_Library library = nullptr;
  FT_Face face = nullptr;
  struct Glyph {
    int left = 0, top = 0, width = 0, height = 0, advance = 0;
    std::vector<std::uint8_t> cover;
  };
  std::map<std::pair<int, char>, Glyph> glyphs;

  ~Impl() {
    if (face != nullptr) FT_Done_Face(face);
    if (library != nullptr) FT_Done_FreeType(library);
  }

  const Glyph& glyph(char letter, int size) {
    if (letter < 32 || letter > 126) letter = '?';
    const auto key = std::pair(size, letter);
    if (const auto known = glyphs.find(key); known != glyphs.end()) return known->second;
    Glyph& made = glyphs[key];
    FT_Set_Pixel_Sizes(face, 0, static_cast<FT_UInt>(std::max(1, size)));
    if (FT_Load_Char(face, static_cast<FT_ULong>(letter), FT_LOAD_RENDER) != 0) return made;
    const FT_GlyphSlot slot = face->glyph;
    made.left = slot->bitmap_left;
    made.top = slot->bitmap_top;
    made.width = static_cast<int>(slot->bitmap.width);
    made.height = static_cast<int>(slot->bitmap.rows);
    made.advance = static_cast<int>(slot->advance.x >> 6);  // 26.6 fixed point
    for (int row = 0; row < made.height; ++row) {
      const unsigned char* from = slot->bitmap.buffer + row * slot->bitmap.pitch;
      made.cover.insert(made.cover.end(), from, from + made.width);
    }
    return made;
  }
};

Expected<std::unique_ptr<Lettering>> Lettering::open() {
  const std::string file = font_file();
  auto impl = std::make_unique<Impl>();
  if (file.empty() || FT_Init_FreeType(&impl->library) != 0 ||
      FT_New_Face(impl->library, file.c_str(), 0, &impl->face) != 0)
    return refused("window: no font to write with{}; install the package fonts-dejavu-core",
                   file.empty() ? "" : " (" + file + " cannot be read)");
  return std::unique_ptr<Lettering>(new Lettering(std::move(impl)));
}

Lettering::Lettering(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Lettering::~Lettering() = default;

int Lettering::line_height(int size) const { return static_cast<int>(std::lround(kLine * size)); }

int Lettering::width(std::string_view words, int size) {
  int sum = 0;
  for (const char letter : words) sum += impl_->glyph(letter, size).advance;
  return sum;
}

int Lettering::write(Canvas& canvas, int x, int top, std::string_view words, int size, const Colour& colour) {
  const int baseline = top + static_cast<int>(std::lround(kBaseline * size));
  for (const char letter : words) {
    const Impl::Glyph& glyph = impl_->glyph(letter, size);
    for (int row = 0; row < glyph.height; ++row)
      for (int column = 0; column < glyph.width; ++column)
        canvas.lay(x + glyph.left + column, baseline - glyph.top + row, colour,
                   glyph.cover[static_cast<std::size_t>(row * glyph.width + column)]);
    x += glyph.advance;
  }
  return x;
}

std::vector<std::string> wrapped_lines(Lettering& lettering, const std::string& words, int size, int width) {
  std::vector<std::string> lines(1);
  std::size_t at = 0;
  while (at < words.size()) {
    const std::size_t end = std::min(words.find(' ', at), words.size());
    const std::string word = words.substr(at, end - at);
    const std::string longer = lines.back().empty() ? word : lines.back() + ' ' + word;
    if (!lines.back().empty() && lettering.width(longer, size) > width)
      lines.push_back(word);
    else
      lines.back() = longer;
    at = end + 1;
  }
  return lines;
}

}  // namespace palpate::desktop
