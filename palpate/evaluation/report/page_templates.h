// Templates of pages: Mustache (the library is kainjow's), filled from JSON.
//
//   {{path.of.value}}, {{path | format}}  escaped; {{{...}}} as it is (format.h says what formats there are)
//   {{#path}} ... {{/path}}               for each of a list; else once, where the value is there, and not false or ""
//   {{^path}} ... {{/path}}               where it is not
//   {{>name}}                             the template name.html
//
// Beyond Mustache: formats, and that a name outside of {{#...}} and {{^...}} which nothing in the data has is an error.
// Values; one thread.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/figures/page_file.h"

namespace palpate::evaluation::report {

struct Rendered {
  std::string text;
  std::set<std::string> found;  // every path of a {{#path}} or {{^path}} that the data have
};

class PageTemplates {
 public:
  PageTemplates();  // those of share/report, which the program has inside

  // Further files, or others in the place of those of the same name.
  void add(const figures::PageFiles& files);
  void add_missing(const figures::PageFiles& files);  // only those whose names are new
  // Where `file` is there, it takes the place of another one.
  void use(const std::string& file, const std::string& in_place_of);
  Expected<void> add_folder(const std::filesystem::path& folder);

  bool has(std::string_view name) const;
  // Empty where there is no such file.
  std::string_view text(std::string_view name) const;

  // The template NAME.html. A name is looked up in the last of `data` first; `folder`: where files lie that they name.
  // Errors: wrong use for a template that is missing, is broken or takes itself in, and for one that names
  // what is not there.
  Expected<Rendered> render(std::string_view name, const std::vector<const Json*>& data,
                            const std::filesystem::path& folder) const;

 private:
  std::map<std::string, std::string, std::less<>> files_;
};

// The files of share/report and the library that draws plots.
figures::PageFiles report_files();

}  // namespace palpate::evaluation::report
