// PLY: a header that names elements and their properties, then the elements, as text or as little-endian
// bytes. Read are x, y, z of `vertex` and the list vertex_indices (or vertex_index) of `face`.
#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/core/little_endian.h"
#include "palpate/core/text.h"
#include "palpate/scene/mesh_file.h"
#include "palpate/scene/mesh_text.h"

namespace palpate::scene {
namespace {

enum class Number { i8, u8, i16, u16, i32, u32, f32, f64 };

std::optional<Number> number_type(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, Number>, 16> kNames{{{"char", Number::i8},
                                                                        {"int8", Number::i8},
                                                                        {"uchar", Number::u8},
                                                                        {"uint8", Number::u8},
                                                                        {"short", Number::i16},
                                                                        {"int16", Number::i16},
                                                                        {"ushort", Number::u16},
                                                                        {"uint16", Number::u16},
                                                                        {"int", Number::i32},
                                                                        {"int32", Number::i32},
                                                                        {"uint", Number::u32},
                                                                        {"uint32", Number::u32},
                                                                        {"float", Number::f32},
                                                                        {"float32", Number::f32},
                                                                        {"double", Number::f64},
                                                                        {"float64", Number::f64}}};
  for (const auto& [known, type] : kNames)
    if (name == known) return type;
  return std::nullopt;
}

struct Property {
  std::string name;
  Number type = Number::f32;
  std::optional<Number> length;  // of a list
};
struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};
struct Header {
  bool text = true;
  std::vector<Element> elements;
};

// The numbers after the header, one after the other; nothing where they end or are none.
class Numbers {
 public:
  Numbers(std::string_view content, bool text) : rest_(content), text_(text) {}
  std::optional<double> next(Number type) {
    if (text_) return next_word();
    switch (type) {
      case Number::i8:
        return bytes<std::int8_t>();
      case Number::u8:
        return bytes<std::uint8_t>();
      case Number::i16:
        return bytes<std::int16_t>();
      case Number::u16:
        return bytes<std::uint16_t>();
      case Number::i32:
        return bytes<std::int32_t>();
      case Number::u32:
        return bytes<std::uint32_t>();
      case Number::f32:
        return bytes<float>();
      case Number::f64:
        return bytes<double>();
    }
    return std::nullopt;
  }

 private:
  template <typename T>
  std::optional<double> bytes() {
    if (rest_.size() < sizeof(T)) return std::nullopt;
    const auto value = static_cast<double>(little_endian<T>(rest_.data()));
    rest_.remove_prefix(sizeof(T));
    return value;
  }
  std::optional<double> next_word() {
    const auto begin = std::min(rest_.find_first_not_of(" \t\r\n"), rest_.size());
    rest_.remove_prefix(begin);
    const auto end = std::min(rest_.find_first_of(" \t\r\n"), rest_.size());
    const auto value = mesh_text::number<double>(rest_.substr(0, end));
    rest_.remove_prefix(end);
    return value;
  }
  std::string_view rest_;
  bool text_;
};

Expected<Header> parse_ply_header(mesh_text::Lines& lines, const std::string& source) {
  Header header;
  bool format = false;
  std::string_view line;
  while (lines.next(line)) {
    const auto whole = line;
    const auto key = mesh_text::word(line);
    const auto unexpected = [&](const char* expected) {
      return wrong_use("{}:{}: '{}' where {} is expected; repair the line", source, lines.number(),
                       excerpt(whole), expected);
    };
    if (key.empty() || key == "ply" || key == "comment" || key == "obj_info") continue;
    if (key == "end_header") {
      if (!format) return unexpected("a line format before it");
      return header;
    }
    if (key == "format") {
      const auto form = mesh_text::word(line);
      if (form != "ascii" && form != "binary_little_endian")
        return wrong_use("{}:{}: format '{}'; ascii or binary_little_endian is expected, export it anew",
                         source, lines.number(), excerpt(form));
      header.text = form == "ascii";
      format = true;
    } else if (key == "element") {
      Element element;
      element.name = std::string(mesh_text::word(line));
      const auto count = mesh_text::number<std::uint64_t>(mesh_text::word(line));
      if (element.name.empty() || !count) return unexpected("element NAME COUNT");
      if (*count > 3 * kMostTriangles)
        return wrong_use("{}:{}: {} elements '{}', at most {} are expected; make it coarser", source,
                         lines.number(), *count, excerpt(element.name), 3 * kMostTriangles);
      element.count = *count;
      header.elements.push_back(std::move(element));
    } else if (key == "property") {
      if (header.elements.empty()) return unexpected("element NAME COUNT");
      Property property;
      auto type = mesh_text::word(line);
      if (type == "list") {
        property.length = number_type(mesh_text::word(line));
        if (!property.length) return unexpected("property list TYPE TYPE NAME");
        type = mesh_text::word(line);
      }
      const auto known = number_type(type);
      property.name = std::string(mesh_text::word(line));
      if (!known || property.name.empty()) return unexpected("property TYPE NAME");
      property.type = *known;
      header.elements.back().properties.push_back(std::move(property));
    } else {
      return unexpected("element, property or end_header");
    }
  }
  return wrong_use("{}: has no end_header; it is cut off, copy it again", source);
}

bool is_corner_list(const Property& p) {
  return p.length && (p.name == "vertex_indices" || p.name == "vertex_index");
}

}  // namespace

