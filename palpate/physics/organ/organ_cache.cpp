#include "palpate/physics/organ/organ_cache.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <system_error>
#include <utility>
#include <vector>

#include "palpate/core/file.h"
#include "palpate/core/little_endian.h"
#include "palpate/core/log.h"
#include "palpate/physics/tissue/tip_field_file.h"

namespace palpate::physics::organ {
namespace {

namespace fs = std::filesystem;

constexpr Log kOrganLog("organ");
constexpr std::uint32_t kMethod = 6;  // counts up when the same input gives other figures
constexpr std::string_view kTableMagic = "PALPORG1";
constexpr std::size_t kKeyLetters = 16;
constexpr std::size_t kTableHead = kTableMagic.size() + kKeyLetters + 2 * sizeof(std::uint32_t);
constexpr std::uint32_t kMostSites = 100'000, kMostRows = 1'000'000;

void add_numbers(std::string& bytes, std::initializer_list<double> numbers) {
  for (const double number : numbers) append_little_endian(bytes, number);
}
void add_place(std::string& bytes, const Vector3& v) { add_numbers(bytes, {v.x(), v.y(), v.z()}); }

}  // namespace

std::string body_key(const scene::TriangleMesh& surface, const OrganSettings& s) {
  std::string bytes;
  append_little_endian(bytes, kMethod);
  add_numbers(bytes, {s.young_pa, s.poisson, s.element, s.site_spacing, s.support});
  add_place(bytes, s.up);
  append_little_endian(bytes, static_cast<std::uint64_t>(surface.vertices.size()));
  for (const Vector3& v : surface.vertices) add_place(bytes, v);
  for (const auto& t : surface.triangles)
    for (const std::uint32_t i : t) append_little_endian(bytes, i);
  return content_hash(bytes);
}

std::string whole_key(const std::string& body, const OrganSettings& s) {
  std::string bytes = body;
  add_numbers(bytes, {s.tip_radius, s.deepest});
  for (const Nodule& nodule : s.nodules) {
    add_place(bytes, nodule.centre);
    add_numbers(bytes, {nodule.radius, nodule.ratio});
  }
  return content_hash(bytes);
}

std::string site_table_bytes(const SiteTable& table, std::string_view key) {
  std::string bytes(kTableMagic);
  bytes += key;
  append_little_endian(bytes, static_cast<std::uint32_t>(table.moved.cols()));
  append_little_endian(bytes, static_cast<std::uint32_t>(table.moved.rows()));
  bytes.reserve(bytes.size() + table.own.size() * sizeof(double) +
                static_cast<std::size_t>(table.moved.size()) * sizeof(float) + kKeyLetters);
  for (const double number : table.own) append_little_endian(bytes, number);
  for (Eigen::Index i = 0; i < table.moved.size(); ++i) append_little_endian(bytes, table.moved.data()[i]);
  bytes += content_hash(bytes);
  return bytes;
}

Expected<SiteTable> parse_site_table(std::string_view bytes, std::string_view key, std::string_view source) {
  if (bytes.size() < kTableHead + kKeyLetters || bytes.substr(0, kTableMagic.size()) != kTableMagic)
    return refused("{}: no table of this version", source);
  const std::string_view content = bytes.substr(0, bytes.size() - kKeyLetters);
  if (content_hash(content) != bytes.substr(content.size()))
    return refused("{}: the table is damaged", source);
  if (content.substr(kTableMagic.size(), kKeyLetters) != key)
    return refused("{}: a table of another body", source);
  const char* at = content.data() + kTableMagic.size() + kKeyLetters;
  const auto sites = little_endian<std::uint32_t>(at),
             rows = little_endian<std::uint32_t>(at + sizeof(sites));
  const std::uint64_t wanted = sites * (sizeof(double) + std::uint64_t{rows} * sizeof(float));
  if (sites > kMostSites || rows > kMostRows || content.size() - kTableHead != wanted)
    return refused("{}: {} bytes for {} sites of {} rows", source, content.size(), sites, rows);
  at = content.data() + kTableHead;
  SiteTable table;
  bool finite = true;
  for (std::uint32_t i = 0; i < sites; ++i, at += sizeof(double)) {
    table.own.push_back(little_endian<double>(at));
    finite = finite && std::isfinite(table.own.back());
  }
  table.moved.resize(rows, sites);
  for (Eigen::Index i = 0; i < table.moved.size(); ++i, at += sizeof(float))
    table.moved.data()[i] = little_endian<float>(at);
  if (!finite || !table.moved.allFinite()) return refused("{}: a figure is none", source);
  return table;
}

OrganCache::OrganCache(fs::path folder) : folder_(std::move(folder)) {
  if (folder_.empty()) return;
  if (const auto made = make_folder(folder_); !made) {
    kOrganLog.warning("{}; nothing is kept", made.error().message);
    folder_.clear();
  }
}

fs::path OrganCache::path(std::string_view kind, const std::string& key) const {
  return folder_ / fmt::format("{}-{}.organ", kind, key);
}

std::optional<SiteTable> OrganCache::table(std::string_view kind, const std::string& key) const {
  if (folder_.empty() || !is_there(path(kind, key))) return std::nullopt;
  const auto file = path(kind, key);
  auto found = read_file(file).and_then([&](const std::string& bytes) -> tl::expected<SiteTable, Error> {
    return parse_site_table(bytes, key, file.string());
  });
  if (found) return std::move(*found);
  kOrganLog.warning("{}; it is computed anew", found.error().message);
  return std::nullopt;
}

std::optional<tissue::TipField> OrganCache::field(const std::string& key) const {
  if (folder_.empty() || !is_there(path("tip", key))) return std::nullopt;
  auto found = tissue::read_tip_field(path("tip", key), key);
  if (found) return std::move(*found);
  kOrganLog.warning("{}; it is computed anew", found.error().message);
  return std::nullopt;
}

void OrganCache::keep(std::string_view kind, const std::string& key, const SiteTable& table) const {
  if (folder_.empty()) return;
  if (const auto written = write_file(path(kind, key), site_table_bytes(table, key)); !written)
    kOrganLog.warning("{}; it is not kept", written.error().message);
}

void OrganCache::keep_whole(const std::string& key, const SiteTable& dent,
                            const tissue::TipField& field) const {
  if (folder_.empty()) return;
  keep("dent", key, dent);
  if (const auto written = tissue::write_tip_field(path("tip", key), field, key); !written)
    kOrganLog.warning("{}; it is not kept", written.error().message);
  let_go_of_old("dent");
  let_go_of_old("tip");
}

// Every set of nodules leaves a file.
void OrganCache::let_go_of_old(std::string_view kind) const {
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  std::error_code error;
  for (fs::directory_iterator at(folder_, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (!name.starts_with(fmt::format("{}-", kind)) || !name.ends_with(".organ")) continue;
    if (const auto written = at->last_write_time(error); !error) files.emplace_back(written, at->path());
  }
  std::sort(files.begin(), files.end());
  for (std::size_t i = 0; i + kKept < files.size(); ++i) fs::remove(files[i].second, error);
}

}  // namespace palpate::physics::organ
