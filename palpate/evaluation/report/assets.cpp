#include "palpate/evaluation/report/assets.h"

// The assembler copies each file between two symbols of ours in the read-only data.
#define PALPATE_EMBED(name, file)               \
  asm(".pushsection .rodata\n"                  \
      ".balign 16\n"                            \
      "palpate_asset_" #name                    \
      ":\n"                                     \
      ".incbin \"" file                         \
      "\"\n"                                    \
      "palpate_asset_" #name                    \
      "_end:\n"                                 \
      ".byte 0\n"                               \
      ".popsection\n");                         \
  extern "C" const char palpate_asset_##name[]; \
  extern "C" const char palpate_asset_##name##_end[];

PALPATE_EMBED(plotly, PALPATE_PLOTLY_FILE)
PALPATE_EMBED(css, PALPATE_CSS_FILE)
PALPATE_EMBED(js, PALPATE_JS_FILE)

namespace palpate::evaluation::report {

std::string_view plotly_js() { return {palpate_asset_plotly, palpate_asset_plotly_end}; }
std::string_view page_css() { return {palpate_asset_css, palpate_asset_css_end}; }
std::string_view page_js() { return {palpate_asset_js, palpate_asset_js_end}; }

}  // namespace palpate::evaluation::report