Expected<TriangleMesh> parse_ply(std::string_view content, const std::string& source) {
  mesh_text::Lines lines(content);
  const auto header = parse_ply_header(lines, source);
  if (!header) return tl::unexpected(header.error());
  TriangleMesh mesh;
  Numbers numbers(lines.rest(), header->text);
  std::vector<double> corners;
  bool has_corners = false;
  for (const auto& element : header->elements) {
    const bool vertex = element.name == "vertex", face = element.name == "face";
    std::size_t axes = 0;
    for (const auto& p : element.properties) {
      axes += vertex && !p.length && p.name.size() == 1 && std::string_view("xyz").find(p.name) < 3;
      has_corners = has_corners || (face && is_corner_list(p));
    }
    if (vertex && axes != 3)
      return wrong_use("{}: its vertices have {} of the properties x, y, z; each once is expected", source,
                       axes);
    // An element without properties takes no bytes: its count could not be believed.
    if (element.properties.empty() && element.count > 0)
      return wrong_use("{}: element '{}' has no properties; at least one is expected", source,
                       excerpt(element.name));
    for (std::size_t i = 0; i < element.count; ++i) {
      const auto cut_off = [&] {
        return wrong_use("{}: {} '{}' {} of {} is cut off or no number; copy it again or repair it", source,
                         "element", excerpt(element.name), i + 1, element.count);
      };
      Vector3 place = Vector3::Zero();
      for (const auto& p : element.properties) {
        double length = 1.0;
        if (p.length) {
          const auto said = numbers.next(*p.length);
          if (!said || !(*said >= 0.0) || *said > 4294967295.0 || *said != std::floor(*said))
            return cut_off();
          length = *said;
        }
        corners.clear();
        for (double k = 0.0; k < length; k += 1.0) {
          const auto value = numbers.next(p.type);
          if (!value) return cut_off();
          if (face && is_corner_list(p)) corners.push_back(*value);
          if (vertex && !p.length && p.name.size() == 1)
            if (const auto axis = std::string_view("xyz").find(p.name); axis < 3)
              place[static_cast<Eigen::Index>(axis)] = *value;
        }
        if (!(face && is_corner_list(p))) continue;
        if (corners.size() < 3)
          return wrong_use("{}: face {} has {}; at least 3 are expected", source, i + 1,
                           counted(corners.size(), "corner"));
        for (const double c : corners)
          if (!(c >= 0.0) || c != std::floor(c) || c >= static_cast<double>(mesh.vertices.size()))
            return wrong_use("{}: face {} has the corner {}; 0 to {} is expected, the vertices before it",
                             source, i + 1, c, static_cast<double>(mesh.vertices.size()) - 1.0);
        for (std::size_t k = 2; k < corners.size(); ++k)
          mesh.triangles.push_back({static_cast<std::uint32_t>(corners[0]),
                                    static_cast<std::uint32_t>(corners[k - 1]),
                                    static_cast<std::uint32_t>(corners[k])});
        if (mesh.triangles.size() > kMostTriangles)
          return wrong_use("{}: holds more than {} triangles; make it coarser", source, kMostTriangles);
      }
      if (vertex) mesh.vertices.push_back(place);
    }
  }
  if (!has_corners)
    return wrong_use("{}: its faces have no list vertex_indices, which is needed; export triangles", source);
  return mesh;
}

}  // namespace palpate::scene
