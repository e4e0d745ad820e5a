// palpate convert: files of other programs into files of ours, and back.
#include <fmt/format.h>

#include <memory>

#include "palpate/core/file.h"
#include "palpate/core/text.h"
#include "palpate/device/pose_file.h"
#include "palpate/formats/read.h"
#include "palpate/formats/write.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"

namespace palpate::tools::commands {
namespace {

struct ConvertArguments {
  formats::ReadOptions read;
  std::string in, out, to, unit;
  bool invert = false;
};

// "107 poses", and what was left out of them.
std::string counts_of(const formats::Content& content) {
  if (const auto* poses = std::get_if<formats::Poses>(&content.value))
    return counted(poses->poses.size(), "pose") +
           (poses->left_out > 0
                ? fmt::format(", {} left out in which the body was hidden", counted(poses->left_out, "row"))
                : "") +
           (poses->has_time ? "" : ", without times");
  if (const auto* points = std::get_if<formats::Points>(&content.value))
    return counted(points->places.size(), "point");
  if (const auto* lens = std::get_if<formats::Lens>(&content.value))
    return lens->size ? "a lens" : "a lens, without the picture's size";
  return "a transform";
}

// Who names a unit and is not heard has lengths a thousand times too large.
Expected<void> check_unit_counts(const ConvertArguments& options, const formats::Content& content,
                                 const formats::WrittenForm& form) {
  if (options.unit.empty()) return {};
  auto other = options.read;
  other.metres_per_unit = 0.0;
  if (!formats::read(options.in, other)) return {};  // it is needed, also where all lengths are 0
  other.metres_per_unit = options.read.metres_per_unit == 1.0 ? 1e-3 : 1.0;
  const auto again = formats::read(options.in, other);
  if (!again) return {};
  const auto with = formats::text_of(content, form), without = formats::text_of(*again, form);
  if (!with || !without || *with != *without) return {};
  return wrong_use(
      "--unit {}: {} is {}, which has a unit of its own ({}); leave --unit out, or check the form (--from)",
      options.unit, options.in, content.form, content.told);
}

// B in A becomes A in B.
Expected<void> invert(formats::Content& content, const std::string& source) {
  if (auto* poses = std::get_if<formats::Poses>(&content.value))
    poses->poses = device::inverted(std::move(poses->poses));
  else if (auto* transform = std::get_if<formats::Transform>(&content.value))
    transform->matrix = Eigen::Matrix4d(transform->matrix.inverse());
  else
    return wrong_use("{}: is {}; --invert needs poses or a transform", source, content.form);
  if (const auto* transform = std::get_if<formats::Transform>(&content.value);
      transform && !transform->matrix.allFinite())
    return wrong_use("{}: is a transform without an inverse; check its numbers", source);
  return {};
}

Expected<void> convert(ConvertArguments& options) {
  if (!options.unit.empty()) options.read.metres_per_unit = options.unit == "mm" ? 1e-3 : 1.0;
  const auto form = formats::written_form(options.out, options.to);
  if (!form) return tl::unexpected(form.error());
  if (options.out != "-" && same_file(options.in, options.out))
    return wrong_use("{}: is the file that is read; another name is expected for the new one", options.out);
  auto content = formats::read(options.in, options.read);
  if (!content) return tl::unexpected(content.error());
  if (auto counts = check_unit_counts(options, *content, *form); !counts) return counts;
  if (options.invert)
    if (auto done = invert(*content, options.in); !done) return done;
  const auto text = formats::text_of(*content, *form);
  if (!text) return wrong_use("{}: {}", options.in, text.error().message);
  if (auto written = write_file(options.out, *text); !written) return written;
  print_line(fmt::format("{}: {} ({})", options.in, content->form, content->told), stderr);
  print_line(fmt::format("{}: {}; {}{}", options.out, form->told, counts_of(*content),
                         options.invert ? "; turned round" : ""),
             stderr);
  return {};
}

}  // namespace

void add_convert(CLI::App& program) {
  auto options = std::make_shared<ConvertArguments>();
  auto* command = program.add_subcommand("convert",
                                         "Read a file of another program: poses, points, a lens or a "
                                         "transform; write it as one of ours, or of others");
  command->add_option("in", options->in, "File to read; its form is found by what is in it")
      ->required()
      ->type_name("IN");
  command
      ->add_option("out", options->out,
                   "File to write, in place of one that is there; its ending says the form")
      ->required()
      ->type_name("OUT");
  command
      ->add_option("--from", options->read.form,
                   "Form of the file to read, where it cannot be found by itself")
      ->check(one_of(formats::form_names()));
  std::vector<std::string> names;
  for (const auto& form : formats::written_forms()) names.push_back(form.name);
  command->add_option("--to", options->to, "Form of the new file, whatever its ending")->check(one_of(names));
  command
      ->add_option("--tool,--transform", options->read.tool,
                   "Which body, where a file holds several; of a sequence a transform AToB")
      ->type_name("NAME");
  command->add_flag(
      "--invert", options->invert,
      "Turn every pose or the transform round: the board in the camera becomes the camera in the board");
  command->add_option("--unit", options->unit, "Unit of lengths, where a file does not say it")
      ->check(one_of({"mm", "m"}));
  on(command, [options] { return convert(*options); });
}

}  // namespace palpate::tools::commands
