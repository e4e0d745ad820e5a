// A report: what a program has measured, as JSON that other programs can read (report.json, docs/report.md), and a page
// made of it by templates, in one file that loads nothing (report.html).
//
// The page of a report of the kind K is the template K.html: a <header> with the title as <h1>, then sections, each begun
// by an <h2 id="...">. Titles give the page's list of contents. Around them comes page.html, with page.css and page.js.
// The page follows the reader's light or dark setting and reads on a phone and on paper. One thread.
#pragma once

#include <filesystem>
#include <string>

#include "palpate/evaluation/report/page_templates.h"
#include "palpate/figures/section.h"

namespace palpate::evaluation::report {

// Names are looked up in the report, then in its "summary". Errors: as PageTemplates::render().
Expected<Rendered> page_of(const Json& report, const PageTemplates& templates,
                           const std::filesystem::path& folder);

// folder/report.json, then folder/report.html.
Expected<void> write_report(const Json& report, const PageTemplates& templates,
                            const std::filesystem::path& folder);

// For sections.html: key figures, and sections of a page that stand as data.
Json json_of(const std::vector<figures::Figure>& figures);
Json json_of(const std::vector<figures::Section>& sections);

}  // namespace palpate::evaluation::report
