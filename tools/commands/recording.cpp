#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "palpate/core/csv.h"
#include "palpate/core/file.h"
#include "palpate/core/json.h"
#include "palpate/core/text.h"
#include "palpate/device/marker_names.h"
#include "palpate/record/byte_source.h"
#include "palpate/record/mcap_reader.h"
#include "palpate/record/recording_copy.h"
#include "palpate/record/recording_info.h"
#include "palpate/record/recording_merge.h"
#include "palpate/record/session/export_sequence.h"
#include "palpate/record/session/export_tables.h"
#include "palpate/record/session/recorded_tables.h"
#include "palpate/rig/rig.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/drivers.h"

namespace palpate::tools::commands {
namespace {

struct RecordingArguments {
  std::string file, out, json;
  std::vector<std::filesystem::path> files;
  std::string csv, tum, attachments;
  std::string sequence, camera = "left";
  std::vector<std::string> names;  // MARKER=Name
  std::string rig;
  record::Cut cut{0.0, std::numeric_limits<double>::infinity(), {}};
};

Expected<void> show_info(const RecordingArguments& options) {
  const auto source = record::open_source(options.file);
  if (!source) return tl::unexpected(source.error());
  const auto info = record::info(**source);
  if (!info) return tl::unexpected(info.error());
  if (!options.json.empty())
    if (auto written = write_json(options.json, record::info_json(*info)); !written) return written;
  if (options.json == "-") return {};
  const auto& scanned = info->scanned;
  print_line(fmt::format("recording    {}", options.file));
  print_line(fmt::format("written by   {}", excerpt(scanned.header.library, 100)));
  print_line(fmt::format("holds        {:.3f} s, {}, {}, {}", info->seconds,
                         counted(info->streams.size(), "stream"), counted(scanned.found.messages, "message"),
                         counted(scanned.found.attachments, "attachment")));
  constexpr std::uint64_t kTellRate = 10;  // messages; the distance of a few is no rate
  for (const auto& stream : info->streams)
    print_line(fmt::format("stream       {:<32} {:>9} messages {:>12}{}", excerpt(stream.name, 100),
                           stream.messages,
                           stream.messages < kTellRate ? "" : fmt::format("{:.2f} Hz", stream.rate_hz),
                           stream.dropped == 0 ? "" : fmt::format("  {} dropped", stream.dropped)));
  print_line(scanned.complete ? "whole        yes"
                              : fmt::format("whole        no{}; palpate recording repair {} OUT",
                                            record::first_fault(scanned), options.file));
  return {};
}

Expected<void> check(const RecordingArguments& options) {
  const auto source = record::open_source(options.file);
  if (!source) return tl::unexpected(source.error());
  record::ScanHandler nobody;
  const auto scanned = record::scan(**source, {}, nobody);
  if (!scanned) return tl::unexpected(scanned.error());
  if (!options.json.empty())
    if (auto written = write_json(options.json, record::check_json(*scanned)); !written) return written;
  if (!scanned->complete)
    return refused("{}: is not sound{}; palpate recording repair {} OUT keeps what is", options.file,
                   record::first_fault(*scanned), options.file);
  if (options.json != "-")
    print_line(fmt::format("{}: sound: {} in {}; every length, CRC, index and count is right", options.file,
                           counted(scanned->found.messages, "message"),
                           counted(scanned->found.chunks, "chunk")));
  return {};
}

// The original is not written over: what is lost in the copy is lost for good.
Expected<void> apart(const RecordingArguments& options) {
  if (options.out != "-" && same_file(options.file, options.out))
    return wrong_use("{}: is the recording itself; give the result a file of its own", options.out);
  return {};
}

bool replaces(const RecordingArguments& options) { return options.out != "-" && is_there(options.out); }

void tell_replaced(const RecordingArguments& options) {
  notice(fmt::format("{}: replaced the file of that name", options.out));
}

std::FILE* stream_beside(const std::string& out) { return out == "-" ? stderr : stdout; }

Expected<void> repair(const RecordingArguments& options) {
  if (auto fine = apart(options); !fine) return fine;
  const auto source = record::open_source(options.file);
  if (!source) return tl::unexpected(source.error());
  const bool replaced = replaces(options);
  const auto done = record::repair(**source, options.out);
  if (!done) return tl::unexpected(done.error());
  if (replaced) tell_replaced(options);
  const auto& scanned = done->scanned;
  std::FILE* const stream = stream_beside(options.out);
  print_line(fmt::format("kept         {}, {}, {:.3f} s", counted(done->written.messages, "message"),
                         counted(done->written.attachments, "attachment"), record::seconds_of(done->written)),
             stream);
  if (scanned.complete) {
    print_line("lost         nothing: the recording was sound", stream);
    return {};
  }
  print_line(fmt::format("lost         {:.3f} s as far as it can be told, {} in {}, {} damaged",
                         scanned.lost_s, counted(scanned.lost_bytes, "byte"),
                         counted(scanned.fault_count, "fault"), counted(scanned.lost_chunks, "chunk")),
             stream);
  for (const auto& fault : scanned.faults)
    print_line(fmt::format("fault        byte {}: {}", fault.offset, fault.words), stream);
  return {};
}

Expected<void> cut(const RecordingArguments& options) {
  if (options.cut.to_s < options.cut.from_s)
    return wrong_use("--to {}: lies before --from {}; a later time is expected", options.cut.to_s,
                     options.cut.from_s);
  if (auto fine = apart(options); !fine) return fine;
  const auto source = record::open_source(options.file);
  if (!source) return tl::unexpected(source.error());
  const bool replaced = replaces(options);
  const auto done = record::cut(**source, options.out, options.cut);
  if (!done) return tl::unexpected(done.error());
  if (replaced) tell_replaced(options);
  print_line(fmt::format("kept         {} of {}, {:.3f} s of {:.3f} s", done->written.messages,
                         counted(done->scanned.found.messages, "message"), record::seconds_of(done->written),
                         record::seconds_of(done->scanned.found)),
             stream_beside(options.out));
  return {};
}

// OUT comes first where several files follow: forgotten, it would be the first of them.
Expected<void> is_new(const RecordingArguments& options) {
  if (options.out == "-" || !is_there(options.out)) return {};
  return wrong_use(
      "{}: exists already; OUT, the new recording, comes first: choose another name or remove it",
      options.out);
}

Expected<void> merge(const RecordingArguments& options) {
  for (const auto& file : options.files)
    if (options.out != "-" && same_file(file, options.out))
      return wrong_use("{}: is one of the recordings; give the result a file of its own", options.out);
  if (auto fine = is_new(options); !fine) return fine;
  const auto written = record::merge(options.files, options.out);
  if (!written) return tl::unexpected(written.error());
  print_line(fmt::format("kept         {}, {}, {:.3f} s", counted(written->messages, "message"),
                         counted(written->attachments, "attachment"), record::seconds_of(*written)),
             stream_beside(options.out));
  return {};
}

// The recording's own times of a part of it.
Expected<record::ScanOptions> part_of(const RecordingArguments& options) {
  record::ScanOptions part;
  part.topics = options.cut.topics;
  const auto source = record::open_source(options.file);
  if (!source) return tl::unexpected(source.error());
  const auto info = record::info(**source);
  if (!info) return tl::unexpected(info.error());
  part.from_ns = record::later(info->scanned.found.start_ns, options.cut.from_s);
  part.to_ns = record::later(info->scanned.found.start_ns, options.cut.to_s);
  return part;
}

// "pointer=Stylus"
Expected<std::pair<device::MarkerId, std::string>> named_body(const std::string& text) {
  const auto equals = text.find('=');
  const std::string marker = text.substr(0, equals),
                    name = equals == std::string::npos ? "" : text.substr(equals + 1);
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
  };
  if (name.empty() || !std::all_of(name.begin(), name.end(), plain) || name[0] < 'A' || name[0] > 'Z')
    return wrong_use("--igs-name {}: MARKER=Name is expected, Name of letters and digits and a capital first",
                     excerpt(text));
  if (const auto known = device::marker_named(marker)) return std::pair(*known, name);
  return wrong_use("--igs-name {}: tip_marker, camera_marker or pointer is expected before '='",
                   excerpt(text));
}

Expected<void> export_igs_mha(const RecordingArguments& options) {
  record::session::SequenceOptions how;
  how.span = {options.cut.from_s, options.cut.to_s};
  how.camera = options.camera;
  how.decode = jpeg_decoder();
  for (const auto& text : options.names) {
    const auto named = named_body(text);
    if (!named) return tl::unexpected(named.error());
    how.names[named->first] = named->second;
  }
  if (!options.rig.empty()) {
    const auto rig = rig::read_rig(options.rig);
    if (!rig) return tl::unexpected(rig.error());
    if (rig->delays) how.camera_after_tracker_s = rig->delays->camera_after_tracker_s;
  }
  const auto report = record::session::export_sequence(options.file, options.sequence, how);
  if (!report) return tl::unexpected(report.error());
  std::FILE* const stream = stream_beside(options.sequence);
  print_line(fmt::format("{:>9}    pictures of {} x {} px in {}", report->frames, report->width,
                         report->height, options.sequence),
             stream);
  for (const auto& [name, counts] : report->transforms)
    print_line(fmt::format("{:>9}    of them with {}", counts.valid, name), stream);
  if (report->transforms.empty()) notice("no marker was heard of: pictures alone");
  if (report->left_out > 0)
    notice(fmt::format("{} of another size left out", counted(report->left_out, "picture")));
  return {};
}

Expected<void> export_parts(const RecordingArguments& options) {
  namespace session = record::session;
  if (options.csv.empty() && options.tum.empty() && options.attachments.empty() && options.sequence.empty())
    return wrong_use(
        "recording export: --csv DIR, --tum DIR, --attachments DIR or --igs-mha FILE is expected");
  if (!options.sequence.empty())
    if (auto done = export_igs_mha(options); !done) return done;
  const auto part = part_of(options);
  if (!part) return tl::unexpected(part.error());
  const auto tell = [](const std::string& folder,
                       const Expected<session::ExportReport>& report) -> Expected<void> {
    if (!report) return tl::unexpected(report.error());
    for (const auto& [file, rows] : report->rows)
      print_line(fmt::format("{:>9}    {}/{}", rows, folder, file));
    for (const auto& [topic, messages] : report->left_out)
      notice(fmt::format("{}: {} messages are not protobuf and are left out", excerpt(topic, 100), messages));
    if (report->unread > 0)
      notice(fmt::format("{} messages are none of their schema and are left out", report->unread));
    return {};
  };
  if (!options.csv.empty())
    if (auto done = tell(options.csv, session::export_csv(options.file, options.csv, *part)); !done)
      return done;
  if (!options.tum.empty())
    if (auto done = tell(options.tum, session::export_tum(options.file, options.tum, *part)); !done)
      return done;
  if (options.attachments.empty()) return {};
  return tell(options.attachments, session::export_attachments(options.file, options.attachments));
}

void add_part_options(CLI::App& command, record::Cut& cut) {
  command.add_option("--from", cut.from_s, "Seconds after the recording's first message")
      ->check(at_least_zero());
  command.add_option("--to", cut.to_s, "Seconds after the recording's first message; default: its end")
      ->check(at_least_zero());
  command.add_option("--topic", cut.topics, "This topic, as often as there are some; default: all")
      ->allow_extra_args(false);
}

void add_export(CLI::App& recording, const std::shared_ptr<RecordingArguments>& options) {
  auto* command = recording.add_subcommand("export", "Write its streams as tables that other programs read");
  command->add_option("FILE", options->file, "The recording (MCAP)")->required();
  command->add_option("--csv", options->csv, "A CSV table of each topic, with all digits")->type_name("DIR");
  command
      ->add_option("--tum", options->tum, "Poses of markers and camera: time x y z qx qy qz qw, in s and m")
      ->type_name("DIR");
  command->add_option("--attachments", options->attachments, "The files that it holds: rig, scene")
      ->type_name("DIR");
  command
      ->add_option("--igs-mha", options->sequence,
                   "A camera's pictures with the markers' transforms beside each: sequence metafile of PLUS "
                   "and Slicer")
      ->type_name("FILE");
  command->add_option("--igs-camera", options->camera, "... which camera")
      ->check(one_of({"left", "right"}))
      ->capture_default_str();
  command
      ->add_option("--igs-name", options->names,
                   "... what a marker is called: pointer=Stylus gives StylusToTrackerTransform")
      ->type_name("MARKER=Name")
      ->allow_extra_args(false);
  command->add_option("--rig", options->rig, "... the rig whose delay between camera and tracker counts")
      ->type_name("FILE");
  add_part_options(*command, options->cut);
  on(command, [options] { return export_parts(*options); });
}

// "pivot=pivot1.csv"; without a name the file's own.
Expected<void> import_tables(const RecordingArguments& options) {
  if (auto fine = is_new(options); !fine) return fine;
  std::vector<std::pair<std::string, std::string>> tables;
  for (const auto& argument : options.files) {
    const std::string text = argument.string();
    const auto equals = text.find('=');
    const std::filesystem::path file = equals == std::string::npos ? text : text.substr(equals + 1);
    const std::string name = equals == std::string::npos ? file.stem().string() : text.substr(0, equals);
    const auto content = read_file(file);
    if (!content) return tl::unexpected(content.error());
    if (auto table = parse_csv(*content, file.filename().string(), {.text_columns = {"*"}}); !table)
      return tl::unexpected(table.error());
    tables.emplace_back(name, *content);
  }
  if (auto done = record::session::write_tables(options.out, tables); !done) return done;
  print_line(fmt::format("kept         {}", counted(tables.size(), "table")), stream_beside(options.out));
  return {};
}

void add_import(CLI::App& recording, const std::shared_ptr<RecordingArguments>& options) {
  auto* command = recording.add_subcommand(
      "import",
      "Write a recording of tables, for the calibrations' --recording; export --attachments gives them back");
  command->add_option("OUT", options->out, "The new recording (- = standard output)")->required();
  command
      ->add_option("TABLES", options->files,
                   "Tables (CSV), NAME=FILE each: arm, arm_test, pivot, pointer_pivot, surface, landmarks, "
                   "corners, hand, eye, "
                   "from, to, points_a, points_b")
      ->required()
      ->expected(1, 64);
  on(command, [options] { return import_tables(*options); });
}

void add_merge(CLI::App& recording, const std::shared_ptr<RecordingArguments>& options) {
  auto* command = recording.add_subcommand(
      "merge", "Write one recording of several that were made side by side, in the order of their times");
  command->add_option("OUT", options->out, "The new recording (- = standard output)")->required();
  command->add_option("FILES", options->files, "The recordings (MCAP)")->required()->expected(1, 64);
  on(command, [options] { return merge(*options); });
}

}  // namespace

