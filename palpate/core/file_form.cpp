#include "palpate/core/file_form.h"

#include <algorithm>
#include <array>

namespace palpate::inline core {
namespace {

constexpr std::size_t kHead = 4096;  // bytes that are looked at, however long the file is
constexpr std::string_view kDigits = "0123456789";

struct Words {
  FileForm form;
  std::string_view is;
  std::string_view remedy;  // where a table is expected
};

constexpr std::array kWords = {
    Words{FileForm::binary, "is not a text file", "a CSV table is expected"},
    Words{FileForm::commas, "is a table of cells with commas", ""},
    Words{FileForm::blanks, "is separated by blanks", "commas between the cells are expected"},
    Words{FileForm::tabs, "is separated by tabs", "commas between the cells are expected, save it as CSV"},
    Words{FileForm::semicolons, "is separated by semicolons",
          "commas between the cells are expected, save it as CSV"},
    Words{FileForm::decimal_commas, "has decimal commas, and other separators between its cells",
          "decimal points, and commas between the cells, are expected"},
    Words{FileForm::json, "is JSON",
          "a table is expected, save it as CSV: a line of names, then rows of numbers"},
    Words{FileForm::xml, "is XML or a web page", "the data themselves are expected, as CSV"},
    Words{FileForm::nrrd, "is an NRRD file",
          "a table is expected; a sequence of transforms goes where poses are asked for"},
    Words{FileForm::metaimage, "is a MetaImage file (.mha)",
          "a table is expected; a sequence of transforms goes where poses are asked for"},
    Words{
        FileForm::fiducials, "is a list of markups of 3D Slicer (.fcsv)",
        "a header is expected: one line of names in place of its comments, x_mm,y_mm,z_mm second to fourth"},
    Words{FileForm::itk_transform, "is a transform of ITK or 3D Slicer (.tfm, .txt), which is not read",
          "poses are expected as a table, or as a folder of text files of 4x4 numbers each"},
    Words{FileForm::ndi, "is an export of NDI's programs",
          "keep one tool's columns, name them qw,qx,qy,qz,x_mm,y_mm,z_mm, and remove rows in which it is "
          "missing"},
    Words{FileForm::rig, "is a rig file (--rig FILE)", "a table with commas is expected"},
    Words{FileForm::toml, "is a TOML file (a world, settings, a board)", "a table with commas is expected"},
};

const Words* entry_of(FileForm form) {
  const auto at =
      std::find_if(kWords.begin(), kWords.end(), [&](const auto& words) { return words.form == form; });
  return at == kWords.end() ? nullptr : &*at;
}

std::string_view without_ends(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") + 1 - first);
}

// The first two lines that hold something and are no comments; empty where there are fewer.
std::array<std::string_view, 2> first_lines(std::string_view head) {
  std::array<std::string_view, 2> lines;
  std::size_t found = 0;
  while (!head.empty() && found < lines.size()) {
    const auto end = head.find('\n');
    const auto line = without_ends(head.substr(0, end));
    head.remove_prefix(end == std::string_view::npos ? head.size() : end + 1);
    if (!line.empty() && line.front() != '#') lines[found++] = line;
  }
  return lines;
}

bool is_digit(char c) { return kDigits.find(c) != std::string_view::npos; }

// Commas in `line` that stand between two digits, and those that do not.
struct Commas {
  bool decimal = false, other = false;
};
Commas commas_of(std::string_view line) {
  Commas found;
  for (auto at = line.find(','); at != std::string_view::npos; at = line.find(',', at + 1))
    (at > 0 && at + 1 < line.size() && is_digit(line[at - 1]) && is_digit(line[at + 1]) ? found.decimal
                                                                                        : found.other) = true;
  return found;
}

// Two numbers or more with blanks between them, and no comma.
bool is_row_with_blanks(std::string_view line) {
  if (line.find_first_not_of("0123456789+-.eEnaNA \t") != std::string_view::npos) return false;
  std::size_t numbers = 0;
  while (!line.empty()) {
    const auto word = line.substr(0, line.find_first_of(" \t"));
    const bool missing = word == "nan" || word == "NaN" || word == "NA";
    if (!word.empty() && !missing && word.find_first_of(kDigits) == std::string_view::npos) return false;
    numbers += word.empty() ? 0 : 1;
    line.remove_prefix(std::min(line.size(), word.size() + 1));
  }
  return numbers >= 2;
}

// Both lines are cut into equally many cells by `separator`, and no comma could do so as well.
bool is_separated_by(char separator, const std::array<std::string_view, 2>& lines) {
  const auto count = [&](std::string_view line) { return std::count(line.begin(), line.end(), separator); };
  return count(lines[0]) > 0 && (lines[1].empty() || count(lines[0]) == count(lines[1])) &&
         !commas_of(lines[0]).other;
}

// Lists of TOML and of JSON both begin with a bracket: a name follows in TOML, which begins with no digit here.
bool is_json(std::string_view line) {
  if (line.starts_with('{')) return true;
  const auto first = line.find_first_not_of("[ ");
  if (first == 0 || !line.starts_with('[')) return false;
  return first == std::string_view::npos || line.find_first_of("{\"-0123456789", first) == first;
}

bool is_line_of_toml(std::string_view line) {
  if (line.starts_with('['))
    return line.find(']') != std::string_view::npos && line.find(',') == std::string_view::npos;
  const auto equals = line.find('=');
  if (equals == std::string_view::npos || equals == 0) return false;
  const auto key = without_ends(line.substr(0, equals));
  return std::all_of(key.begin(), key.end(), [](char c) {
    return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '.' ||
           c == '-';
  });
}

// "Port 1: 8700340" names a tool; other exports of theirs name a pose's columns Q0, Qx ... and Tx, Ty, Tz. Such
// columns may stand in a table of ours beside those that are read.
bool is_ndi(std::string_view line) {
  const auto holds = [&](std::string_view name) { return line.find(name) != std::string_view::npos; };
  if (holds("x_m")) return false;
  if (holds("Q0,Qx,Qy,Qz") && holds("Tx,Ty,Tz")) return true;
  for (auto at = line.find("Port "); at != std::string_view::npos; at = line.find("Port ", at + 1)) {
    const auto number = line.substr(at + 5);
    const auto end = number.find_first_not_of(kDigits);
    if (end != 0 && end != std::string_view::npos && number[end] == ':') return true;
  }
  return false;
}

bool has_line_of(std::string_view head, std::string_view key) {
  for (auto at = head.find(key); at != std::string_view::npos; at = head.find(key, at + 1))
    if (at == 0 || head[at - 1] == '\n') return true;
  return false;
}

bool looks_binary(std::string_view head) {
  return std::any_of(head.begin(), head.end(), [](char c) {
    const auto u = static_cast<unsigned char>(c);
    return u < 9 || (u > 13 && u < 32) || u == 127;
  });
}

}  // namespace

std::string_view without_byte_order_mark(std::string_view content) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  if (content.starts_with(kMark)) content.remove_prefix(kMark.size());
  return content;
}

