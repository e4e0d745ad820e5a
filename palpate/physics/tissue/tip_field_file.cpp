#include "palpate/physics/tissue/tip_field_file.h"

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "palpate/core/file.h"
#include "palpate/core/little_endian.h"

namespace palpate::physics::tissue {
namespace {

constexpr std::string_view kMagic = "PALPTIP1";
constexpr std::size_t kHash = 16;
constexpr std::size_t kHead = kMagic.size() + kHash + 8 * sizeof(double) + 3 * sizeof(std::uint32_t);
constexpr std::uint32_t kMostCount = 4096;

}  // namespace

Expected<void> write_tip_field(const std::filesystem::path& path, const TipField& field,
                               std::string_view key) {
  if (key.size() != kHash) throw std::invalid_argument("tip field: a key of 16 letters is expected");
  std::string bytes(kMagic);
  bytes += key;
  const TipFieldFacts& facts = field.facts();
  const Lattice& lattice = field.fields().lattice();
  for (const double number : {facts.tip_radius, facts.deepest, facts.stiffest_n_m, facts.strongest_n,
                              lattice.origin.x(), lattice.origin.y(), lattice.origin.z(), lattice.spacing})
    append_little_endian(bytes, number);
  for (const int count : lattice.count) append_little_endian(bytes, static_cast<std::uint32_t>(count));
  const std::vector<float>& coefficients = field.fields().coefficients();
  bytes.reserve(bytes.size() + coefficients.size() * sizeof(float) + kHash);
  for (const float c : coefficients) append_little_endian(bytes, c);
  bytes += content_hash(bytes);
  return write_file(path, bytes);
}

Expected<TipField> parse_tip_field(std::string_view bytes, std::string_view key, std::string_view source) {
  if (bytes.size() < kHead + kHash || bytes.substr(0, kMagic.size()) != kMagic)
    return refused("{}: no tip field of this version; build it anew", source);
  const std::string_view content = bytes.substr(0, bytes.size() - kHash);
  if (content_hash(content) != bytes.substr(content.size()))
    return refused("{}: the tip field is damaged; build it anew", source);
  if (content.substr(kMagic.size(), kHash) != key)
    return refused("{}: a tip field of another body, tip or method; build it anew", source);
  const char* at = content.data() + kMagic.size() + kHash;
  const auto number = [&] {
    const auto value = little_endian<double>(at);
    at += sizeof(double);
    return value;
  };
  TipFieldFacts facts;
  facts.tip_radius = number();
  facts.deepest = number();
  facts.stiffest_n_m = number();
  facts.strongest_n = number();
  Lattice lattice;
  for (Eigen::Index i = 0; i < 3; ++i) lattice.origin[i] = number();
  lattice.spacing = number();
  for (int& count : lattice.count) {
    const auto stored = little_endian<std::uint32_t>(at);
    at += sizeof(std::uint32_t);
    if (stored > kMostCount)
      return refused("{}: a lattice of {} points along an axis; build it anew", source, stored);
    count = static_cast<int>(stored);
  }
  if ((content.size() - kHead) != 2 * sizeof(float) * lattice.size())
    return refused("{}: {} bytes for a lattice of {} points; build it anew", source, content.size() - kHead,
                   lattice.size());
  std::vector<float> coefficients(2 * lattice.size());
  for (float& c : coefficients) {
    c = little_endian<float>(at);
    at += sizeof(float);
  }
  try {
    return TipField(facts, SplineFields<2>(lattice, std::move(coefficients)));
  } catch (const std::invalid_argument& e) {
    return refused("{}: {}; build it anew", source, e.what());
  }
}

Expected<TipField> read_tip_field(const std::filesystem::path& path, std::string_view key) {
  const auto bytes = read_file(path, kMostTissueBytes + kHead + kHash);
  if (!bytes) return tl::unexpected<Error>(bytes.error());
  return parse_tip_field(*bytes, key, path.string());
}

}  // namespace palpate::physics::tissue