void add_recording(CLI::App& program) {
  auto* recording =
      program.add_subcommand("recording", "Look into the recording of a session, mend it, take parts");
  recording->require_subcommand(1);
  auto options = std::make_shared<RecordingArguments>();
  const auto command = [&](const char* name, const char* help,
                           Expected<void> (*action)(const RecordingArguments&)) {
    auto* made = recording->add_subcommand(name, help);
    made->add_option("FILE", options->file, "The recording (MCAP)")->required();
    on(made, [options, action] { return action(*options); });
    return made;
  };
  const auto with_json = [&](CLI::App* made) {
    made->add_option("--json", options->json, "Write the same as JSON to FILE (- = standard output)")
        ->type_name("FILE");
  };
  const auto with_out = [&](CLI::App* made) {
    made->add_option("OUT", options->out, "The new recording, over one of that name (- = standard output)")
        ->required();
    return made;
  };
  with_json(command("info", "Streams, rates, what was dropped, and whether it is whole", show_info));
  with_json(command(
      "check", "Compare every length, CRC, index and count with what is there; exit 1 names the first fault",
      check));
  with_out(
      command("repair", "Write a whole recording of everything that is sound, and say what is lost", repair));
  auto* part = with_out(command("cut", "Write a recording of some time and some topics", cut));
  add_part_options(*part, options->cut);
  add_merge(*recording, options);
  add_export(*recording, options);
  add_import(*recording, options);
}

}  // namespace palpate::tools::commands
