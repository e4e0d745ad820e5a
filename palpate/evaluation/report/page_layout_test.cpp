// What a browser makes of the page's style: does everything find its place, on a desk as on a telephone?
#ifdef PALPATE_CHROMIUM

#include <gtest/gtest.h>

#include <cstdio>

#include "palpate/core/base64.h"
#include "palpate/core/file.h"
#include "palpate/evaluation/report/format.h"
#include "palpate/evaluation/report/page.h"
#include "tests/scratch_folder.h"

namespace palpate::evaluation::report {
namespace {

// A black picture of `width` x 3 pixels, one bit each; `check` is what the header's checksum is then.
std::string black_picture(char width, std::string_view check) {
  std::string png("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0", 19);
  png += width;
  png += std::string("\0\0\0\x03\x01\0\0\0\0", 9);
  png += check;
  png += std::string("\0\0\0\x0bIDAT\x78\xda\x63\x60\x00\x01\0\0\x06\0\x01\x6d\x28\x10\x2f", 23);
  return png + std::string("\0\0\0\0IEND\xae\x42\x60\x82", 12);
}
const std::string kWide = black_picture(8, "\x86\xb3\x73\xe5"), kUsual = black_picture(4, "\x9c\x8f\x93\x6b");

// For each of these widths of a window: `expression`, JavaScript of the page's document `d`, as text, a line
// each.
std::string asked_of(std::string_view body, const Json& data, std::initializer_list<int> widths_px,
                     const std::string& expression) {
  PageTemplates templates;
  templates.add({{"mine.html", body}});
  const auto page = page_of(data, templates, {});
  if (!page) return page.error().message;
  templates.add({{"escaped.html", "{{text}}"}});
  const Json text{{"text", page->text}};
  const std::string escaped = templates.render("escaped", {&text}, {}).value().text;
  const ScratchFolder folder;
  std::string frame = "<!doctype html>";
  for (const int width : widths_px)
    frame += fmt::format("<iframe width=\"{}\" height=\"900\" srcdoc=\"{}\"></iframe>", width, escaped);
  frame += fmt::format(
      "<script>addEventListener('load', () => document.documentElement.dataset.answer =\n"
      "[...document.querySelectorAll('iframe')].map((f) => {{ const d = f.contentDocument;\n"
      "return f.width + ': ' + String({}) }}).join('\\n'));</script>",
      expression);
  if (!write_file(folder.path() / "frame.html", frame)) return "not written";
  const std::string command = fmt::format(PALPATE_CHROMIUM
                                          " --headless --no-sandbox --disable-gpu --disable-dev-shm-usage "
                                          "--host-resolver-rules='MAP * ~NOTFOUND' "
                                          "--user-data-dir='{0}/profile' --virtual-time-budget=5000 "
                                          "--dump-dom 'file://{0}/frame.html' 2> /dev/null",
                                          folder.path().string());
  std::FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return "no browser";
  std::string dom;
  char buffer[65536];
  for (std::size_t n; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) dom.append(buffer, n);
  ::pclose(pipe);
  const std::string mark = "data-answer=\"";
  const auto at = dom.find(mark);
  if (at == std::string::npos) return "no answer";
  return dom.substr(at + mark.size(), dom.find('"', at + mark.size()) - at - mark.size());
}

TEST(PageLayout, TilesHoldTheirFiguresOnScreensOfEverySize) {
  const std::string change = "2.62\u00a0mm \u2192 0.154\u00a0mm";
  const std::vector<figures::Figure> figures{
      {"Against the tracker", change, "before and after", figures::Verdict::none},
      {"Error", "0.1\u00a0mm", "", figures::Verdict::none},
      {"Late", "1234567\u00a0of\u00a01234567\u00a0ticks", "", figures::Verdict::none},
      {"Poses", "70", "", figures::Verdict::none}};
  EXPECT_EQ(asked_of("<div class=\"cards\">{{>cards}}</div>",
                     {{"kind", "mine"}, {"figures", json_of(figures)}}, {1400, 1000, 700, 400},
                     "[...d.querySelectorAll('.card')].filter((c) => c.scrollWidth > c.clientWidth).length "
                     "+ ' of ' + d.querySelectorAll('.card').length + ', page over by ' "
                     "+ Math.max(0, d.documentElement.scrollWidth - d.documentElement.clientWidth)"),
            "1400: 0 of 4, page over by 0\n1000: 0 of 4, page over by 0\n700: 0 of 4, page over by 0\n"
            "400: 0 of 4, page over by 0");
}

// Two pictures for two eyes, then such a one beside one from the side: no row has a hole.
TEST(PageLayout, PicturesOfDifferentShapesFillTheirRows) {
  const std::string
      row = "<div class=\"picture-row\">{}{}</div>",
      picture =
          "<figure class=\"picture\" style=\"--shape: {}\"><img src=\"data:image/png;base64,{}\"></figure>";
  const std::string wide = fmt::format(fmt::runtime(picture), 8.0 / 3.0, base64(kWide)),
                    usual = fmt::format(fmt::runtime(picture), 4.0 / 3.0, base64(kUsual));
  const std::string page =
      fmt::format(fmt::runtime(row), wide, wide) + fmt::format(fmt::runtime(row), wide, usual);
  const Json data{{"kind", "mine"}};
  const std::string row_by_row =
      "[...d.querySelectorAll('.picture-row')].map((r) => {\n"
      "const b = [...r.querySelectorAll('img')].map((i) => i.getBoundingClientRect());\n"
      "return (Math.abs(b[0].height - b[1].height) < 1.5) + ' ' + Math.round(b[1].width / b[0].width * 10) + "
      "' ' "
      "+ (Math.abs(b[1].right - r.getBoundingClientRect().right) < 1) }).join(', ')";
  EXPECT_EQ(asked_of(page, data, {1400, 1000}, row_by_row),
            "1400: true 10 true, true 5 true\n1000: true 10 true, true 5 true");
  // One below the other on a telephone, each as wide as the page.
  EXPECT_EQ(asked_of(page, data, {400},
                     "new Set([...d.querySelectorAll('img')].map((i) => Math.round(i.width))).size + ' ' + "
                     "new Set([...d.querySelectorAll('img')].map((i) => Math.round(i.x))).size"),
            "400: 1 1");
}

}  // namespace
}  // namespace palpate::evaluation::report
#endif
