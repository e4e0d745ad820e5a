// What has been prepared of an organ, in a folder: a file for each part, under the hash of all that it was made of.
//
// body-KEY.organ and dent-KEY.organ hold a SiteTable: "PALPORG1", the key (16 letters), counts of sites and rows
// (uint32), own figures (doubles), moved (floats, column by column), and at the end the content_hash of all that, 16
// letters; little-endian. tip-KEY.organ is a tip field (tissue/tip_field_file.h). Files are written whole or not at all.
// One that is damaged is named in the log and counts as none, and so does a folder that cannot be written. Of parts with
// nodules the newest are kept. Any thread.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "palpate/physics/organ/prepared_organ.h"
#include "palpate/physics/organ/site_table.h"
#include "palpate/physics/tissue/tip_field.h"

namespace palpate::physics::organ {

// Of all that the homogeneous body's answers, and of all that the whole depend on.
std::string body_key(const scene::TriangleMesh& surface, const OrganSettings& settings);
std::string whole_key(const std::string& body, const OrganSettings& settings);

class OrganCache {
 public:
  static constexpr std::size_t kKept = 12;  // of parts with nodules, of each kind

  // Empty: nothing is kept. Makes the folder.
  explicit OrganCache(std::filesystem::path folder);

  std::optional<SiteTable> body(const std::string& key) const { return table("body", key); }
  std::optional<SiteTable> dent(const std::string& key) const { return table("dent", key); }
  std::optional<tissue::TipField> field(const std::string& key) const;
  void keep_body(const std::string& key, const SiteTable& table) const { keep("body", key, table); }
  void keep_whole(const std::string& key, const SiteTable& dent, const tissue::TipField& field) const;

 private:
  std::filesystem::path path(std::string_view kind, const std::string& key) const;
  std::optional<SiteTable> table(std::string_view kind, const std::string& key) const;
  void keep(std::string_view kind, const std::string& key, const SiteTable& table) const;
  void let_go_of_old(std::string_view kind) const;

  std::filesystem::path folder_;
};

// The table in a file's bytes, whose source the words name. Refused: another key, damaged.
Expected<SiteTable> parse_site_table(std::string_view bytes, std::string_view key, std::string_view source);
std::string site_table_bytes(const SiteTable& table, std::string_view key);

}  // namespace palpate::physics::organ