FileForm form_of(std::string_view content) {
  const auto head = without_byte_order_mark(content).substr(0, kHead);
  if (head.starts_with("NRRD00")) return FileForm::nrrd;
  if (head.starts_with("# Markups fiducial")) return FileForm::fiducials;
  if (head.starts_with("#Insight Transform File")) return FileForm::itk_transform;
  if (head.starts_with("ObjectType =")) return FileForm::metaimage;
  if (looks_binary(head)) return FileForm::binary;
  const auto lines = first_lines(head);
  const auto& line = lines[0];
  if (line.starts_with('<')) return FileForm::xml;
  if (is_json(line)) return FileForm::json;
  if (is_ndi(line)) return FileForm::ndi;
  if (is_line_of_toml(line)) return has_line_of(head, "rig_version") ? FileForm::rig : FileForm::toml;
  const bool decimal = commas_of(line).decimal || commas_of(lines[1]).decimal;
  if (is_separated_by(';', lines)) return decimal ? FileForm::decimal_commas : FileForm::semicolons;
  if (is_separated_by('\t', lines)) return decimal ? FileForm::decimal_commas : FileForm::tabs;
  const auto commas = std::count(line.begin(), line.end(), ',');
  if (commas > 0 && (lines[1].empty() || commas == std::count(lines[1].begin(), lines[1].end(), ',')))
    return FileForm::commas;
  if (is_row_with_blanks(line) || is_row_with_blanks(lines[1])) return FileForm::blanks;
  return FileForm::unknown;
}

bool is_toml(FileForm form) { return form == FileForm::rig || form == FileForm::toml; }

std::string_view words_of(FileForm form) {
  const auto* words = entry_of(form);
  return words == nullptr ? std::string_view() : words->is;
}

Expected<void> may_be_text(std::string_view content, const std::string& source) {
  struct Kind {
    std::string_view begins;
    const char* words;
  };
  constexpr Kind kKinds[] = {
      {"MATLAB 5.0 MAT-file",
       "a file of MATLAB (.mat), which is not read; save -ascii, or writematrix, makes a text of it"},
      {"\x89HDF", "an HDF5 file (.h5, .mat of version 7.3), which is not read; save it as text"},
      {"PK\x03\x04", "a ZIP archive (.npz, .xlsx), which is not read; save it as text, or one array as .npy"},
      {"\x1f\x8b", "packed by gzip; unpack it first (gunzip)"},
      {"\xff\xfe", "text in UTF-16, as Excel and PowerShell save it; save it as UTF-8"},
      {"\xfe\xff", "text in UTF-16; save it as UTF-8"},
  };
  for (const auto& kind : kKinds)
    if (content.starts_with(kind.begins)) return wrong_use("{}: is {}", source, kind.words);
  return {};
}

Expected<void> may_be_table(std::string_view content, const std::string& source) {
  if (const auto fine = may_be_text(content, source); !fine) return fine;
  const auto form = form_of(content);
  if (form == FileForm::unknown || form == FileForm::commas) return {};
  const auto* words = entry_of(form);
  return wrong_use("{}: {}; {}", source, words->is, words->remedy);
}

}  // namespace palpate::inline core
